#!/usr/bin/env python3
"""Picture and tables of tools/moving.py: CPU time to a given error, performance profiles.

    tools/plot_moving.py PEERS.json PROBLEMS.csv MOVING.png FOLDER      FOLDER: peers.md, problems.md
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
RESIDUALS = (1e-3, 1e-6)  # that the performance profiles ask for
FACTORS = (1, 2, 4, 16)
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
        for i, (second, value, row) in enumerate(zip(seconds, values, points)):
            # On the floor all codes lie on one line, where labels would cover each other.
            if value > LEAST[quantity] and (ours or number == len(codes) - 1):
                axis.annotate(f"{1e3 * row['time_step']:g} ms", (second, value), fontsize=6.5, xytext=(3, 3 if i % 2 else -9),
                              textcoords="offset points", color="#555555")
    axis.set_ylabel(NAMES[quantity])


def costs(rows, key, residual):
    """{iteration: cost of each problem}: of the cheapest tolerance whose forces are as good; inf where none is."""
    table = {}
    for row in rows:
        of = table.setdefault(row["iteration"], {})
        problem = row["scene"], row["problem"]
        good = float(row["force_error"]) <= residual
        # No factorization at all counts as one: a factor of nothing says nothing.
        cost = max(float(row[key]), 1.0 if key == "factorizations" else 1e-6) if good else np.inf
        of[problem] = min(of.get(problem, np.inf), cost)
    return {iteration: np.array([of[problem] for problem in sorted(of)]) for iteration, of in table.items()}


def shares(cost, factor):
    """Share of the problems that each iteration solves within a factor of the best."""
    best = np.min(list(cost.values()), axis=0)
    return {iteration: np.mean(np.isfinite(of) & (of <= factor * best)) for iteration, of in cost.items()}


def profile(axis, rows, residual):
    factors = np.geomspace(1, 256, 200)
    for key, style, words in (("cpu_ms", "-", "CPU time"), ("factorizations", "--", "factorizations")):
        cost = costs(rows, key, residual)
        curves = [shares(cost, factor) for factor in factors]
        for number, iteration in enumerate(cost):
            axis.semilogx(factors, [curve[iteration] for curve in curves], style, base=2, linewidth=1.4,
                          color=plot.COLOURS[(3, 0, 4)[number]], label=f"{iteration.replace('_', ' ')}, {words}")
    axis.set(xlabel="factor of the best", ylabel="share solved", ylim=(0, 1.02),
             title=f"{len(next(iter(cost.values())))} contact problems, residual {residual:g}")
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
    for column, residual in enumerate(RESIDUALS):
        profile(figure.add_subplot(grid[2, column]), problems, residual)
    plot.save(figure, path)


def cell(row):
    if row["gave_up"]:
        return f"{row['code']}: gave up at {row['time']:.3g} s"
    words = f"{row['code']}: {row['cpu_ms_per_step']:.3g}; {row['overlap']:.1e}; {row['energy_growth']:.0e}"
    if "momentum_error" in row:
        words += f"; {row['momentum_error']:.0e}"
    return words + ("" if row["whole"] else f" (stopped at {row['time']:.2g} s)")


def peers_table(rows):
    lines = ["| scene | CPU ms a step; largest overlap m; energy growth; momentum error in 5 ms | CPU by Bullet's |",
             "|---|---|---|"]
    for scene in dict.fromkeys(row["scene"] for row in rows):
        of = [row for row in rows if row["scene"] == scene]
        cost = {row["code"]: row["cpu_ms_per_step"] for row in of}
        ratio = plot.ratio(cost["quoin"] / cost["Bullet SI 50"]) if {"quoin", "Bullet SI 50"} <= cost.keys() else "-"
        lines.append(f"| {scene} | {'<br>'.join(cell(row) for row in of)} | {ratio} |")
    return "\n".join(lines) + "\n"


def problems_table(rows):
    """To the tightest tolerance; then the profiles."""
    tightest = min({row["tolerance"] for row in rows}, key=float)
    lines = [f"| scene | problems | iteration, tolerance {float(tightest):g} | factorizations: median, largest "
             "| not ended | CPU ms, median | residual: median, largest | largest gap error m |",
             "|---|---|---|---|---|---|---|---|"]
    chosen = [row for row in rows if row["tolerance"] == tightest]
    for scene, iteration in dict.fromkeys((row["scene"], row["iteration"]) for row in chosen):
        of = [row for row in chosen if (row["scene"], row["iteration"]) == (scene, iteration)]
        column = {key: np.array([float(row[key]) for row in of])
                  for key in ("factorizations", "converged", "cpu_ms", "force_error", "gap_error_m")}
        lines.append(f"| {scene} | {len(of)} | {iteration} | {np.median(column['factorizations']):.0f}, "
                     f"{column['factorizations'].max():.0f} | {len(of) - column['converged'].sum():.0f} "
                     f"| {np.median(column['cpu_ms']):.2g} | {np.median(column['force_error']):.0e}, "
                     f"{column['force_error'].max():.0e} | {column['gap_error_m'].max():.0e} |")
    lines += ["", "| residual | share solved, by CPU time within | " + " | ".join(f"{f:g} x" for f in FACTORS)
              + " | at all |", "|---|---|" + "---|" * (len(FACTORS) + 1)]
    for residual in RESIDUALS:
        cost = costs(rows, "cpu_ms", residual)
        columns = [shares(cost, factor) for factor in (*FACTORS, np.inf)]
        for iteration in cost:
            lines.append(f"| {residual:g} | {iteration} | "
                         + " | ".join(f"{column[iteration]:.2f}" for column in columns) + " |")
    return "\n".join(lines) + "\n"


def main():
    result = json.loads(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8"))
    with open(sys.argv[2], encoding="utf-8") as file:
        problems = list(csv.DictReader(file))
    picture(result, problems, sys.argv[3])
    folder = pathlib.Path(sys.argv[4])
    (folder / "peers.md").write_text(peers_table(result["compared"]), encoding="utf-8")
    (folder / "problems.md").write_text(problems_table(problems), encoding="utf-8")


if __name__ == "__main__":
    main()
