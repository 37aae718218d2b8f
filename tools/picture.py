#!/usr/bin/env python3
"""Pictures of a run: its blocks at some times, with forces and contacts. `quoin picture` calls it.

    quoin picture RUN PICTURE [--times T…] [--scale S] [--forces] [--contacts] [--from X Y Z]

RUN is a folder that `quoin run --out` left. PICTURE ends in .png: one panel for each time (default four,
from start to end); in .gif or .mp4: an animation of all times, where ffmpeg is installed.
Displacements are enlarged by S. --forces draws what bears on each joint, --contacts the closed points:
blue those that stick, orange those that slip.
"""
import argparse
import pathlib
import shutil
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402
from run_output import Blocks, Contacts, series  # noqa: E402

HELD = np.array([0.76, 0.75, 0.73])
FREE = np.array([(0.80, 0.48, 0.33), (0.88, 0.70, 0.44), (0.44, 0.58, 0.68), (0.58, 0.66, 0.48),
                 (0.72, 0.45, 0.46), (0.54, 0.51, 0.66)])
LIGHT = np.array([-0.45, -0.65, 0.85]) / np.linalg.norm([-0.45, -0.65, 0.85])
STICK, SLIP = "#0072B2", "#D55E00"
FRAMES_A_SECOND = 15


class View:
    """Parallel projection towards -direction, z up."""

    def __init__(self, direction):
        self.back = np.array(direction, dtype=float) / np.linalg.norm(direction)
        right = np.cross([0.0, 0.0, 1.0], self.back)
        if np.linalg.norm(right) < 1e-9:
            right = np.array([1.0, 0.0, 0.0])
        self.right = right / np.linalg.norm(right)
        self.up = np.cross(self.back, self.right)

    def flat(self, points):
        return np.column_stack([points @ self.right, points @ self.up])


def visible_faces(blocks, view, scale):
    """[(depth, outline, colour)] of faces that look to the eye, the farthest first."""
    points = blocks.placed(scale)
    shown, free = [], 0
    for block, faces in enumerate(blocks.faces):
        colour = HELD if blocks.held(block) else FREE[free % len(FREE)]
        free += not blocks.held(block)
        for face in faces:
            corners = points[face]
            area = sum(np.cross(corners[i] - corners[0], corners[i + 1] - corners[0])
                       for i in range(1, len(face) - 1))
            normal = area / (np.linalg.norm(area) or 1.0)
            if normal @ view.back <= 1e-9:
                continue
            shade = 0.58 + 0.42 * max(0.0, normal @ LIGHT)
            shown.append((blocks.held(block), corners.mean(axis=0) @ view.back, view.flat(corners),
                          np.clip(colour * shade, 0, 1)))
    # The ground lies behind all that stands on it.
    return sorted(shown, key=lambda face: (not face[0], face[1]))


def draw_contacts(axis, contacts, view):
    for state, colour in ((1, STICK), (2, SLIP)):
        axis.plot(*view.flat(contacts.points[contacts.state == state]).T, "o", color=colour,
                  markersize=2.6, zorder=3)


def draw_forces(axis, joints, view, size, largest):
    for joint in joints:
        half = 0.08 * size * view.flat(joint["force"][None])[0] / largest
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
    """What is shown: all that moves at any time, with a margin."""
    flat = []
    for frame in frames:
        placed = frame.blocks.placed(scale)
        for block, faces in enumerate(frame.blocks.faces):
            if not frame.blocks.held(block):
                flat.append(view.flat(placed[sorted({v for f in faces for v in f})]))
    flat = np.vstack(flat)
    low, high = flat.min(axis=0), flat.max(axis=0)
    margin = 0.08 * np.max(high - low)
    return low - margin, high + margin


def draw(axis, frame, given, box, largest):
    low, high = box
    faces = visible_faces(frame.blocks, given.view, given.scale)
    axis.add_collection(PolyCollection([f[2] for f in faces], facecolors=[f[3] for f in faces],
                                       edgecolors="#3c352c", linewidths=0.4))
    if given.contacts:
        draw_contacts(axis, frame.contacts, given.view)
    if given.forces and largest > 0:
        draw_forces(axis, frame.contacts.joints(), given.view, np.max(high - low), largest)
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axis.axis("off")
    words = f"t = {frame.time:.3g} s" + (f", displacements × {given.scale:g}" if given.scale != 1 else "")
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
                                figsize=(7.2, rows * (width * min(max(shape, 0.25), 1.6) + 0.3)))
    for axis in axes.flat:
        axis.axis("off")
    for axis, frame in zip(axes.flat, frames):
        draw(axis, frame, given, box, largest)
    figure.savefig(given.picture, dpi=120, pil_kwargs={"optimize": True})
    plt.close(figure)


def animation(frames, given):
    if shutil.which("ffmpeg") is None:
        sys.exit("quoin picture: an animation needs ffmpeg, which is not installed; .png does not")
    box, largest = box_of(frames, given.view, given.scale), largest_force(frames)
    with tempfile.TemporaryDirectory() as folder:
        for number, frame in enumerate(frames):
            figure, axis = plt.subplots(figsize=(6, 4), layout="constrained")
            draw(axis, frame, given, box, largest)
            figure.savefig(f"{folder}/{number:05d}.png", dpi=100)
            plt.close(figure)
        command = ["ffmpeg", "-y", "-loglevel", "error", "-framerate", str(FRAMES_A_SECOND), "-i",
                   f"{folder}/%05d.png"]
        command += (["-vf", "split[a][b];[a]palettegen[p];[b][p]paletteuse"]
                    if given.picture.endswith(".gif") else ["-pix_fmt", "yuv420p"])
        done = subprocess.run([*command, given.picture], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit("ffmpeg: " + done.stderr.strip())


def main():
    parser = argparse.ArgumentParser(prog="quoin picture", description=__doc__.splitlines()[0])
    parser.add_argument("run", help="folder that quoin run --out left")
    parser.add_argument("picture", help=".png; or .gif, .mp4: an animation of all times")
    parser.add_argument("--times", type=float, nargs="+", help="s; default: four from start to end")
    parser.add_argument("--scale", type=float, default=1.0, help="of displacements (default 1)")
    parser.add_argument("--forces", action="store_true", help="arrows: what bears on each joint")
    parser.add_argument("--contacts", action="store_true", help="closed points: blue stick, orange slip")
    parser.add_argument("--from", dest="direction", type=float, nargs=3, default=(-0.45, -1.0, 0.42),
                        metavar=("X", "Y", "Z"), help="direction towards the eye")
    given = parser.parse_args()
    if not np.linalg.norm(given.direction) > 0:
        parser.error("--from must not be zero")
    given.view = View(given.direction)
    ending = pathlib.Path(given.picture).suffix.lower()
    if ending not in (".png", ".gif", ".mp4"):
        parser.error("the picture must end in .png, .gif or .mp4")
    all_times = [time for time, _ in series(given.run, "blocks")]
    if ending != ".png":
        animation(list(frames_of(given.run, given.times or all_times)), given)
        return
    times = given.times or sorted(set(np.linspace(all_times[0], all_times[-1], min(4, len(all_times)))))
    sheet(list(frames_of(given.run, times)), given)


if __name__ == "__main__":
    main()
