"""Pictures of the benchmarks; `tables.py` asks for them."""
import collections
import math
import pathlib
import sys

import numpy as np

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "tools"))
import plot  # noqa: E402  colours, marks and style of all pictures
import matplotlib.pyplot as plt  # noqa: E402
from tables import PHASES, RESIDUALS, costs, groups, mark, phases, settled, shares, stability_rows  # noqa: E402

QUOIN = "#0072B2"

# --- geometry

COLOURS = {"quoin": "#c1272d", "FCL libccd": "#1f77b4", "FCL indep": "#7fb2dd",
           "FCL tree": "#1f77b4", "libccd": "#6a51a3", "Bullet": "#2ca02c", "ODE": "#ff7f0e",
           "find": "#c1272d"}


def colour(peer):
    return next((c for start, c in COLOURS.items() if peer.startswith(start)), "#777777")


def times(result, path):
    chosen = [(w, [e for e in entries if not e["setting"] and e["nanoseconds"]
                   and "wrong answers" not in e["note"]])
              for w, entries in groups(result).items() if w[0] == "W" and w[1] != "6"]
    rows = max(1, math.ceil(len(chosen) / 4))
    figure, axes = plt.subplots(rows, 4, figsize=(17, 2.3 * rows))
    for axis in axes.flat[len(chosen):]:
        axis.set_visible(False)
    for axis, (workload, entries) in zip(axes.flat, chosen):
        entries = sorted(entries, key=lambda e: e["nanoseconds"], reverse=True)
        for row, e in enumerate(entries):
            axis.barh(row, e["nanoseconds"], color=colour(e["peer"]), height=0.75,
                      alpha=1.0 if e["wrong"] == 0 else 0.45)
            wrong = "" if e["wrong"] == 0 else f"  ({100 * e['wrong'] / e['pairs']:.1f} % wrong)"
            axis.text(e["nanoseconds"] * 1.1, row, f"{e['nanoseconds']:.0f}{wrong}", va="center", fontsize=7)
        axis.set_yticks(range(len(entries)), [e["peer"] for e in entries], fontsize=7)
        axis.set_xscale("log")
        times = [e["nanoseconds"] for e in entries]
        least, most = min(times) / 3, max(times)
        axis.set_xlim(least, most * (most / least) ** 0.8)  # room for the numbers, the same share everywhere
        axis.set_title(f"{workload}, ns a query", fontsize=9)
        axis.tick_params(axis="x", labelsize=7)
        for side in ("top", "right"):
            axis.spines[side].set_visible(False)
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    plt.close(figure)


# One panel for each kind of query.
PANELS = {"W1/box": "distance, boxes", "W2/64": "distance, 64 vertices", "W3/32": "distance in motion, 32 vertices",
          "W5/16": "depth, 16 vertices", "W4/box-overlap": "contact patch, boxes (area)",
          "W4/box-tilt-1e-3": "contact patch, boxes leaning by 1e-3 (area)",
          "W4/prism-overlap": "contact patch, prisms (area)", "W6/parallel": "distance, faces parallel within 1e-9"}


def errors(result, path):
    floor = 1e-20
    by_workload = groups(result)
    chosen = [(title, [e for e in by_workload[workload] if e["nanoseconds"] and not e["note"].startswith("on ")
                       and not e["peer"].startswith("published")])
              for workload, title in PANELS.items() if workload in by_workload]
    figure, axes = plt.subplots(2, 4, figsize=(15, 7.4), sharey=True, squeeze=False)
    for axis in axes.flat[len(chosen):]:
        axis.set_visible(False)
    for axis, (title, entries) in zip(axes.flat, chosen):
        for e in entries:
            low, high = max(e["error_median"], floor), max(e["error_max"], floor)
            shade = colour(e["peer"])
            axis.plot([e["nanoseconds"]] * 2, [low, high], color=shade, linewidth=1, alpha=0.6)
            axis.plot(e["nanoseconds"], high, marker="o", color=shade, markersize=4 if e["setting"] else 9)
            axis.plot(e["nanoseconds"], low, marker="_", color=shade, markersize=9)
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_xlim(20, 3e4)
        axis.set_ylim(floor / 10, 1e3)
        axis.grid(alpha=0.25)
        axis.set_title(title, fontsize=11)
        axis.set_xlabel("ns a query", fontsize=10)
    for axis in axes[:, 0]:
        axis.set_ylabel("error / size: median (bar) to largest (dot)", fontsize=10)
    shown = [name for name in COLOURS if any(e["peer"].startswith(name) for _, g in chosen for e in g)]
    handles = [plt.Line2D([], [], marker="o", linestyle="", color=COLOURS[n], label=n) for n in shown]
    figure.legend(handles=handles, loc="lower center", ncol=max(1, len(handles)), fontsize=11)
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    figure.savefig(path, dpi=80)
    plt.close(figure)


def broad(result, path):
    figure, axes = plt.subplots(1, 3, figsize=(15, 4.2))
    for axis, start in zip(axes, ("B/broad-jitter-", "B/broad-drift-", "B/find-")):
        lines = collections.defaultdict(list)
        for workload, entries in groups(result).items():
            if workload.startswith(start):
                for e in entries:
                    if e["nanoseconds"]:
                        lines[e["peer"]].append((int(workload[len(start):]), e["nanoseconds"]))
        for index, (peer, points) in enumerate(lines.items()):
            axis.plot(*zip(*points), marker="o", label=peer,
                      color=colour(peer) if start != "B/find-" else f"C{index}")
        axis.set_xscale("log")
        axis.set_yscale("log")
        shown = [time for points in lines.values() for _, time in points]
        if shown:  # whole decades: each has its label
            axis.set_ylim(10 ** math.floor(math.log10(min(shown))), 10 ** math.ceil(math.log10(max(shown))))
        axis.grid(alpha=0.25)
        unit = "pair" if start == "B/find-" else "brick"
        axis.set_title(f"{start[:-1]}: ns a {unit} and step", fontsize=9)
        axis.set_xlabel("bricks", fontsize=8)
        if lines:
            axis.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.18), ncol=4 if len(lines) > 3 else 3,
                        frameon=False)
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    plt.close(figure)


@plt.style.context("default")
def geometry(result, folder):
    times(result, folder / "times.png")
    errors(result, folder / "error_against_time.png")
    broad(result, folder / "walls.png")


# --- walls of 1e2 to 1e5 bricks

LEAST = 1e-16  # less is drawn here
PEERS = {"Bullet SI 10": "#E69F00", "Bullet SI 50": "#D55E00", "Bullet SI 250": "#8C2D04", "ODE quick 50": "#777777"}
ERRORS = {"drift": "drift (m)", "unbalance": "unbalance, by the weight"}


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
    axes[0].set(xlabel="bricks", ylabel="CPU s, first step", title="time by phase")
    axes[0].legend(fontsize=8)
    axes[1].semilogx(bricks, [1e3 * row["peak_mb"] / row["bricks"] for row in rows], color=QUOIN, marker="o", label="peak")
    axes[1].axhline(6, color="#555555", linestyle="--", label="goal")
    axes[1].set(xlabel="bricks", ylabel="kB a brick", title="memory", ylim=(0, None))
    axes[1].legend(fontsize=8)
    plot.save(figure, path)


def large(result, folder):
    errors_picture(result, folder / "large_errors.png")
    phases_picture(result, folder / "large_phases.png")


# --- many blocks that move at once

LEAST_OF = {"overlap": 1e-15, "energy_growth": 1e-15}  # less is drawn here
NAMES = {"overlap": "largest overlap (m)", "energy_growth": "energy growth, by its scale"}
PEER_COLOURS = "#E69F00", "#D55E00", "#8C2D04", "#999999", "#555555"


def moving_panel(axis, rows, quantity):
    codes = list(dict.fromkeys(row["code"] for row in rows))
    for number, code in enumerate(codes):
        points = sorted((row for row in rows if row["code"] == code), key=lambda row: -row["time_step"])
        seconds = [1e-3 * row["cpu_ms_per_step"] / row["time_step"] for row in points]
        values = [max(row[quantity], LEAST_OF[quantity]) for row in points]
        ours = code == "quoin"
        axis.loglog(seconds, values, marker=plot.MARKERS[number], markersize=5, linewidth=1, label=code,
                    color=QUOIN if ours else PEER_COLOURS[number - 1], linestyle="-" if ours else ":",
                    fillstyle="full" if ours else "none")
        for i, (second, value, row) in enumerate(zip(seconds, values, points)):
            # On the floor all codes lie on one line, where labels would cover each other.
            if value > LEAST_OF[quantity] and (ours or number == len(codes) - 1):
                axis.annotate(f"{1e3 * row['time_step']:g} ms", (second, value), fontsize=6.5, xytext=(3, 3 if i % 2 else -9),
                              textcoords="offset points", color="#555555")
    axis.set_ylabel(NAMES[quantity])


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


def moving(result, problems, path):
    scenes = list(dict.fromkeys(row["scene"] for row in result["series"]))
    figure = plt.figure(figsize=(10.5, 9.2), layout="constrained")
    grid = figure.add_gridspec(3, 2)
    for column, scene in enumerate(scenes):
        rows = [row for row in result["series"] if row["scene"] == scene and row["whole"]]
        for line, quantity in enumerate(LEAST_OF):
            axis = figure.add_subplot(grid[line, column])
            moving_panel(axis, rows, quantity)
            if line == 0:
                axis.set_title(scene)
            axis.set_xlabel("CPU s a simulated second")
    axis.legend(fontsize=7)
    for column, residual in enumerate(RESIDUALS):
        profile(figure.add_subplot(grid[2, column]), problems, residual)
    plot.save(figure, path)


# --- orders of convergence, stability


LEAST_ERROR = 1e-17  # an error of nothing is drawn here


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
        y = np.maximum(one["errors"], LEAST_ERROR)
        below = y <= max(one["floor"], LEAST_ERROR)
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


def convergence(series, path):
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


def off(cell):
    if cell["error"] is None:
        return 6.0
    return math.log10(max(cell["error"] / cell["allowed"], 1e-8))


@plt.style.context("default")
def stability(cells, path):
    table = stability_rows(cells)
    heights = [len(rows) for rows in table.values()]
    figure, axes = plt.subplots(len(table), 1, figsize=(9, 0.32 * sum(heights) + 0.85 * len(heights)),
                                height_ratios=heights, layout="constrained")
    for axis, (parameter, rows) in zip(np.atleast_1d(axes), table.items()):
        values = sorted({value for row in rows.values() for value, _ in row})
        grid = np.full((len(rows), len(values)), np.nan)
        for r, row in enumerate(rows.values()):
            for value, cell in row:
                column = values.index(value)
                grid[r, column] = off(cell)
                axis.text(column, r, mark(cell), ha="center", va="center", fontsize=7,
                          fontweight="bold")
        image = axis.imshow(grid, aspect="auto", cmap="RdYlBu_r", vmin=-6, vmax=6)
        axis.set_yticks(range(len(rows)), list(rows), fontsize=7)
        axis.set_xticks(range(len(values)), [f"{v:g}" for v in values], fontsize=6)
        axis.set_title(parameter, fontsize=8, loc="left")
        axis.tick_params(length=0)
    figure.colorbar(image, ax=axes, shrink=0.3, label="log10(error / allowed)")
    figure.savefig(path, dpi=110)
    plt.close(figure)
