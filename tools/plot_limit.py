#!/usr/bin/env python3
"""Pictures of the certificates that `quoin limit --out` left, seen along an axis.

    tools/plot_limit.py DIR OUT.png [--along x|y|z]

falls.json: blocks moved by their velocities; joints that turn (hinges) and that slide are marked.
stands.json: resultants of the joints, in the points where they act; least_stands.json and greatest_stands.json
(`quoin limit --thrust`): both lines of thrust, and between them the zone of all thrusts.
"""
import argparse
import json
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.patches import Polygon  # noqa: E402
from scipy.spatial import ConvexHull  # noqa: E402

from check_limit import Solid  # noqa: E402

FIXED, FREE = "#c3c0ba", "#e0b070"
HINGE, SLIDE = "#0072B2", "#D55E00"  # told apart by everybody (Okabe and Ito)
MOVES = 0.02  # of the fastest corner: less is not marked
LARGEST = 0.08  # displacement, of the picture
MANY = 60  # blocks, from which on marks and lines shrink with them


def joints(document):
    """{(a, b): contacts}; held points are no joints."""
    pairs = {}
    for contact in document["contacts"]:
        if not contact["held"]:
            pairs.setdefault((contact["a"], contact["b"]), []).append(contact)
    return pairs


def motion(solids, pair, contacts):
    """hinge, slide or None: one edge opens while another stays; all points slip."""
    a, b = (solids[i] for i in pair)
    opening, slip = [], []
    for contact in contacts:
        point, normal = np.array(contact["point"]), np.array(contact["normal"])
        v = b.velocity(point) - a.velocity(point)
        opening.append(v @ normal)
        slip.append(np.linalg.norm(v - (v @ normal) * normal))
    fastest = max(np.abs(solid.entry["velocity"]).max() for solid in solids.values()) or 1.0
    if max(opening) - min(opening) > MOVES * fastest:
        return "hinge", np.array(contacts[int(np.argmin(opening))]["point"])
    if min(slip) > MOVES * fastest:
        return "slide", np.mean([c["point"] for c in contacts], axis=0)
    return None, None


def resultant(contacts):
    """Force on b, and where it crosses the joint: the middle of the points, weighed by normal forces."""
    forces = np.array([c["force"] for c in contacts])
    weights = np.array([max(0.0, np.dot(c["force"], c["normal"])) for c in contacts])
    if not weights.sum() > 0:
        return None, None
    return forces.sum(axis=0), weights @ np.array([c["point"] for c in contacts]) / weights.sum()


def size(largest, solids):
    return largest * min(1.0, (MANY / len(solids)) ** 0.5)


def draw_blocks(axes, solids, keep, scale=0.0):
    for solid in solids.values():
        for part in solid.parts:
            corners = np.array([p + scale * solid.velocity(p) for p in part.points])[:, keep]
            axes.add_patch(Polygon(corners[ConvexHull(corners).vertices], edgecolor="#50402c", lw=size(0.6, solids),
                                   facecolor=FREE if solid.moves else FIXED))
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.axis("off")


def solids_of(document):
    return {block["index"]: Solid(block) for block in document["blocks"]}


def draw_falls(axes, document, keep):
    solids = solids_of(document)
    corners = np.concatenate([solid.points for solid in solids.values()])
    fastest = max(np.abs(solid.velocity(p)).max() for solid in solids.values() for p in solid.points)
    scale = LARGEST * np.ptp(corners, axis=0).max() / fastest
    draw_blocks(axes, solids, keep, scale)
    counts = {"hinge": 0, "slide": 0}
    for pair, contacts in joints(document).items():
        kind, point = motion(solids, pair, contacts)
        if kind:
            counts[kind] += 1
            place = (point + scale * solids[pair[1]].velocity(point))[keep]
            axes.plot(*place, "o" if kind == "hinge" else "s", color=HINGE if kind == "hinge" else SLIDE,
                      ms=size(5, solids))
    axes.set_title(f"mechanism: {counts['hinge']} joints turn (circles), {counts['slide']} slide (squares)", fontsize=9)


def thrust_points(document, keep):
    points = [resultant(contacts)[1] for contacts in joints(document).values()]
    return np.array([p[keep] for p in points if p is not None])


def draw_stands(axes, documents, keep):
    draw_blocks(axes, solids := solids_of(documents[0]), keep)
    lines = [thrust_points(document, keep) for document in documents]
    if len(lines) == 2 and len(lines[0]) == len(lines[1]):
        for one, other in zip(*lines):
            axes.plot(*np.array([one, other]).T, color=HINGE, lw=3, alpha=.5, solid_capstyle="round")
    for line, colour in zip(lines, (SLIDE, HINGE)):
        axes.plot(*line.T, "o", color=colour, ms=size(3, solids))
    axes.set_title("where joints press" if len(lines) == 1 else "zone of thrust, least (orange) to greatest (blue)",
                   fontsize=9)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("picture")
    parser.add_argument("--along", choices="xyz", default="y")
    arguments = parser.parse_args()
    keep = {"x": [1, 2], "y": [0, 2], "z": [0, 1]}[arguments.along]

    def documents(*names):
        paths = [arguments.folder / f"{name}.json" for name in names]
        return [json.loads(path.read_text(encoding="utf-8")) for path in paths if path.exists()]

    panels = [(draw_falls, found) for name in ("falls", "shrink_falls") for found in documents(name)]
    panels += [(draw_stands, found) for found in [documents("least_stands", "greatest_stands"), documents("stands")]
               if found]
    if not panels:
        parser.error(f"{arguments.folder}: there is no certificate")
    figure, axes = plt.subplots(1, len(panels), figsize=(6 * len(panels), 4.5), squeeze=False)
    for (draw, found), place in zip(panels, axes[0]):
        draw(place, found, keep)
    figure.savefig(arguments.picture, dpi=130, bbox_inches="tight")


if __name__ == "__main__":
    main()
