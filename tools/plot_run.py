#!/usr/bin/env python3
"""Plots of a run: its history, and what its joints bear at the end. `quoin plot` calls it.

    quoin plot RUN [--out FOLDER] [--plane xz|yz]

RUN is a folder that `quoin run --out` left. Writes history.png (monitors, energy, contacts),
thrust.png (joints with their centres of pressure; where blocks form a chain, as in an arch, the thrust
line joins them; of more than 500 joints the blocks by their largest compression) and joints.png (normal and shear force, and pressures, along the chain);
of a chain also diagrams.png (eccentricity, and moment against normal force).
"""
import argparse
import pathlib

import plot  # marks and style of all pictures
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.ticker import MaxNLocator
from run_output import Blocks, Contacts, edge_stresses, history, largest_compression, run_program, series

COLOURS = [plot.COLOURS[i] for i in (3, 0, 4, 2, 1, 5, 6, 7)]
AXES = {"xz": [0, 2], "yz": [1, 2]}
MOST_MONITORS = 8
MOST_LINES = 500  # joints whose forces are drawn one by one: more run into each other
plt.rcParams.update({"axes.titlesize": 11, "figure.dpi": 110})


def save(figure, path):
    plot.save(figure, path)
    print(path)


def clock(table):
    """Time where it passes, else steps: static stages have no time."""
    moving = np.ptp(table["time"]) > 0
    return (table["time"], "time (s)") if moving else (table["step"], "step")


def sizes(table, letter):
    """Of each monitored vector whose columns have that letter: what it is called, and its size; of a contact's force
    the normal part."""
    normal = {name: table.get(f"{name}.normal_force") if letter == "f" else None
              for name in [column[:-3] for column in table if column.endswith(f".{letter}x")][:MOST_MONITORS]}
    return [(name, np.linalg.norm([table[f"{name}.{letter}{c}"] for c in "xyz"], axis=0)) if part is None
            else (f"{name}, normal", part) for name, part in normal.items()]


def history_figure(table, path):
    x, label = clock(table)
    panels = [("displacement (mm)", 1000, sizes(table, "u")), ("force (kN)", 1 / 1000, sizes(table, "f"))]
    panels = [panel for panel in panels if panel[2]]
    rows = len(panels) + 2
    figure, axes = plt.subplots(rows, 1, figsize=(7.2, 2.1 * rows + 0.5), sharex=True, layout="constrained")
    for axis, (what, unit, lines) in zip(axes, panels):
        for colour, (name, size) in zip(COLOURS, lines):
            axis.plot(x, unit * size, color=colour, label=name)
        axis.set(ylabel=what)
        axis.legend(fontsize=9)
    axes = axes[-2:]
    energies = ("kinetic", "strain", "friction_loss", "impact_loss")
    most = max(np.ptp(table[name]) for name in energies)
    for i, name in enumerate(energies):
        if np.ptp(table[name]) > 1e-9 * most:  # less is rounding
            axes[0].plot(x, table[name], color=COLOURS[i], label=name.replace("_", " "))
    axes[0].set(ylabel="energy (J)")
    if axes[0].lines:
        axes[0].legend(fontsize=9)
    stepped, mark = slice(1, None), "o" if len(x) == 2 else ""  # the first line is from before any step
    axes[1].plot(x[stepped], table["contacts"][stepped], color=COLOURS[6], linewidth=4, marker=mark, markersize=9, label="watched")
    axes[1].plot(x[stepped], table["closed"][stepped], color=COLOURS[0], marker=mark, label="closed")
    axes[1].set(ylabel="contact points", xlabel=label, ylim=(0, None))
    axes[1].yaxis.set_major_locator(MaxNLocator(integer=True))
    axes[1].legend(fontsize=9)
    save(figure, path)


def chain_of(joints, blocks):
    """The joints from one end to the other where every free block has at most two; else none."""
    of_block = {}
    for number, joint in enumerate(joints):
        for block in (joint["a"], joint["b"]):
            if not blocks.held(block):
                of_block.setdefault(block, []).append(number)
    if not joints or any(len(numbers) > 2 for numbers in of_block.values()):
        return None
    links = {number: set() for number in range(len(joints))}
    for numbers in of_block.values():
        if len(numbers) == 2:
            links[numbers[0]].add(numbers[1])
            links[numbers[1]].add(numbers[0])
    ends = sorted((number for number in links if len(links[number]) < 2),
                  key=lambda n: tuple(joints[n]["centre"]))
    chain = ends[:1]
    while chain:
        following = links[chain[-1]] - set(chain)
        if not following:
            break
        chain.append(following.pop())
    return chain if len(chain) == len(joints) else None


def hull(points):
    """Convex hull of points in the plane, counter-clockwise (Andrew's monotone chain)."""
    points = sorted(map(tuple, points))
    halves = []
    for ordered in (points, points[::-1]):
        half = []
        for p in ordered:
            while len(half) > 1 and ((half[-1][0] - half[-2][0]) * (p[1] - half[-2][1])
                                     <= (half[-1][1] - half[-2][1]) * (p[0] - half[-2][0])):
                half.pop()
            half.append(p)
        halves += half[:-1]
    return halves


def draw_compression(figure, axis, outlines, held, compression):
    shown = PolyCollection([o for o, h in zip(outlines, held) if not h], array=compression[~held] / 1000,
                           cmap="cividis_r", edgecolors="face", linewidths=0.1)
    axis.add_collection(shown)
    figure.colorbar(shown, ax=axis, orientation="horizontal", shrink=0.7, aspect=40, label="kPa")
    return "largest compression of each block, mean over the block, of contact forces"


def draw_forces(axis, centres, forces, longest):
    largest = np.linalg.norm(forces, axis=1).max()
    for centre, force in zip(centres, forces):
        half = 0.5 * longest * force / largest
        axis.plot(*np.column_stack([centre - half, centre + half]), color=COLOURS[1], linewidth=1.2)
    axis.plot(*centres.T, "o", color=COLOURS[0], markersize=2.5)
    return f"centres of pressure and forces; the longest line is {largest / 1000:.3g} kN"


def draw_thrust_line(axis, centres, forces):
    axis.plot(*centres.T, color=COLOURS[1], linewidth=2.0, label="thrust line")
    axis.plot(*centres.T, "o", color=COLOURS[1], markersize=3.5)
    return (f"thrust line, one of many unless quoin limit --thrust proves it unique\n"
            f"the largest force is {np.linalg.norm(forces, axis=1).max() / 1000:.3g} kN")


def thrust_figure(blocks, contacts, joints, chain, plane, path):
    axes_of = AXES[plane]
    figure, axis = plt.subplots(figsize=(7.2, 4.8), layout="constrained")
    there = [b for b, faces in enumerate(blocks.faces) if faces]
    outlines = [hull(blocks.points[sorted({v for f in blocks.faces[b] for v in f})][:, axes_of]) for b in there]
    held = np.array([blocks.held(b) for b in there])
    many = chain is None and len(joints) > MOST_LINES
    colours = ["#cfcdc8" if h else "#f2e3cf" for h in held]
    axis.add_collection(PolyCollection(outlines, facecolors=colours, edgecolors="#8a8378",
                                       linewidths=0.0 if many else 0.7))
    free = np.vstack([outline for outline, fixed in zip(outlines, held) if not fixed])
    low, high = free.min(axis=0), free.max(axis=0)
    margin = 0.08 * np.max(high - low)
    axis.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin),
             aspect="equal", xlabel=f"{plane[0]} (m)", ylabel="z (m)")
    centres = np.array([joint["centre"][axes_of] for joint in joints])
    forces = np.array([joint["force"][axes_of] for joint in joints])
    if many:
        title = draw_compression(figure, axis, outlines, held, largest_compression(blocks, contacts)[there])
    elif chain is None:
        title = draw_forces(axis, centres, forces, 0.12 * np.max(high - low))
    else:
        band = thrust_band(joints, chain, axes_of)[..., axes_of]
        axis.fill(*np.concatenate([band[:, 0], band[::-1, 1]]).T, color=COLOURS[1], alpha=0.22, linewidth=0)
        title = draw_thrust_line(axis, centres[chain], forces[chain])
    figure.suptitle(title, x=0.02, ha="left", fontsize=11)  # of the figure: an axis may be narrow
    save(figure, path)


def section_of(joint, up):
    """Depth h (m) of a joint's section along `up` as projected on it, the distance e (m) of its centre of pressure
    from the middle of h, positive along `up`, and that axis; None of a joint without area."""
    axis = up - (up @ joint["direction"]) * joint["direction"]
    size = np.linalg.norm(axis)
    if size < 1e-6 or not joint["area"] > 0:
        return None
    axis /= size
    heights = joint["points"] @ axis
    depth = np.ptp(heights)
    if not depth > 0:
        return None
    return depth, joint["centre"] @ axis - (heights.max() + heights.min()) / 2, axis


def thrust_up(joints, chain, axes_of):
    """Across the thrust line in its plane, by joint of the chain, all to one side: where the sections have their depth."""
    normals = np.array([joints[number]["direction"] for number in chain])
    away = [i for i in range(3) if i not in axes_of][0]
    across = np.cross(normals, np.eye(3)[away])
    turned = (across[1:] * across[:-1]).sum(axis=1) < 0
    return across * np.where(np.concatenate([[0], np.cumsum(turned)]) % 2, -1, 1)[:, None]


def thrust_band(joints, chain, axes_of):
    """Ends, m, of the part of each joint of a chain that bears where pressure is linear and there is no tension, 3 a from
    the edge that is nearer: joints × (lower, upper) × 3; empty where a joint has no area."""
    ends = []
    for joint, up in zip((joints[number] for number in chain), thrust_up(joints, chain, axes_of)):
        section = section_of(joint, up)
        if section is None:
            return np.empty((0, 2, 3))
        depth, off, axis = section
        bearing = min(depth, 3 * (depth / 2 - abs(off)))
        near = np.sign(off) * depth / 2 if bearing < depth else depth / 2
        far = near - np.sign(near) * bearing
        ends.append([joint["centre"] + (height - off) * axis for height in sorted((near, far))])
    return np.array(ends)


def diagram_figure(joints, chain, axes_of, path):
    """N and M = N e of each joint of a chain, by their limits without tension: |M| <= N h / 2."""
    sections = [section_of(joints[n], up) for n, up in zip(chain, thrust_up(joints, chain, axes_of))]
    if any(section is None for section in sections):
        return
    number = np.arange(1, len(chain) + 1)
    normal = np.array([joints[n]["normal"] for n in chain]) / 1000
    depth, off = (np.array([section[i] for section in sections]) for i in (0, 1))
    figure, axes = plt.subplots(1, 2, figsize=(7.2, 3.2), layout="constrained")
    axes[0].fill_between(number, -0.5, 0.5, color="#e9e9e9", label="section")
    axes[0].fill_between(number, -1 / 6, 1 / 6, color="#cfe3ee", label="middle third")
    axes[0].plot(number, off / depth, "o-", color=COLOURS[1], markersize=3.5, label="centre of pressure")
    axes[0].set(xlabel="joint along the chain", ylabel="eccentricity e / h", ylim=(-0.6, 0.6))
    most = 1.1 * normal.max()
    for share, size in ((0.5, 9), (1 / 6, 5)):
        for sign in (1, -1):
            axes[1].plot(normal, sign * share * normal * depth, "_", color="#888888", markersize=size)
    axes[1].plot(normal, normal * off, "o", color=COLOURS[0], markersize=4)
    axes[1].set(xlabel="normal force N (kN)", ylabel="moment N e (kN m)", xlim=(0, most))
    axes[0].legend(fontsize=8, loc="lower center", bbox_to_anchor=(0.45, 1.0), ncol=3, handlelength=1, columnspacing=0.8, frameon=False)
    axes[1].set_title("of each joint: N h/2 (long), N h/6 (short)", fontsize=9)
    save(figure, path)


def joints_figure(joints, chain, edges, path):
    order = chain if chain is not None else range(len(joints))
    ordered = [joints[number] for number in order]
    number = np.arange(1, len(ordered) + 1)
    figure, axes = plt.subplots(2, 1, figsize=(7.2, 5.0), sharex=True, layout="constrained")
    marks = {"marker": "o", "markersize": 3.5, "linestyle": "-" if chain is not None else "none"}
    axes[0].plot(number, [j["normal"] / 1000 for j in ordered], color=COLOURS[0], label="normal", **marks)
    axes[0].plot(number, [j["shear"] / 1000 for j in ordered], color=COLOURS[1], label="shear", **marks)
    axes[0].set(ylabel="force (kN)")
    axes[0].legend(fontsize=9)
    mean = [j["normal"] / j["area"] / 1e6 if j["area"] > 0 else np.nan for j in ordered]
    most = [np.nanmax(j["pressure"]) / 1e6 if np.isfinite(j["pressure"]).any() else np.nan
            for j in ordered]
    axes[1].plot(number, mean, color=COLOURS[0], label="mean over the joint", **marks)
    axes[1].plot(number, most, color=COLOURS[2], label="largest at a contact point", **marks)
    if chain is not None:
        edge = [edges.get((j["a"], j["b"]), np.nan) / 1e6 for j in ordered]
        axes[1].plot(number, edge, color=COLOURS[1], label="at the edge, linear and without tension", **marks)
    for axis in axes:
        axis.margins(y=0.08)
        axis.update_datalim([(1, 0)], updatex=False)  # from zero
        axis.autoscale_view()
        axis.set_ylim(bottom=0)
    axes[1].xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    axes[1].set(ylabel="pressure (MPa)", xlim=(0.5, len(ordered) + 0.5),
                xlabel="joint along the chain" if chain is not None else "joint")
    axes[1].set_ylim(top=1.2 * axes[1].get_ylim()[1])  # room for the legend
    axes[1].legend(fontsize=8, ncol=3, loc="upper center")
    save(figure, path)


def main():
    parser = argparse.ArgumentParser(prog="quoin plot", description=__doc__.splitlines()[0])
    parser.add_argument("run", help="folder that quoin run --out left")
    parser.add_argument("--out", default=".", help="folder of the pictures (default: the current one)")
    parser.add_argument("--plane", choices=["xz", "yz"], default="xz", help="of thrust.png (default xz)")
    given = parser.parse_args()
    table = history(given.run)
    out = pathlib.Path(given.out)
    out.mkdir(parents=True, exist_ok=True)
    history_figure(table, out / "history.png")
    blocks = Blocks(series(given.run, "blocks")[-1][1])
    contacts = Contacts(series(given.run, "contacts")[-1][1])
    joints = contacts.joints
    if not joints:
        print("no joint bears a force at the end: thrust.png and joints.png are left out")
        return
    chain = chain_of(joints, blocks)
    thrust_figure(blocks, contacts, joints, chain, given.plane, out / "thrust.png")
    joints_figure(joints, chain, edge_stresses(given.run), out / "joints.png")
    if chain is not None and len(chain) > 1:
        diagram_figure(joints, chain, AXES[given.plane], out / "diagrams.png")


if __name__ == "__main__":
    run_program(main)
