#!/usr/bin/env python3
"""Pictures and tables of tools/large.py: error against CPU time; CPU time by phase against bricks.

    tools/plot_large.py LARGE.json FOLDER      FOLDER: large_errors.png, large_phases.png, rest.md, peers.md,
                                               moving.md
"""
import json
import math
import pathlib
import sys

import plot  # colours, marks and style of all pictures
import matplotlib.pyplot as plt
import numpy as np

LEAST = 1e-16  # less is drawn here
QUOIN, PEERS = "#0072B2", {"Bullet SI 10": "#E69F00", "Bullet SI 50": "#D55E00", "Bullet SI 250": "#8C2D04",
                           "ODE quick 50": "#777777"}
ERRORS = {"drift": "drift (m)", "unbalance": "unbalance, by the weight"}
PHASES = {"detect": "contact search", "assemble": "assembly", "solve": "solutions", "update": "update"}

# Of an iteration: half sweeps there and back and the product that follows (solver/README.md, "Linear systems").
PRODUCTS = 2.5
BLOCK = 36  # numbers


def settled(runs):
    """Of each wall the run on most threads."""
    best = {}
    for run in runs:
        if run[0]["threads"] >= best.get(run[0]["bricks"], run)[0]["threads"]:
            best[run[0]["bricks"]] = run
    return [best[bricks] for bricks in sorted(best)]


def phases(row):
    """CPU seconds by phase: the CPU time in the shares that the phases have of the time on the clock."""
    clock = sum(row[f"{phase}_s"] for phase in PHASES)
    return {phase: row["cpu_s"] * row[f"{phase}_s"] / clock for phase in PHASES}


def errors_picture(result, path):
    walls = [run[0]["bricks"] for run in settled(result["rest"])]
    figure, axes = plt.subplots(2, len(walls), figsize=(3.3 * len(walls), 6.2), layout="constrained", sharey="row")
    for column, bricks in enumerate(walls):
        curves = [("quoin", run) for run in settled(result["rest"]) if run[0]["bricks"] == bricks]
        curves += [(run[0]["code"], run) for run in result["peers"] if run and run[0]["bricks"] == bricks]
        for axis, (quantity, words) in zip(axes[:, column], ERRORS.items()):
            for code, run in curves:
                ours = code == "quoin"
                axis.loglog([row["cpu_s"] for row in run], [max(row[quantity], LEAST) for row in run],
                            color=QUOIN if ours else PEERS[code], marker="o", markersize=5 if ours else 2.5,
                            linewidth=1, label=code)
            axis.set_xlabel("CPU s")
            if column == 0:
                axis.set_ylabel(words)
        axes[0][column].set_title(f"{bricks} bricks")
    axes[0][0].legend(fontsize=7)
    plot.save(figure, path)


def phases_picture(result, path):
    rows = [run[0] for run in settled(result["rest"])]
    bricks = np.array([row["bricks"] for row in rows])
    figure, axes = plt.subplots(1, 2, figsize=(10.5, 4.4), layout="constrained")
    for number, (phase, words) in enumerate(PHASES.items()):
        axes[0].loglog(bricks, [phases(row)[phase] for row in rows], label=words, color=plot.COLOURS[(3, 4, 1, 2)[number]],
                       marker=plot.MARKERS[number], linewidth=1.2)
    iterated = [row for row in rows if row["iterations"] > 0]
    for number, words in enumerate(("products: read from memory", "products: arithmetic")):
        axes[0].loglog([row["bricks"] for row in iterated], [limits(row, result["machine"])[number] for row in iterated],
                       color="#555555", linestyle=("--", ":")[number], label=f"least, {words}")
    axes[0].set(xlabel="bricks", ylabel="CPU s, first step", title="time by phase")
    axes[0].legend(fontsize=8)
    axes[1].semilogx(bricks, [1e3 * row["peak_mb"] / row["bricks"] for row in rows], color=QUOIN, marker="o", label="peak")
    axes[1].axhline(6, color="#555555", linestyle="--", label="goal")
    axes[1].set(xlabel="bricks", ylabel="kB a brick", title="memory", ylim=(0, None))
    axes[1].legend(fontsize=8)
    plot.save(figure, path)


def number(value):
    return f"{value:.3g}"


def rest_table(result):
    lines = ["| bricks | threads | CPU s | s on the clock | solutions' share | solves | peak MB | drift m | unbalance |",
             "|---|" + "---|" * 8]
    for run in result["rest"]:
        row = run[0]
        clock = sum(row[f"{phase}_s"] for phase in PHASES)
        lines.append(f"| {row['bricks']} | {row['threads']} | {number(row['cpu_s'])} | {number(clock)} "
                     f"| {row['solve_s'] / clock:.2f} | {row['solves']} | {row['peak_mb']:.0f} "
                     f"| {row['drift']:.1e} | {row['unbalance']:.1e} |")
    return "\n".join(lines + ["", growth(result)]) + "\n"


def growth(result):
    rows = [run[0] for run in settled(result["rest"])][1:]
    words = [f"{math.log(b['cpu_s'] / a['cpu_s']) / math.log(b['bricks'] / a['bricks']):.2f} from {a['bricks']} to "
             f"{b['bricks']}" for a, b in zip(rows, rows[1:])]
    if len(rows) > 2:
        a, b = rows[0], rows[-1]
        words.append(f"{math.log(b['cpu_s'] / a['cpu_s']) / math.log(b['bricks'] / a['bricks']):.2f} in all (goal 1.15)")
    machine = result["machine"]
    return (f"CPU time grows with the power of the bricks: {', '.join(words)}. A core reads {machine['read_1'] / 1e9:.0f} GB/s "
            f"from memory, two {machine['read_2'] / 1e9:.0f}; a core multiplies blocks at {machine['block_flops'] / 1e9:.0f} Gflop/s.")


def peers_table(result):
    lines = ["| bricks | code | steps | CPU s | drift m | unbalance |", "|---|---|---|---|---|---|"]
    ends = [run[0] for run in settled(result["rest"])] + [run[-1] for run in result["peers"] if run]
    for row in ends:
        lines.append(f"| {row['bricks']} | {row['code']} | {row['step']} | {number(row['cpu_s'])} "
                     f"| {row['drift']:.1e} | {row['unbalance']:.1e} |")
    head, rows = lines[:2], lines[2:]
    rows.sort(key=lambda line: int(line.split("|")[1]))
    return "\n".join(head + rows) + "\n"


def moving_table(result):
    """quoin beside Bullet; then how CPU time grows with the shaken walls."""
    lines = ["| scene | steps | code | CPU s a step | factorizations a step | largest overlap m | energy growth "
             "| CPU by Bullet's |", "|---|" + "---|" * 7]
    rows = result["shaken"] + result["moving"]
    bullet = {row["scene"]: row["cpu_ms_per_step"] for row in rows if row["code"] != "quoin"}
    for row in rows:
        ours, steps = row["code"] == "quoin", round(row["time"] / row["time_step"])
        cells = [number(1e-3 * row["cpu_ms_per_step"]), number(row["factorizations_per_step"]) if ours else "",
                 f"{row['overlap']:.1e}", f"{row['energy_growth']:.0e}",
                 plot.ratio(row["cpu_ms_per_step"] / bullet[row["scene"]]) if ours and row["scene"] in bullet else ""]
        if steps == 0:  # its limit was over in the first one
            cells = [f"> {cells[0]}", "", "", "", f"> {cells[4]}" if cells[4] else ""]
        lines.append(f"| {row['scene'] if ours else ''} | {steps}{', gave up' if row['gave_up'] else ''} "
                     f"| {row['code']} | {' | '.join(cells)} |")
    walls = [row for row in result["shaken"] if row["code"] == "quoin"]
    words = [f"{power(a, b):.2f} from {a['blocks']} to {b['blocks']}" for a, b in zip(walls, walls[1:])]
    if len(walls) > 2:
        words.append(f"{power(walls[1], walls[-1]):.2f} in all from {walls[1]['blocks']} on (goal 1.15)")
    lines += ["", f"Shaken walls: quoin's CPU time a step grows with the power of the bricks: {', '.join(words)}."]
    return "\n".join(lines) + "\n"


def power(a, b):
    return math.log(b["cpu_ms_per_step"] / a["cpu_ms_per_step"]) / math.log(b["blocks"] / a["blocks"])


def main():
    result = json.loads(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8"))
    folder = pathlib.Path(sys.argv[2])
    errors_picture(result, folder / "large_errors.png")
    phases_picture(result, folder / "large_phases.png")
    (folder / "rest.md").write_text(rest_table(result), encoding="utf-8")
    (folder / "peers.md").write_text(peers_table(result), encoding="utf-8")
    (folder / "moving.md").write_text(moving_table(result), encoding="utf-8")


if __name__ == "__main__":
    main()
