#!/usr/bin/env python3
"""Picture and table of `quoin validate --convergence --json`: errors against time step and penalty.

    tools/plot_convergence.py convergence.json OUT.png [TABLE.md]

One panel a case. Slanted grey lines show the orders 1 and 2; an open mark is below the floor of its
series, where rounding or tolerance takes over.
"""
import argparse
import json
import pathlib

import plot  # colours, marks and style of all pictures
import matplotlib.pyplot as plt
import numpy as np

LEAST = 1e-17  # an error of nothing is drawn here


def slopes(axis, orders, falling):
    """Lines of the given orders from the middle of the panel, in the background."""
    (x0, x1), (y0, y1) = axis.get_xlim(), axis.get_ylim()
    x = np.geomspace(x0, x1, 2)
    for order in orders:
        for shift in np.linspace(-6, 6, 7):
            middle = np.sqrt(y0 * y1) * (y1 / y0) ** (shift / 6)
            y = middle * (x / np.sqrt(x0 * x1)) ** (-order if falling else order)
            axis.plot(x, y, color="#dcdcdc", linewidth=0.7, linestyle="-" if order == 1 else ":",
                      zorder=0)
    axis.set_xlim(x0, x1)
    axis.set_ylim(y0, y1)


def panel(axis, title, series):
    penalty = series[0]["refined"] == "penalty"
    for i, one in enumerate(series):
        x = np.array(one["values"][:len(one["errors"])])
        y = np.maximum(one["errors"], LEAST)
        below = y <= max(one["floor"], LEAST)
        colour = plot.COLOURS[(3, 0, 4, 1)[i % 4]]
        axis.loglog(x, y, color=colour, linewidth=1)
        axis.loglog(x[~below], y[~below], "o", color=colour, markersize=4.5)
        axis.loglog(x[below], y[below], "o", color=colour, markersize=4.5, fillstyle="none")
        order = f": order {one['order']:.2f}" if one["order"] is not None else ": at its floor"
        axis.plot([], [], color=colour, marker="o", markersize=4,
                  label=one["quantity"].removesuffix(", rel.") + order)
    axis.set_title(title, fontsize=10)
    axis.set_xlabel("penalty (N/m)" if penalty else "time step (s)", fontsize=8)
    axis.tick_params(labelsize=7)
    low, high = axis.get_ylim()
    axis.set_ylim(low / 2, high * max(high / low, 1e4) ** (0.05 + 0.1 * len(series)))  # room for the legend
    slopes(axis, (1,) if penalty else (1, 2), penalty)
    axis.legend(loc="upper left", fontsize=6.5, frameon=True, edgecolor="none", framealpha=0.8)


def panels(series):
    """{(case, refined): [series]} in their order."""
    found = {}
    for one in series:
        found.setdefault((one["case"], one["refined"]), []).append(one)
    return found


def picture(series, path):
    groups = panels(series)
    columns = 3
    rows = (len(groups) + columns - 1) // columns
    figure, axes = plt.subplots(rows, columns, figsize=(4.1 * columns, 3.1 * rows),
                                layout="constrained", squeeze=False)
    for axis in axes.flat:
        axis.set_visible(False)
    for axis, ((case, refined), group) in zip(axes.flat, groups.items()):
        axis.set_visible(True)
        panel(axis, f"{case}, error against {'penalty' if refined == 'penalty' else 'time step'}",
              group)
    plot.save(figure, path)


def table(series):
    lines = ["| case | quantity | refined | from … to | error from … to | order | expected | floor "
             "| reached at | ok |", "|---|---|---|---|---|---|---|---|---|---|"]
    for one in series:
        unit = "N/m" if one["refined"] == "penalty" else "s"
        order = f"{one['order']:.2f}" if one["order"] is not None else "at its floor"
        stops = f"{one['stops_at']:.3g}" if one["stops_at"] is not None else "not reached"
        lines.append(
            f"| {one['case']} | {one['quantity']} | {one['refined'].replace('_', ' ')} "
            f"| {one['values'][0]:.3g} … {one['values'][-1]:.3g} {unit} "
            f"| {one['errors'][0]:.1e} … {one['errors'][-1]:.1e} | {order} "
            f"| {one['expected_order']:g} | {one['floor']:.0e} | {stops} "
            f"| {'yes' if one['ok'] else 'NO'} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("series")
    parser.add_argument("picture")
    parser.add_argument("table", nargs="?")
    given = parser.parse_args()
    series = json.loads(pathlib.Path(given.series).read_text(encoding="utf-8"))
    picture(series, given.picture)
    if given.table:
        pathlib.Path(given.table).write_text(table(series), encoding="utf-8")


if __name__ == "__main__":
    main()
