#!/usr/bin/env python3
"""Pictures of the blocks of a run at given times, ray-traced by POV-Ray (no display needed).

    tools/render.py RUN_FOLDER OUT.png --times 0 1 2 3 [--from X Y Z] [--fit X0 Y0 Z0 X1 Y1 Z1] [--hide BLOCK …]

RUN_FOLDER is what `quoin run --out` left. The picture has one panel for each time.
"""
import argparse
import os
import pathlib
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.patheffects import withStroke  # noqa: E402

import vtk_file  # noqa: E402

HELD = (0.74, 0.73, 0.70)
FREE = [(0.78, 0.42, 0.27), (0.86, 0.66, 0.38), (0.36, 0.50, 0.60), (0.50, 0.58, 0.40),
        (0.66, 0.36, 0.38), (0.45, 0.42, 0.58), (0.80, 0.55, 0.45), (0.35, 0.55, 0.53)]
WIDTH, HEIGHT = 960, 600
FIXED, PRESCRIBED = 2, 3  # solver::BlockKind


def read_blocks(path):
    """[(points n×3, faces, is_held)] of a .vtu file."""
    _, arrays = vtk_file.read(path)
    points = np.array(arrays["Points"])
    stream = iter(arrays["faces"])
    blocks = []
    for kind in arrays["kind"]:
        faces = [[next(stream) for _ in range(next(stream))] for _ in range(next(stream))]
        used = sorted({v for face in faces for v in face})
        local = {v: i for i, v in enumerate(used)}
        blocks.append((points[used], [[local[v] for v in face] for face in faces],
                       kind in (FIXED, PRESCRIBED)))
    return blocks


def series(folder):
    """[(time, file)] of blocks.pvd."""
    root = xml.parse(folder / "blocks.pvd").getroot()
    return [(float(d.get("timestep")), folder / d.get("file")) for d in root.iter("DataSet")]


def vec(v):
    return "<%.9g,%.9g,%.9g>" % tuple(v)


def pov_block(points, faces, colour, edge):
    """Flat faces and thin dark edges."""
    triangles = "".join(
        "triangle{%s,%s,%s}" % (vec(points[f[0]]), vec(points[f[i]]), vec(points[f[i + 1]]))
        for f in faces for i in range(1, len(f) - 1))
    edges = {tuple(sorted((f[i], f[(i + 1) % len(f)]))) for f in faces for i in range(len(f))}
    lines = "".join("cylinder{%s,%s,%.6g}" % (vec(points[a]), vec(points[b]), edge)
                    for a, b in sorted(edges) if np.linalg.norm(points[a] - points[b]) > 0)
    balls = "".join("sphere{%s,%.6g}" % (vec(p), edge) for p in points)
    dark = tuple(0.45 * c for c in colour)
    return (f"mesh{{{triangles} texture{{pigment{{srgb {vec(colour)}}} finish{{Stone}}}}}}\n"
            f"union{{{lines}{balls} texture{{pigment{{srgb {vec(dark)}}} finish{{Stone}}}}}}\n")


def pov_scene(blocks, low, high, direction):
    middle, size = (low + high) / 2, np.linalg.norm(high - low)
    direction = np.array(direction, dtype=float) / np.linalg.norm(direction)
    eye = middle + 1.75 * size * direction
    ground = min(points[:, 2].min() for points, _, _ in blocks) - 1e-3 * size
    light = middle + size * np.array([-1.3, -1.9, 2.9])
    text = f"""#version 3.7;
global_settings {{ assumed_gamma 1.0 }}
#declare Stone = finish {{ ambient 0.16 diffuse 0.74 specular 0.06 roughness 0.06 }};
background {{ srgb <0.96,0.97,0.98> }}
camera {{ location {vec(eye)} sky <0,0,1> right -x*{WIDTH}/{HEIGHT} angle 36 look_at {vec(middle)} }}
light_source {{ {vec(light)} rgb <1.02,0.98,0.92>*1.05
  area_light <{0.5 * size:.6g},0,0>,<0,{0.5 * size:.6g},0>,5,5 adaptive 1 jitter circular orient }}
light_source {{ {vec(eye + size * np.array([0.5, 0, 0.6]))} rgb <0.24,0.26,0.30> shadowless }}
plane {{ z, {ground:.9g} texture {{ pigment {{ srgb <0.95,0.95,0.94> }}
  finish {{ ambient 0.22 diffuse 0.72 }} }} }}
fog {{ distance {20 * size:.6g} srgb <0.96,0.97,0.98> }}
"""
    free = 0
    for points, faces, held in blocks:
        colour = HELD if held else FREE[free % len(FREE)]
        free += not held
        text += pov_block(points, faces, colour, 0.0011 * size)
    return text


def trace(text):
    """The picture of a POV-Ray scene."""
    with tempfile.TemporaryDirectory() as folder:
        scene = pathlib.Path(folder) / "scene.pov"
        scene.write_text(text, encoding="utf-8")
        done = subprocess.run(
            ["povray", "+Iscene.pov", "+Oscene.png", f"+W{WIDTH}", f"+H{HEIGHT}", "+A0.2", "+AM2",
             "-D", "+Q9", "-GA", "Work_Threads=" + str(os.cpu_count() or 1)],
            cwd=folder, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit("povray: " + done.stderr[-2000:])
        return plt.imread(pathlib.Path(folder) / "scene.png")


def frames(folder, times, hidden):
    listed = series(folder)
    for wanted in times:
        time, path = min(listed, key=lambda entry: abs(entry[0] - wanted))
        yield time, [block for number, block in enumerate(read_blocks(path)) if number not in hidden]


def span(shots):
    """Box around all blocks that move, at all times."""
    moving = np.vstack([points for _, blocks in shots for points, _, held in blocks if not held])
    return moving.min(axis=0), moving.max(axis=0)


def sheet(images, times, path):
    columns = 2 if len(images) > 1 else 1
    rows = (len(images) + columns - 1) // columns
    figure, axes = plt.subplots(rows, columns, squeeze=False,
                                figsize=(5.0 * columns, 5.0 * columns * rows / columns * HEIGHT / WIDTH))
    for axis in axes.flat:
        axis.axis("off")
    for axis, image, time in zip(axes.flat, images, times):
        axis.imshow(image)
        axis.text(0.025, 0.94, f"t = {time:.3g} s", transform=axis.transAxes, va="top",
                  fontsize=11, color="#222222",
                  path_effects=[withStroke(linewidth=3, foreground="#f4f4f4")])
    figure.subplots_adjust(0, 0, 1, 1, 0.012, 0.018)
    figure.savefig(path, dpi=120, pil_kwargs={"optimize": True})
    plt.close(figure)


def render(folder, path, times, direction=(-0.45, -1.0, 0.42), fit=None, hidden=()):
    shots = list(frames(pathlib.Path(folder), times, hidden))
    low, high = (np.array(fit[:3]), np.array(fit[3:])) if fit else span(shots)
    images = [trace(pov_scene(blocks, low, high, direction)) for _, blocks in shots]
    sheet(images, [time for time, _ in shots], path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder")
    parser.add_argument("picture")
    parser.add_argument("--times", type=float, nargs="+", required=True, help="s")
    parser.add_argument("--from", dest="direction", type=float, nargs=3, default=(-0.45, -1.0, 0.42),
                        help="direction towards the eye")
    parser.add_argument("--fit", type=float, nargs=6, help="box to show, m; default: all that moves")
    parser.add_argument("--hide", type=int, nargs="+", default=(), help="numbers of blocks that are not drawn")
    given = parser.parse_args()
    render(given.folder, given.picture, given.times, given.direction, given.fit, given.hide)


if __name__ == "__main__":
    main()
