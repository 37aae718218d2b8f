"""Plots of the demo: runs beside exact curves, their errors below; colours, marks and style of all others."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from run_output import history  # noqa: E402

# Okabe and Ito's colours: told apart by everybody.
COLOURS = ["#D55E00", "#E69F00", "#CC79A7", "#0072B2", "#009E73", "#56B4E9", "#999999", "#000000"]
MARKERS = ["o", "s", "^", "D", "v", "P", "X", "*"]

plt.rcParams.update({
    "font.size": 10, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
    "grid.color": "#e4e4e4", "grid.linewidth": 0.7, "axes.axisbelow": True, "legend.frameon": False,
    "axes.titlesize": 12, "axes.titlelocation": "left", "figure.dpi": 120,
})


def moved(table, monitor, along=None):
    """Displacement of a monitored point: along a direction, or its length, m."""
    vector = np.column_stack([table[f"{monitor}.u{c}"] for c in "xyz"])
    if along is None:
        return np.linalg.norm(vector, axis=1)
    return vector @ (np.array(along) / np.linalg.norm(along))


def save(figure, path):
    figure.savefig(path, pil_kwargs={"optimize": True})
    plt.close(figure)


def displacement_figure(path, panels, monitor, along=None, exact=None):
    """panels: [(title, [(folder, label)])], side by side. exact: function of t (s) in m, or None."""
    rows = [2.2, 1.3] if exact else [1]
    width = 7.2 if len(panels) == 1 else 5.4 * len(panels)
    figure, axes = plt.subplots(len(rows), len(panels), figsize=(width, 6.6 if exact else 4.4),
                                sharex=True, sharey="row", squeeze=False,
                                gridspec_kw={"height_ratios": rows}, layout="constrained")
    axes[0][0].set_ylabel("displacement (m)")
    least = min(displacement_panel(axes[:, i], panel, monitor, along, exact)
                for i, panel in enumerate(panels))
    if exact:
        axes[1][0].set_ylabel("error / exact at the end")
        axes[1][0].set_ylim(max(1e-17, least / 1e3), None)
    save(figure, path)


def displacement_panel(axes, panel, monitor, along, exact):
    """One column of displacement_figure; the least median error."""
    title, runs = panel
    top, least, end_time = axes[0], 1.0, 0.0
    top.set_title(title)
    for i, (folder, label) in enumerate(runs):
        table = history(folder)
        time, value = table["time"], moved(table, monitor, along)
        end_time = max(end_time, time[-1])
        every = max(1, len(time) // 18)
        style = {"color": COLOURS[i % 8], "marker": MARKERS[i % 8], "markersize": 5,
                 "markevery": (i * every // max(1, len(runs)), every)}
        if exact:
            top.plot(time, value, linestyle="none", label=label, **style)
            end = abs(exact(time[-1])) or 1.0
            error = np.maximum(np.abs(value - exact(time)) / end, 1e-17)
            axes[1].semilogy(time[1:], error[1:], linewidth=1, **style)
            least = min(least, np.median(error[1:]))
        else:
            top.plot(time, value, linewidth=1.4, label=label, **style)
    if exact:
        time = np.linspace(0, end_time, 400)
        top.plot(time, exact(time), color="#222222", linewidth=1.2, zorder=1, label="exact")
    axes[-1].set_xlabel("time (s)")
    axes[-1].set_xlim(0, None)
    top.legend(loc="upper left", fontsize=9)
    return least


def components_figure(path, title, runs, monitor, exact):
    """Components of a displacement, and below each what it is off; exact: {"x": function of t}."""
    figure, axes = plt.subplots(2, len(exact), figsize=(5.4 * len(exact), 6), sharex=True,
                                layout="constrained", squeeze=False)
    for column, (component, formula) in enumerate(exact.items()):
        top, bottom = axes[:, column]
        for i, (folder, label) in enumerate(runs):
            table = history(folder)
            time, value = table["time"], table[f"{monitor}.u{component}"]
            every = max(1, len(time) // 18)
            style = {"color": COLOURS[i % 8], "marker": MARKERS[i % 8], "markersize": 5,
                     "markevery": (i * every // max(1, len(runs)), every)}
            top.plot(time, value, linestyle="none", label=label, **style)
            bottom.semilogy(time[1:], np.maximum(np.abs(value - formula(time))[1:], 1e-17),
                            linewidth=1, **style)
        time = np.linspace(0, time[-1], 400)
        top.plot(time, formula(time), color="#222222", linewidth=1.2, zorder=1, label="exact")
        top.set_ylabel(f"displacement along {component} (m)")
        bottom.set(xlabel="time (s)", ylabel=f"difference along {component} (m)", xlim=(0, None))
    axes[0][0].set_title(title)
    axes[0][0].legend(fontsize=8)
    save(figure, path)


def path_figure(path, title, runs, monitor, start, slope):
    """Paths of a centroid in the x–z plane over a plane through the origin that falls by `slope`."""
    figure, axes = plt.subplots(2, 1, figsize=(7.2, 6.2), layout="constrained",
                                gridspec_kw={"height_ratios": [1.2, 1]})
    for i, (folder, label) in enumerate(runs):
        table = history(folder)
        x = start[0] + table[f"{monitor}.ux"]
        z = start[1] + table[f"{monitor}.uz"]
        axes[0].plot(x, z, color=COLOURS[i * 3 % 8], linewidth=1.4, label=label)
        axes[1].plot(table["time"], x * np.sin(slope) + z * np.cos(slope),
                     color=COLOURS[i * 3 % 8], linewidth=1.4, label=label)
    ends = np.array(axes[0].get_xlim())
    axes[0].plot(ends, -np.tan(slope) * ends, color="#555555", linewidth=1.6)
    axes[0].fill_between(ends, -np.tan(slope) * ends, -np.tan(slope) * ends - 0.6,
                         color="#dddddd", linewidth=0)
    axes[0].set(title=title, xlabel="x (m)", ylabel="z (m)", xlim=ends, aspect="equal")
    axes[1].set(xlabel="time (s)", ylabel="height over the plane (m)", xlim=(0, None))
    axes[0].legend(loc="upper right", fontsize=9)
    save(figure, path)


def energy_figure(path, title, runs, monitors):
    """Displacements of several blocks, and the mechanical energy that is left."""
    figure, axes = plt.subplots(2, 1, figsize=(7.2, 6.4), sharex=True, layout="constrained")
    highest = 0.0  # of the last run: what falls off in another need not be seen to its end
    for i, (folder, label) in enumerate(runs):
        table = history(folder)
        for m, monitor in enumerate(monitors):
            value = moved(table, monitor)
            axes[0].plot(table["time"], value, color=COLOURS[m],
                         linestyle=["-", "--", ":", "-."][i % 4], linewidth=1.2,
                         label=monitor if i == 0 else None)
            highest = max(highest, value[-1]) if i + 1 == len(runs) else highest
        energy = sum(table[name] for name in ("kinetic", "potential", "strain", "contact"))
        axes[1].plot(table["time"], (energy - energy[0]) / 1000, color="#222222",
                     linestyle=["-", "--", ":", "-."][i % 4], linewidth=1.2, label=label)
    axes[0].set(title=title, ylabel="displacement (m)", ylim=(0, 1.25 * highest))
    axes[0].legend(fontsize=9)
    axes[1].set(xlabel="time (s)", ylabel="mechanical energy, change (kJ)", xlim=(0, None))
    axes[1].legend(fontsize=9)
    save(figure, path)


def error_against_time_figure(path, points):
    """points: [(example, method, seconds, largest error)]; a colour for each method, a mark for each example."""
    figure, axis = plt.subplots(figsize=(7.2, 4.2), layout="constrained")
    methods, examples = (list(dict.fromkeys(point[i] for point in points)) for i in (1, 0))
    for example, method, seconds, error in points:
        axis.loglog(seconds, max(error, 1e-16), linestyle="", markersize=8, color=COLOURS[methods.index(method)],
                    marker=MARKERS[examples.index(example) % len(MARKERS)], markeredgecolor="white")
    marks = [plt.Line2D([], [], linestyle="", marker="o", color=COLOURS[i], label=name) for i, name in enumerate(methods)]
    marks += [plt.Line2D([], [], linestyle="", marker=MARKERS[i % len(MARKERS)], color="#555555", label=name)
              for i, name in enumerate(examples)]
    axis.legend(handles=marks, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    axis.set(title="Error against run time", xlabel="time in the solver (s)", ylabel="largest relative error")
    save(figure, path)
