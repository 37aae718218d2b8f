#!/usr/bin/env python3
"""Pictures of a run: its blocks at some times, with forces and contacts. `quoin picture` calls it.

    quoin picture RUN PICTURE [--times T…] [--scale S] [--forces] [--contacts] [--from X Y Z]

RUN is a folder that `quoin run --out` left. PICTURE ends in .png: one panel for each time (default four,
from start to end); in .gif or .mp4: an animation of all times (.mp4 needs ffmpeg).
Displacements are enlarged by S. --forces draws what bears on each joint, --contacts the contact points by
state: open, stick, slip; ringed where the joint is at its residual strength (failed).
"""
import argparse
import pathlib
import shutil
import subprocess
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.animation import FFMpegWriter, PillowWriter  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from run_output import Blocks, Contacts, run_program, series  # noqa: E402

HELD = np.array([0.76, 0.75, 0.73])
FREE = np.array([(0.80, 0.48, 0.33), (0.88, 0.70, 0.44), (0.44, 0.58, 0.68), (0.58, 0.66, 0.48),
                 (0.72, 0.45, 0.46), (0.54, 0.51, 0.66)])
# Name, which points, and how they are drawn: a ring about a failed one, below its state.
STATES = (("open", lambda c: c.state == 0,
           {"marker": "o", "color": "#777777", "markerfacecolor": "white", "ms": 3.4, "zorder": 3.1}),
          ("stick", lambda c: c.state == 1, {"marker": "o", "color": "#0072B2", "ms": 3.4, "zorder": 3.1}),
          ("slip", lambda c: c.state == 2, {"marker": "^", "color": "#D55E00", "ms": 3.8, "zorder": 3.1}),
          ("failed", lambda c: c.failed,
           {"marker": "o", "color": "#000000", "markerfacecolor": "none", "ms": 6, "zorder": 3.0}))
LEGEND_HEIGHT = 0.28  # inches
FRAMES_A_SECOND = 15
LARGEST_SCALE = 1e9  # beyond, corners lose their digits


class View:
    """Parallel projection towards -direction, z up."""

    def __init__(self, direction):
        self.back = np.array(direction, dtype=float) / np.linalg.norm(direction)
        right = np.cross([0.0, 0.0, 1.0], self.back)
        if np.linalg.norm(right) < 1e-9:
            right = np.array([1.0, 0.0, 0.0])
        self.right = right / np.linalg.norm(right)
        self.up = np.cross(self.back, self.right)
        light = 0.6 * self.back - 0.5 * self.right + np.array([0.0, 0.0, 0.9])
        self.light = light / np.linalg.norm(light)  # towards it: over the left shoulder

    def flat(self, points):
        return np.column_stack([points @ self.right, points @ self.up])


class Shape:
    """One convex block as it is drawn."""

    def __init__(self, points, faces, colour):
        self.points = points[sorted({v for face in faces for v in face})]
        self.colour = colour
        self.corners = [points[face] for face in faces]
        areas = np.array([sum(np.cross(c[i] - c[0], c[i + 1] - c[0]) for i in range(1, len(c) - 1))
                          for c in self.corners])
        self.normals = areas / np.maximum(np.linalg.norm(areas, axis=1), 1e-300)[:, None]
        self.offsets = np.array([n @ c[0] for n, c in zip(self.normals, self.corners)])


def in_front(a, b, view):
    """1 when block b hides a, -1 when a hides b, by the face plane that parts them best; 0: neither."""
    best, answer = -np.inf, 0
    for first, second, sign in ((a, b, 1), (b, a, -1)):
        gaps = (second.points @ first.normals.T - first.offsets).min(axis=0)
        towards = first.normals @ view.back
        gaps[np.abs(towards) < 1e-6] = -np.inf
        face = int(np.argmax(gaps))
        if gaps[face] > best:
            best, answer = gaps[face], sign * int(np.sign(towards[face]))
    return answer


def back_to_front(shapes, view):
    """Order of drawing: every block after those that it hides."""
    flat = [view.flat(shape.points) for shape in shapes]
    low = np.array([f.min(axis=0) for f in flat])
    high = np.array([f.max(axis=0) for f in flat])
    behind = [[] for _ in shapes]
    for i, shape in enumerate(shapes):
        near = np.all((low[i] < high[i + 1:]) & (low[i + 1:] < high[i]), axis=1)
        for j in i + 1 + np.flatnonzero(near):
            sign = in_front(shape, shapes[j], view)
            if sign:
                behind[j if sign > 0 else i].append(i if sign > 0 else j)
    depth = [(shape.points @ view.back).mean() for shape in shapes]
    order, seen = [], set()
    for start in sorted(range(len(shapes)), key=depth.__getitem__):
        stack = [] if start in seen else [(start, iter(behind[start]))]
        seen.add(start)
        while stack:
            following = next((n for n in stack[-1][1] if n not in seen), None)
            if following is None:
                order.append(stack.pop()[0])
            else:
                seen.add(following)
                stack.append((following, iter(behind[following])))
    return order


def visible_faces(blocks, view, scale):
    """[(outline, colour)] of faces that look to the eye, the farthest first."""
    points = blocks.placed(scale)
    shapes, free = [], 0
    for block, faces in enumerate(blocks.faces):
        if faces:  # an absent block has none
            shapes.append(Shape(points, faces, HELD if blocks.held(block) else FREE[free % len(FREE)]))
        free += not blocks.held(block)
    shown = []
    for number in back_to_front(shapes, view):
        shape = shapes[number]
        for corners, normal in zip(shape.corners, shape.normals):
            if normal @ view.back > 1e-9:
                shade = 0.58 + 0.42 * max(0.0, normal @ view.light)
                shown.append((view.flat(corners), np.clip(shape.colour * shade, 0, 1)))
    return shown


def draw_contacts(axis, contacts, view):
    for _, chosen, style in STATES:
        axis.plot(*view.flat(contacts.points[chosen(contacts)]).T, linestyle="", markeredgewidth=0.8, **style)


def add_legend(figure, frames):
    """Of the states that these frames show, over all panels."""
    shown = [Line2D([], [], linestyle="", markeredgewidth=0.8, label=name, **style)
             for name, chosen, style in STATES if any(chosen(frame.contacts).any() for frame in frames)]
    top = 1.0 - LEGEND_HEIGHT / figure.get_figheight()
    figure.set_layout_engine("constrained", rect=(0, 0, 1, top))
    figure.legend(handles=shown, loc="upper center", ncol=len(STATES), fontsize=10, frameon=False,
                  handletextpad=0.1, columnspacing=1.2)


def draw_forces(axis, joints, view, size, largest):
    for joint in joints:
        half = 0.04 * size * view.flat(joint["force"][None])[0] / largest
        centre = view.flat(joint["centre"][None])[0]
        for sign in (1, -1):  # action and reaction, each pointing at the joint
            axis.annotate("", xy=centre, xytext=centre - sign * 2 * half, zorder=4,
                          arrowprops={"arrowstyle": "-|>", "color": "#222222", "lw": 0.8,
                                      "shrinkA": 0, "shrinkB": 0, "mutation_scale": 6})


class Frame:
    def __init__(self, time, blocks, contacts):
        self.time = time
        self.blocks = Blocks(blocks)
        self.contacts = Contacts(contacts)


def frames_of(folder, times):
    blocks, contacts = series(folder, "blocks"), series(folder, "contacts")
    for wanted in times:
        number = min(range(len(blocks)), key=lambda i: abs(blocks[i][0] - wanted))
        yield Frame(blocks[number][0], blocks[number][1], contacts[number][1])


def box_of(frames, view, scale):
    """What is shown: all that moves at any time (all, where nothing does), with a margin."""
    flat = []
    nothing_moves = all(frame.blocks.held(b) for frame in frames for b in range(len(frame.blocks.kind)))
    for frame in frames:
        placed = frame.blocks.placed(scale)
        for block, faces in enumerate(frame.blocks.faces):
            if faces and (nothing_moves or not frame.blocks.held(block)):
                flat.append(view.flat(placed[sorted({v for f in faces for v in f})]))
    flat = np.vstack(flat)
    low, high = flat.min(axis=0), flat.max(axis=0)
    margin = 0.08 * np.max(high - low)
    return low - margin, high + margin


def draw(axis, frame, given, box, largest):
    low, high = box
    faces = visible_faces(frame.blocks, given.view, given.scale)
    axis.add_collection(PolyCollection([f[0] for f in faces], facecolors=[f[1] for f in faces],
                                       edgecolors="#3c352c", linewidths=0.4))
    if given.contacts:
        draw_contacts(axis, frame.contacts, given.view)
    if given.forces and largest > 0:
        draw_forces(axis, frame.contacts.joints(), given.view, np.max(high - low), largest)
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axis.axis("off")
    words = f"t = {frame.time:.3g} s" + (f", displacements × {given.scale:g}" if given.scale != 1 else "")
    words += f", arrows up to {largest / 1000:.3g} kN" if given.forces and largest > 0 else ""
    axis.set_title(words, fontsize=10, loc="left", color="#222222")


def largest_force(frames):
    return max((np.linalg.norm(j["force"]) for f in frames for j in f.contacts.joints()), default=0.0)


def sheet(frames, given):
    box, largest = box_of(frames, given.view, given.scale), largest_force(frames)
    columns = 2 if len(frames) > 1 else 1
    rows = (len(frames) + columns - 1) // columns
    shape = (box[1] - box[0])[1] / (box[1] - box[0])[0]
    width = 7.2 / columns
    figure, axes = plt.subplots(rows, columns, squeeze=False, layout="constrained",
                                figsize=(7.2, rows * (width * min(max(shape, 0.25), 1.6) + 0.3) +
                                         (LEGEND_HEIGHT if given.contacts else 0)))
    for axis in axes.flat:
        axis.axis("off")
    for axis, frame in zip(axes.flat, frames):
        draw(axis, frame, given, box, largest)
    if given.contacts:
        add_legend(figure, frames)
    figure.savefig(given.picture, dpi=120, pil_kwargs={"optimize": True})
    plt.close(figure)


def animation(frames, given):
    is_gif = given.picture.lower().endswith(".gif")
    if not is_gif and shutil.which("ffmpeg") is None:
        sys.exit("quoin picture: .mp4 needs ffmpeg, which is not installed; .gif and .png do not")
    box, largest = box_of(frames, given.view, given.scale), largest_force(frames)
    figure = plt.figure(figsize=(6, 4), layout="constrained")
    writer = (PillowWriter if is_gif else FFMpegWriter)(fps=FRAMES_A_SECOND)
    try:
        with writer.saving(figure, given.picture, dpi=100):
            for frame in frames:
                figure.clear()
                draw(figure.add_subplot(), frame, given, box, largest)
                if given.contacts:
                    add_legend(figure, frames)
                writer.grab_frame()
    except subprocess.CalledProcessError as error:
        sys.exit(f"quoin picture: {given.picture}: {error}")


def refuse(words):
    print(f"quoin picture: {words}", file=sys.stderr)
    sys.exit(2)


def main():
    parser = argparse.ArgumentParser(prog="quoin picture", description=__doc__.splitlines()[0])
    parser.add_argument("run", help="folder that quoin run --out left")
    parser.add_argument("picture", help=".png; or .gif, .mp4: an animation of all times")
    parser.add_argument("--times", type=float, nargs="+", help="s; default: four from start to end")
    parser.add_argument("--scale", type=float, default=1.0, help="of displacements (default 1)")
    parser.add_argument("--forces", action="store_true", help="arrows: what bears on each joint")
    parser.add_argument("--contacts", action="store_true", 
                        help="contact points by state: open, stick, slip, failed (residual strength)")
    parser.add_argument("--from", dest="direction", type=float, nargs=3, default=(-0.45, -1.0, 0.42),
                        metavar=("X", "Y", "Z"), help="direction towards the eye (default -0.45 -1 0.42)")
    given = parser.parse_args()
    if not 0 < np.linalg.norm(given.direction) < np.inf:
        refuse("--from: must be a direction that is not zero")
    if not 0 <= given.scale <= LARGEST_SCALE:
        refuse(f"--scale {given.scale:g}: must lie in 0 … {LARGEST_SCALE:g}")
    given.view = View(given.direction)
    ending = pathlib.Path(given.picture).suffix.lower()
    if ending not in (".png", ".gif", ".mp4"):
        refuse(f"{given.picture}: the picture must end in .png, .gif or .mp4")
    all_times = [time for time, _ in series(given.run, "blocks")]
    slack = 1e-6 * (all_times[-1] - all_times[0])
    for time in given.times or []:
        if not all_times[0] - slack <= time <= all_times[-1] + slack:
            refuse(f"--times {time:g}: the run goes from {all_times[0]:g} to {all_times[-1]:g} s")
    if ending != ".png":
        animation(list(frames_of(given.run, given.times or all_times)), given)
        return
    times = given.times or sorted(set(np.linspace(all_times[0], all_times[-1], min(4, len(all_times)))))
    sheet(list(frames_of(given.run, times)), given)


if __name__ == "__main__":
    run_program(main)
