#!/usr/bin/env python3
"""Pictures of a run: its blocks at some times, with forces and contacts. `quoin picture` calls it.

    quoin picture RUN PICTURE [--times T…] [--colour NAME] [--scale S] [--forces] [--contacts] [--from X Y Z]

RUN is a folder that `quoin run --out` left. PICTURE ends in .png: one panel for each time (default four,
from start to end); in .gif or .mp4: an animation of all times (.mp4 needs ffmpeg).
Displacements are enlarged by S. --forces draws the resultant that bears on each joint, --contacts the contact
points by state: open, stick, slip; ringed where the joint is at its residual strength (failed). Points and
resultants inside the stone are seen through it, points fainter.
"""
import argparse
import functools
import os
import pathlib
import shutil
import subprocess
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.animation import FFMpegWriter, PillowWriter  # noqa: E402
from matplotlib.cm import ScalarMappable  # noqa: E402
from matplotlib.collections import LineCollection  # noqa: E402
from matplotlib.colors import Normalize  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from run_output import FIXED, Blocks, Contacts, frame_labels, largest_compression, run_program, series, shown_times  # noqa: E402

COMMAND = os.environ.get("QUOIN", "quoin")  # draws the pixels
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
QUANTITIES = {"displacement": ("displacement of each block (m)", lambda f: np.linalg.norm(f.blocks.displacement(), axis=1)),
              "speed": ("speed of each block (m/s)", lambda f: f.blocks.speed),
              "compression": ("largest compression of each block (Pa)", lambda f: largest_compression(f.blocks, f.contacts))}
DPI = 130
WIDTH = 7.2  # inches
TITLE, BAR, FOOT, LEGEND = 34, 65, 5, 39  # pixels: above a panel; below all of them, with a bar or without; above all of them
FRAMES_A_SECOND = 15
LARGEST_SCALE = 1e9  # beyond, corners lose their digits
FORCE_COLOURS = plt.get_cmap("inferno_r")
MOST_HEADS = 300  # more arrows have no heads: they would hide each other


class View:
    """Parallel projection towards -direction, z up."""

    def __init__(self, direction):
        self.back = np.array(direction, dtype=float) / np.linalg.norm(direction)
        right = np.cross([0.0, 0.0, 1.0], self.back)
        if np.linalg.norm(right) < 1e-9:
            right = np.array([1.0, 0.0, 0.0])
        self.right = right / np.linalg.norm(right)
        self.up = np.cross(self.back, self.right)
        light = 0.8 * self.back - 0.45 * self.right + np.array([0.0, 0.0, 0.8])
        self.light = light / np.linalg.norm(light)  # towards it: over the left shoulder

    def flat(self, points):
        return np.column_stack([points @ self.right, points @ self.up])


class Frame:
    def __init__(self, time, label, blocks, contacts):
        self.time, self.label = time, label
        self.blocks = Blocks(blocks)
        self.contacts = Contacts(contacts)


def frames_of(folder, times):
    blocks, contacts, labels = series(folder, "blocks"), series(folder, "contacts"), frame_labels(folder)
    shown = shown_times(folder)
    for wanted in times:
        number = min(range(len(blocks)), key=lambda i: abs(blocks[i][0] - wanted))
        yield Frame(shown[number], labels[number], blocks[number][1], contacts[number][1])


def corners_shown(blocks, hidden=()):
    """Of what moves; of all blocks, where nothing does."""
    corners, sizes, block = blocks.polygons()
    kept = ~np.isin(block, hidden)
    moves = kept & (blocks.kind[block] < FIXED)
    return corners[np.repeat(moves if moves.any() else kept, sizes)]


def box_of(frames, view, scale, hidden=()):
    """What is shown of all frames, with a margin: low and high along right and up, m."""
    moving = any((frame.blocks.kind < FIXED).any() for frame in frames)
    flat = np.vstack([view.flat(frame.blocks.placed(scale)[corners_shown(frame.blocks, hidden)])
                      for frame in frames if not moving or (frame.blocks.kind < FIXED).any()])
    low, high = flat.min(axis=0), flat.max(axis=0)
    margin = 0.06 * np.max(high - low)
    return low - margin, high + margin


def raster(corners, sizes, colours, view, centre, scale, width, height, samples=3):
    """(pixels height × width × 3, depth towards the eye, m) of convex polygons; `scale`: pixels a metre."""
    origin = corners[0]  # far from the world's origin, single precision leaves no depth
    centre = centre - view.flat(origin[None])[0]
    head = np.array([width, height, samples, len(sizes), len(corners)], dtype="<i4").tobytes()
    head += np.concatenate([view.right, view.up, view.back, centre, [scale], view.light, [0.5]]).astype("<f8").tobytes()
    first = np.concatenate([[0], np.cumsum(sizes)]).astype("<i4").tobytes()
    done = subprocess.run([COMMAND, "raster"], capture_output=True,
                          input=head + first + (corners - origin).astype("<f8").tobytes() + colours.astype("<f4").tobytes())
    if done.returncode != 0:
        sys.exit(done.stderr.decode(errors="replace").strip())
    pixels = np.frombuffer(done.stdout, "u1", 3 * width * height).reshape(height, width, 3)
    return pixels, np.frombuffer(done.stdout, "<f4", width * height, pixels.size).reshape(height, width) + origin @ view.back


@functools.cache
def quantity(frame, name):
    """Of each block."""
    return QUANTITIES[name][1](frame)


def colours_of(frame, given, limits):
    """Of each block."""
    held = frame.blocks.kind >= FIXED
    colours = FREE[np.arange(len(held)) % len(FREE)]
    if limits is not None:
        value = quantity(frame, given.colour)
        colours = plt.get_cmap("viridis")(Normalize(*limits)(value))[:, :3]
    colours = np.where(held[:, None], HELD, colours)
    return 0.45 * colours + 0.55 if given.forces else colours  # light, so that arrows are seen


def draw_blocks(axis, frame, given, box, limits, pixels):
    """The depth at each pixel."""
    corners, sizes, block = frame.blocks.polygons()
    kept = ~np.isin(block, given.hide)
    corners = frame.blocks.placed(given.scale)[corners[np.repeat(kept, sizes)]]
    scale = pixels[0] / (box[1] - box[0])[0]
    image, depth = raster(corners, sizes[kept], colours_of(frame, given, limits)[block[kept]],
                          given.view, (box[0] + box[1]) / 2, scale, *pixels)
    corner = axis.get_window_extent()
    axis.figure.figimage(image, round(corner.x0), round(corner.y0), origin="upper", zorder=-1)  # imshow would resample
    return depth


def in_sight(points, view, depth, box):
    """Which points no block hides."""
    pixel = (depth.shape[1] - 1) / (box[1] - box[0])[0]
    x, y = ((view.flat(points) - box[0]) * pixel).T
    column = np.clip(x.astype(int), 0, depth.shape[1] - 1)
    row = np.clip(depth.shape[0] - 1 - y.astype(int), 0, depth.shape[0] - 1)
    near = [depth[np.clip(row + i, 0, depth.shape[0] - 1), np.clip(column + j, 0, depth.shape[1] - 1)]
            for i in (-1, 0, 1) for j in (-1, 0, 1)]
    return points @ view.back > np.min(near, axis=0) - 3 / pixel


def draw_contacts(axis, contacts, view, depth, box):
    sight = in_sight(contacts.points, view, depth, box) if len(contacts.points) else np.zeros(0, dtype=bool)
    for _, chosen, style in STATES:
        for shown, alpha in ((sight, 1.0), (~sight, 0.25)):
            axis.plot(*view.flat(contacts.points[chosen(contacts) & shown]).T, linestyle="",
                      markeredgewidth=0.8, alpha=alpha, **style)


def add_legend(figure, frames):
    """Of the states that these frames show, over all panels."""
    shown = [Line2D([], [], linestyle="", markeredgewidth=0.8, label=name, **style)
             for name, chosen, style in STATES if any(chosen(frame.contacts).any() for frame in frames)]
    figure.legend(handles=shown, loc="upper center", ncol=len(STATES), fontsize=10, frameon=False,
                  handletextpad=0.1, columnspacing=1.2)


def draw_forces(axis, joints, view, size, largest):
    """A line through each centre of pressure, along the resultant, as long as it is large; heads: they press. A dot where
    it points to the eye."""
    if not joints:
        return
    centres = view.flat(np.array([joint["centre"] for joint in joints]))
    forces = np.array([joint["force"] for joint in joints])
    share = np.linalg.norm(forces, axis=1) / largest
    half = view.flat(forces) / largest * size * (0.07 if len(joints) <= MOST_HEADS else 0.03)
    shown = np.flatnonzero(share > 0.02)[np.argsort(share[share > 0.02])]
    widths, colours = 0.8 + 2.2 * share, FORCE_COLOURS(0.15 + 0.85 * share)
    if len(joints) > MOST_HEADS:
        axis.add_collection(LineCollection([(centres[i] - half[i], centres[i] + half[i]) for i in shown],
                                           linewidths=widths[shown], colors=colours[shown], zorder=4))
        return
    pointing = np.linalg.norm(half, axis=1) < 0.002 * size
    axis.scatter(*centres[shown[pointing[shown]]].T, s=12 * widths[shown[pointing[shown]]], c=colours[shown[pointing[shown]]], zorder=4)
    for i in shown[~pointing[shown]]:
        for sign in (1, -1):
            axis.annotate("", xy=centres[i], xytext=centres[i] - sign * half[i], zorder=4,
                          arrowprops={"arrowstyle": "-|>", "color": colours[i], "lw": widths[i], "shrinkA": 0,
                                      "shrinkB": 0, "mutation_scale": 4 + 5 * share[i]})


def largest_force(frames):
    return max((np.linalg.norm([j["force"] for j in f.contacts.joints], axis=1).max() for f in frames if f.contacts.joints), default=0.0)


def draw(axis, frame, given, box, bars, pixels):
    axis.set(xlim=(box[0][0], box[1][0]), ylim=(box[0][1], box[1][1]), aspect="auto")
    axis.axis("off")
    depth = draw_blocks(axis, frame, given, box, bars.get("colour"), pixels)
    if given.contacts:
        draw_contacts(axis, frame.contacts, given.view, depth, box)
    if "forces" in bars:
        draw_forces(axis, frame.contacts.joints, given.view, np.max(box[1] - box[0]), bars["forces"][1])
    words = f"t = {frame.time:.3g} s" + (f", {frame.label}" if frame.label else "")
    words += f", displacements × {given.scale:g}" if given.scale != 1 else ""
    axis.set_title(words, fontsize=9, loc="left", color="#222222", pad=3)


def bars_of(frames, given):
    """{what: (least, largest)} of the colour bars, over all frames."""
    bars = {}
    if given.colour != "block":
        values = [quantity(f, given.colour)[f.blocks.kind < FIXED] for f in frames]
        low, high = min(v.min(initial=0.0) for v in values), max(v.max(initial=0.0) for v in values)
        bars["colour"] = (low, high if high > low else low + 1.0)
    largest = largest_force(frames) if given.forces else 0.0
    if largest > 0:
        bars["forces"] = (0.0, largest)
    return bars


def add_bars(figure, bars, given):
    for number, (what, (low, high)) in enumerate(bars.items()):
        height, width = figure.get_figheight(), 0.8 / len(bars)
        axis = figure.add_axes([0.1 + number * (width + 0.03), 0.34 / height, width - 0.03, 0.1 / height])
        if what == "forces":
            shown = ScalarMappable(Normalize(low, high / 1000), matplotlib.colors.ListedColormap(
                FORCE_COLOURS(np.linspace(0.15, 1, 256))))
        else:
            shown = ScalarMappable(Normalize(low, high), "viridis")
        bar = figure.colorbar(shown, cax=axis, orientation="horizontal")
        bar.ax.tick_params(labelsize=8, pad=1, length=2)
        bar.set_label("resultant on each joint (kN)" if what == "forces" else QUANTITIES[given.colour][0],
                      fontsize=8, labelpad=1)


class Layout:
    """Panels of whole pixels at whole pixels: their images are not scaled."""

    def __init__(self, box, count, width, given, bars):
        self.columns = 2 if count > 1 else 1
        rows = (count + self.columns - 1) // self.columns
        shape = np.clip((box[1] - box[0])[1] / (box[1] - box[0])[0], 0.2, 1.1)
        self.column = int(width * DPI / self.columns)
        self.pixels = (self.column - 6, int((self.column - 6) * shape))
        self.top, self.panel = LEGEND if given.contacts else 0, self.pixels[1] + TITLE
        sides = self.column * self.columns, self.top + rows * self.panel + (BAR if bars else FOOT)
        self.sides = [side + side % 2 for side in sides]  # as .mp4 wants it
        self.size = [(side + 0.01) / DPI for side in self.sides]  # inches, that are rounded down to pixels
        low, high = box
        grown = (high - low)[0] * self.pixels[1] / self.pixels[0] - (high - low)[1]
        wide = max(0.0, -grown) * self.pixels[0] / self.pixels[1]
        more = np.array([wide, max(0.0, grown)]) / 2
        self.box = (low - more, high + more)

    def axes(self, figure, number):
        row, column = divmod(number, self.columns)
        (width, height), (wide, high) = self.sides, self.pixels
        return figure.add_axes([(column * self.column + 3) / width, 1 - (self.top + (row + 1) * self.panel) / height,
                                wide / width, high / height])


def paint(figure, frames, given, layout, bars):
    for number, frame in enumerate(frames):
        draw(layout.axes(figure, number), frame, given, layout.box, bars, layout.pixels)
    if given.contacts:
        add_legend(figure, frames)
    add_bars(figure, bars, given)


def sheet(frames, given):
    bars = bars_of(frames, given)
    layout = Layout(given.box or box_of(frames, given.view, given.scale, given.hide), len(frames), WIDTH, given, bars)
    figure = plt.figure(figsize=layout.size, dpi=DPI)
    paint(figure, frames, given, layout, bars)
    figure.savefig(given.picture, dpi=DPI, pil_kwargs={"optimize": True})
    plt.close(figure)


def animation(frames, given):
    is_gif = given.picture.lower().endswith(".gif")
    if not is_gif and shutil.which("ffmpeg") is None:
        sys.exit("quoin picture: .mp4 needs ffmpeg, which is not installed; .gif and .png do not")
    bars = bars_of(frames, given)
    layout = Layout(box_of(frames, given.view, given.scale, given.hide), 1, 5.0, given, bars)
    figure = plt.figure(figsize=layout.size, dpi=DPI)
    writer = (PillowWriter if is_gif else FFMpegWriter)(fps=FRAMES_A_SECOND)
    try:
        with writer.saving(figure, given.picture, dpi=DPI):
            for frame in frames:
                figure.clear()
                paint(figure, [frame], given, layout, bars)
                writer.grab_frame()
    except subprocess.CalledProcessError as error:
        sys.exit(f"quoin picture: {given.picture}: {error}")


def render(folder, path, times, direction=(-0.45, -1.0, 0.42), fit=None, hidden=(), **more):
    """A sheet as main() makes it. `fit`: the box to show, low and high corner, m; `hidden`: blocks left out."""
    view = View(direction)
    corners = None
    if fit is not None:
        corners = view.flat(np.array([[fit[i], fit[1 + j], fit[2 + k]] for i in (0, 3) for j in (0, 3) for k in (0, 3)]))
        corners = (corners.min(axis=0), corners.max(axis=0))
    given = argparse.Namespace(picture=str(path), view=view, box=corners, hide=list(hidden),
                               **{"scale": 1.0, "forces": False, "contacts": False, "colour": "block", **more})
    sheet(list(frames_of(folder, times)), given)


def refuse(words):
    print(f"quoin picture: {words}", file=sys.stderr)
    sys.exit(2)


def main():
    parser = argparse.ArgumentParser(prog="quoin picture", description=__doc__.splitlines()[0])
    parser.add_argument("run", help="folder that quoin run --out left")
    parser.add_argument("picture", help=".png; or .gif, .mp4: an animation of all times")
    parser.add_argument("--times", type=float, nargs="+", help="s; default: four from start to end")
    parser.add_argument("--colour", choices=["block", *QUANTITIES], default="block", help="of blocks (default: block)")
    parser.add_argument("--scale", type=float, default=1.0, help="of displacements (default 1)")
    parser.add_argument("--forces", action="store_true", help="the resultant that bears on each joint")
    parser.add_argument("--contacts", action="store_true",
                        help="contact points by state: open, stick, slip, failed (residual strength)")
    parser.add_argument("--from", dest="direction", type=float, nargs=3, default=(-0.45, -1.0, 0.42),
                        metavar=("X", "Y", "Z"), help="direction towards the eye (default -0.45 -1 0.42)")
    parser.add_argument("--hide", type=int, nargs="+", default=[], help="numbers of blocks that are left out")
    given = parser.parse_args()
    if not 0 < np.linalg.norm(given.direction) < np.inf:
        refuse("--from: must be a direction that is not zero")
    if not 0 <= given.scale <= LARGEST_SCALE:
        refuse(f"--scale {given.scale:g}: must lie in 0 … {LARGEST_SCALE:g}")
    given.view, given.box = View(given.direction), None
    ending = pathlib.Path(given.picture).suffix.lower()
    if ending not in (".png", ".gif", ".mp4"):
        refuse(f"{given.picture}: the picture must end in .png, .gif or .mp4")
    all_times = [time for time, _ in series(given.run, "blocks")]
    slack = 1e-6 * (all_times[-1] - all_times[0])
    for time in given.times or []:
        if not all_times[0] - slack <= time <= all_times[-1] + slack:
            refuse(f"--times {time:g}: the run goes from {all_times[0]:g} to {all_times[-1]:g} s")
    times = all_times if ending != ".png" else sorted(set(np.linspace(all_times[0], all_times[-1], min(4, len(all_times)))))
    frames = list(frames_of(given.run, given.times or times))
    count = len(frames[0].blocks.kind)
    if not set(given.hide) < set(range(count)):
        refuse(f"--hide: must name some, not all, of the blocks 0 … {count - 1}")
    (sheet if ending == ".png" else animation)(frames, given)


if __name__ == "__main__":
    run_program(main)
