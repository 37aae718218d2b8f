#!/usr/bin/env python3
"""Heat map of `quoin stability --json` and its table.

    quoin stability --json > stability.json; tools/plot_stability.py stability.json OUT.png [OUT.md]

Colour: error over what is allowed (log10). F: flagged, as is expected (f: right all the same); W: wrong,
flagged otherwise than expected, or not converged.
"""
import json
import math
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402


def rows_of(cells):
    """{parameter: {row name: [(value, cell)]}} in the order of the file."""
    table = {}
    for cell in cells:
        parameter, name = cell["cell"].split(" / ", 1)
        value = cell["parameters"][parameter]
        table.setdefault(parameter, {}).setdefault(name, []).append((value, cell))
    return table


def mark(cell):
    if cell["verdict"] not in ("right", "flagged"):
        return "W"
    if cell["verdict"] == "flagged":
        return "f" if cell["error"] is not None and cell["error"] <= cell["allowed"] else "F"
    return ""


def ratio(cell):
    if cell["error"] is None:
        return 6.0
    return math.log10(max(cell["error"] / cell["allowed"], 1e-8))


def picture(table, path):
    heights = [len(rows) for rows in table.values()]
    figure, axes = plt.subplots(len(table), 1, figsize=(9, 0.32 * sum(heights) + 0.85 * len(heights)),
                                height_ratios=heights, layout="constrained")
    for axis, (parameter, rows) in zip(np.atleast_1d(axes), table.items()):
        values = sorted({value for row in rows.values() for value, _ in row})
        grid = np.full((len(rows), len(values)), np.nan)
        for r, row in enumerate(rows.values()):
            for value, cell in row:
                column = values.index(value)
                grid[r, column] = ratio(cell)
                axis.text(column, r, mark(cell), ha="center", va="center", fontsize=7,
                          fontweight="bold")
        image = axis.imshow(grid, aspect="auto", cmap="RdYlBu_r", vmin=-6, vmax=6)
        axis.set_yticks(range(len(rows)), list(rows), fontsize=7)
        axis.set_xticks(range(len(values)), [f"{v:g}" for v in values], fontsize=6)
        axis.set_title(parameter, fontsize=8, loc="left")
        axis.tick_params(length=0)
    figure.colorbar(image, ax=axes, shrink=0.3, label="log10(error / allowed)")
    figure.savefig(path, dpi=110)


def markdown(cells, table):
    count = {v: sum(c["verdict"] == v for c in cells) for v in ("right", "flagged")}
    count["failed"] = len(cells) - count["right"] - count["flagged"]
    right_flagged = sum(mark(c) == "f" for c in cells)
    lines = [f"{len(cells)} cells: {count['right']} right, {count['flagged']} flagged "
             f"as expected ({right_flagged} of them right all the same), {count['failed']} wrong, flagged "
             "otherwise or not converged; "
             f"{sum(c['seconds'] for c in cells):.0f} s.", "",
             "| varied | scene | from … to | worst error (right) | allowed | most solves a step (right) "
             "| flagged at | failed at |", "|---|---|---|---|---|---|---|---|"]
    for parameter, rows in table.items():
        for name, row in rows.items():
            right = [c for _, c in row if c["verdict"] == "right"]
            worst = f"{max(c['error'] for c in right):.1e}" if right else "-"
            solves = f"{max(c['solves_per_step'] for c in right):.2g}" if right else "-"
            flagged = ", ".join(f"{x:g}" for x, c in row if c["verdict"] == "flagged")
            failed = ", ".join(f"{x:g}" for x, c in row if c["verdict"] not in ("right", "flagged"))
            lines.append(f"| {parameter} | {name} | {row[0][0]:g} … {row[-1][0]:g} | {worst} | "
                         f"{row[0][1]['allowed']:g} | {solves} | {flagged} | {failed} |")
    return "\n".join(lines) + "\n"


def main():
    cells = json.loads(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8"))
    table = rows_of(cells)
    picture(table, sys.argv[2])
    if len(sys.argv) > 3:
        pathlib.Path(sys.argv[3]).write_text(markdown(cells, table), encoding="utf-8")


if __name__ == "__main__":
    main()
