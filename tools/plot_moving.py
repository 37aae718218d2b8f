#!/usr/bin/env python3
"""Pictures and table of tools/moving.py: CPU time to a given error, performance profile.

    tools/plot_moving.py PEERS.json PROBLEMS.csv MOVING.png TABLE.md
"""
import csv
import json
import pathlib
import sys

import plot  # colours, marks and style of all pictures
import matplotlib.pyplot as plt
import numpy as np

LEAST = {"overlap": 1e-15, "energy_growth": 1e-15}  # less is drawn here
NAMES = {"overlap": "largest overlap (m)", "energy_growth": "energy growth, by its scale"}
TOLERANCE = 1e-8  # of the performance profile
QUOIN, PEER_COLOURS = "#0072B2", ("#E69F00", "#D55E00", "#8C2D04", "#999999", "#555555")


def panel(axis, rows, quantity):
    codes = list(dict.fromkeys(row["code"] for row in rows))
    for number, code in enumerate(codes):
        points = sorted((row for row in rows if row["code"] == code), key=lambda row: -row["time_step"])
        seconds = [1e-3 * row["cpu_ms_per_step"] / row["time_step"] for row in points]
        values = [max(row[quantity], LEAST[quantity]) for row in points]
        ours = code == "quoin"
        axis.loglog(seconds, values, marker=plot.MARKERS[number], markersize=5, linewidth=1, label=code,
                    color=QUOIN if ours else PEER_COLOURS[number - 1], linestyle="-" if ours else ":",
                    fillstyle="full" if ours else "none")
        for second, value, row in zip(seconds, values, points):
            if ours or number == len(codes) - 1:
                axis.annotate(f"{1e3 * row['time_step']:g} ms", (second, value), fontsize=6.5, xytext=(3, 3),
                              textcoords="offset points", color="#555555")
    axis.set_ylabel(NAMES[quantity])


def profile(axis, rows):
    """Share of the problems that an iteration solves within a factor of the fewest factorizations, and of CPU time."""
    chosen = [row for row in rows if float(row["tolerance"]) == TOLERANCE]
    iterations = list(dict.fromkeys(row["iteration"] for row in chosen))
    factors = np.geomspace(1, 256, 200)
    for key, style in (("cpu_ms", "-"), ("factorizations", "--")):
        cost = {}
        for row in chosen:
            solved = int(row["converged"]) == 1
            cost.setdefault((row["scene"], row["problem"]), {})[row["iteration"]] = (
                max(float(row[key]), 1e-3) if solved else np.inf)
        best = np.array([min(of.values()) for of in cost.values()])
        for number, iteration in enumerate(iterations):
            ratio = np.array([of[iteration] for of in cost.values()])
            shares = [np.mean(np.isfinite(ratio) & (ratio <= factor * best)) for factor in factors]
            axis.semilogx(factors, shares, style, base=2, color=plot.COLOURS[(3, 0, 4)[number]], linewidth=1.4,
                          label=f"{iteration.replace('_', ' ')}, {'CPU time' if key == 'cpu_ms' else key}")
    axis.set(xlabel="factor of the best", ylabel="share solved", ylim=(0, 1.02),
             title=f"{len(cost)} contact problems to {TOLERANCE:g}")
    axis.legend(fontsize=7, loc="lower right")


def picture(result, problems, path):
    scenes = list(dict.fromkeys(row["scene"] for row in result["series"]))
    figure = plt.figure(figsize=(10.5, 9.2), layout="constrained")
    grid = figure.add_gridspec(3, 2)
    for column, scene in enumerate(scenes):
        rows = [row for row in result["series"] if row["scene"] == scene and row["whole"]]
        for line, quantity in enumerate(LEAST):
            axis = figure.add_subplot(grid[line, column])
            panel(axis, rows, quantity)
            if line == 0:
                axis.set_title(scene)
            axis.set_xlabel("CPU s a simulated second")
    axis.legend(fontsize=7)
    profile(figure.add_subplot(grid[2, :]), problems)
    plot.save(figure, path)


def cell(row):
    if row["gave_up"]:
        return f"{row['code']}: gave up at {row['time']:.3g} s"
    words = f"{row['code']}: {row['cpu_ms_per_step']:.3g}; {row['overlap']:.1e}; {row['energy_growth']:.0e}"
    if "momentum_error" in row:
        words += f"; {row['momentum_error']:.0e}"
    return words + ("" if row["whole"] else f" (stopped at {row['time']:.2g} s)")


def table(rows):
    lines = ["| scene | CPU ms a step; largest overlap m; energy growth; momentum error in 5 ms | CPU by Bullet's |",
             "|---|---|---|"]
    for scene in dict.fromkeys(row["scene"] for row in rows):
        of = [row for row in rows if row["scene"] == scene]
        cost = {row["code"]: row["cpu_ms_per_step"] for row in of}
        ratio = f"{cost['quoin'] / cost['Bullet SI 50']:.2g}" if {"quoin", "Bullet SI 50"} <= cost.keys() else "-"
        lines.append(f"| {scene} | {'<br>'.join(cell(row) for row in of)} | {ratio} |")
    return "\n".join(lines) + "\n"


def main():
    result = json.loads(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8"))
    with open(sys.argv[2], encoding="utf-8") as file:
        problems = list(csv.DictReader(file))
    picture(result, problems, sys.argv[3])
    pathlib.Path(sys.argv[4]).write_text(table(result["compared"]), encoding="utf-8")


if __name__ == "__main__":
    main()
