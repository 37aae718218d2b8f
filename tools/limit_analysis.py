#!/usr/bin/env python3
"""Limit analysis of rigid blocks by linear programming: an answer that shares no code with the solver.

    tools/limit_analysis.py SCENE.json --live X Y Z    # its limit load factor
    tools/limit_analysis.py --write                    # tools/stability/limit_loads.json anew
    tools/limit_analysis.py --check                    # does that file hold? Exit code 1: no

The dead load is the weight of every block; the live load is its weight times the load factor along a
direction. The largest load factor is sought for which contact forces in equilibrium with both exist: at the
corners of each flush joint a compression and friction within Coulomb's cone [Livesley 1978]. The cone is taken
as a pyramid of 48 sides inside it (`inner`) and around it (`outer`); one edge lies along the live load.

Above `outer` there is no equilibrium whatever the flow rule: the structure moves. This is the static theorem, for
which friction need not be associated. Below `inner` there is one, but with Coulomb friction, which is not
associated, that is an upper bound alone [Drucker 1954]: it decides where friction plays no part in the collapse
(`hinging`: the limit is the same with twice the coefficient; Heyman's conditions), and where one plane
slides, whose forces statics alone give.

Reads scene files whose blocks are rigid or deformable boxes, prisms, hulls and polyhedra, with their poses and
expressions. What the analysis does not know, as cohesion, loads or other gravity, is refused.
Sources: Livesley, Limit analysis of structures formed from rigid blocks, Int. J. Num. Meth. Eng. 12, 1978,
1853-1871. Drucker, Coulomb friction, plasticity, and limit loads, J. Appl. Mech. 21, 1954, 71-74.
Heyman, The stone skeleton, Int. J. Solids Structures 2, 1966, 249-279.
"""
import argparse
import json
import math
import pathlib
import sys

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_matrix
from scipy.spatial import ConvexHull

from formula import evaluated

TOOLS = pathlib.Path(__file__).resolve().parent
LOADS = TOOLS / "stability" / "limit_loads.json"
SIDES = 48          # of the pyramid: inner and outer differ by 1 - cos(pi/48) = 2.1e-3 at most
FLUSH = 1e-9        # of the size of a block: planes and edges this near are one
SAME = 1e-7         # of a load factor: what the linear programme is solved to
MOST = 1e3          # load factor: what stands more than that is not limited by its joints


KNOWN = {"$schema", "title", "description", "parameters", "gravity", "materials", "joint", "blocks", "initial_overlap",
         "coordinate_rounding", "method", "contact_iteration", "linear_solver", "penalty", "shear_ratio", "scheme",
         "time_step", "smallest_time_step", "tolerance", "reach", "max_iterations", "max_displacement_ratio",
         "end_time", "stages", "monitors", "references", "output_interval", "history_every"}
FUNCTIONS = {name: getattr(math, name) for name in ("sin", "cos", "tan", "asin", "acos", "atan", "sqrt", "exp")}


def numbers(value, names):
    """The same tree with its expressions evaluated."""
    if isinstance(value, dict):
        return {key: numbers(part, names) for key, part in value.items()}
    if isinstance(value, list):
        return [numbers(part, names) for part in value]
    if not (isinstance(value, str) and value.startswith("=")):
        return value
    return float(evaluated(value[1:], names))


def known_scene(scene):
    """The scene, numbers for expressions; ValueError where its limit load would be another than the analysis finds."""
    names = {**FUNCTIONS, "pi": math.pi, "deg": math.pi / 180, "g": 9.81, **scene.get("parameters", {})}
    scene = {key: numbers(scene[key], names) for key in scene if key not in ("monitors", "references", "stages")} | \
            {"stages": scene.get("stages", [])}
    for key in scene:
        if key not in KNOWN:
            raise ValueError(f"/{key}: the analysis knows no {key}")
    for key, value in scene["joint"].items():
        if key not in ("friction_angle_deg", "restitution") and value:
            raise ValueError(f"/joint/{key}: joints have friction alone here")
    for stage in scene["stages"]:
        for key in stage:
            if key not in ("name", "analysis", "duration", "time_step", "max_steps", "until"):
                raise ValueError(f"/stages: the analysis knows no {key}")
    gravity = scene.get("gravity", [0, 0, -9.81])
    if not (isinstance(gravity, list) and len(gravity) == 3 and gravity[:2] == [0, 0] and
            isinstance(gravity[2], (int, float)) and gravity[2] < 0):
        raise ValueError("/gravity: has to be constant and along -z")
    return scene


def rotation_of(pose):
    if "matrix" in pose:
        return np.array(pose["matrix"], float)
    if "quaternion" in pose:
        w, *v = np.array(pose["quaternion"], float) / np.linalg.norm(pose["quaternion"])
        angle, axis = 2 * math.atan2(np.linalg.norm(v), w), np.array(v)
    else:
        angle, axis = math.radians(pose["angle_deg"]), np.array(pose["axis"], float)
    if np.linalg.norm(axis) == 0:
        return np.eye(3)
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def vertices_of(shape):
    if shape["type"] == "box":
        low, high = np.array(shape["min"], float), np.array(shape["max"], float)
        return np.array([[(low, high)[i][0], (low, high)[j][1], (low, high)[k][2]]
                         for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    if shape["type"] == "prism":
        polygon = np.array(shape["polygon"], float)
        return np.concatenate([polygon, polygon + np.array(shape["sweep"], float)])
    if shape["type"] in ("hull", "polyhedron"):
        return np.array(shape["points" if shape["type"] == "hull" else "vertices"], float)
    raise ValueError(f"blocks of the type {shape['type']!r} are not known here")


def placed(points, pose):
    about = np.array(pose.get("about", [0, 0, 0]), float)
    rotation = rotation_of(pose["rotation"]) if "rotation" in pose else np.eye(3)
    return (points - about) @ rotation.T + about + np.array(pose.get("translation", [0, 0, 0]), float)


class Block:
    """Volume, mass, centroid and faces (normal, corners in order) of a convex solid."""

    def __init__(self, entry, materials):
        kind = entry.get("kind", "deformable")
        if kind not in ("fixed", "rigid", "deformable"):
            raise ValueError(f"block {entry.get('name')!r}: the kind {kind!r} is not known here")
        self.free = kind != "fixed"
        points = placed(vertices_of(entry["shape"]), entry.get("pose", {}))
        self.size = np.ptp(points, axis=0).max()
        hull = ConvexHull(points)
        self.volume = hull.volume
        material = materials[entry["material"]] if "material" in entry else next(iter(materials.values()))
        self.mass = self.volume * material["density"]
        inner = points.mean(axis=0)
        parts = [(abs(np.linalg.det(points[s] - inner)) / 6, (points[s].sum(axis=0) + inner) / 4)
                 for s in hull.simplices]
        self.centroid = sum(v * c for v, c in parts) / self.volume
        self.faces = []
        for plane in np.unique(hull.equations.round(9), axis=0):
            normal = plane[:3] / np.linalg.norm(plane[:3])
            height = (points @ normal).max()
            on = points[points @ normal > height - 1e-7 * self.size]
            along = np.linalg.svd(on - on.mean(axis=0))[2][0]
            flat = (on - on.mean(axis=0)) @ np.array([along, np.cross(normal, along)]).T
            self.faces.append((normal, on[np.argsort(np.arctan2(flat[:, 1], flat[:, 0]))]))


def clipped(polygon, normal, clip):
    """The part of a convex polygon inside another one in its plane (Sutherland and Hodgman)."""
    for start, end in zip(clip, np.roll(clip, -1, axis=0)):
        inward = np.cross(normal, end - start)
        inward /= np.linalg.norm(inward)
        heights = (polygon - start) @ inward
        heights[np.abs(heights) < FLUSH * np.ptp(clip, axis=0).max()] = 0.0
        kept = []
        for i in range(len(polygon)):
            j = (i + 1) % len(polygon)
            if heights[i] >= 0:
                kept.append(polygon[i])
            if heights[i] * heights[j] < 0:
                share = heights[i] / (heights[i] - heights[j])
                kept.append(polygon[i] + share * (polygon[j] - polygon[i]))
        if len(kept) < 3:
            return None
        polygon = np.array(kept)
    return polygon if np.ptp(polygon, axis=0).max() > FLUSH else None


def area_of(polygon):
    return 0.5 * np.linalg.norm(sum(np.cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0])
                                    for i in range(1, len(polygon) - 1)))


def joints_of(blocks):
    """(a, b, normal from a to b, corners) of every pair of flush faces that share an area."""
    joints = []
    for b, second in enumerate(blocks):
        for a, first in enumerate(blocks[:b]):
            size = min(first.size, second.size)
            for normal, corners in first.faces:
                for other, corners_b in second.faces:
                    if normal @ other > FLUSH - 1 or abs((corners_b[0] - corners[0]) @ normal) > 1e-7 * size:
                        continue
                    shared = clipped(corners_b[::-1], normal, corners)
                    if shared is not None and area_of(shared) > 1e-7 * size**2:
                        joints.append((a, b, normal, shared))
    return joints


def generators(normal, live, friction):
    """Edges of the pyramid in place of Coulomb's cone, one a row; the first along the live load."""
    along = live - (live @ normal) * normal
    if np.linalg.norm(along) < 1e-6:
        along = np.eye(3)[np.argmin(np.abs(normal))]
        along = along - (along @ normal) * normal
    along /= np.linalg.norm(along)
    turns = 2 * math.pi * np.arange(SIDES) / SIDES
    across = np.cross(normal, along)
    return normal + friction * (np.outer(np.cos(turns), along) + np.outer(np.sin(turns), across))


def load_factor(blocks, friction, live):
    """The largest load factor; None when there is no equilibrium with the dead load alone."""
    rows_of = {block: 6 * i for i, block in enumerate(i for i, b in enumerate(blocks) if b.free)}
    rows, columns, values, column = [], [], [], 0

    def push(block, place, forces):
        if block in rows_of:
            moments = np.cross(place - blocks[block].centroid, forces)
            part = np.hstack([forces, moments])
            for component in range(6):
                rows.extend([rows_of[block] + component] * len(forces))
                columns.extend(range(column, column + len(forces)))
                values.extend(part[:, component])

    for a, b, normal, corners in joints_of(blocks):
        for corner in corners:
            forces = generators(normal, live, friction)
            push(b, corner, forces)
            push(a, corner, -forces)
            column += len(forces)
    weight = sum(blocks[i].mass for i in rows_of)
    dead, pushed = np.zeros(6 * len(rows_of)), np.zeros(6 * len(rows_of))
    for block, row in rows_of.items():
        share = blocks[block].mass / weight
        dead[row + 2] = share           # what the contacts must carry: + weight
        pushed[row:row + 3] = share * live
    for component in np.flatnonzero(pushed):
        rows.append(component)
        columns.append(column)
        values.append(pushed[component])
    matrix = coo_matrix((values, (rows, columns)), shape=(len(dead), column + 1))
    aim = np.zeros(column + 1)
    aim[-1] = -1.0
    solved = linprog(aim, A_eq=matrix.tocsc(), b_eq=dead, bounds=[(0, None)] * column + [(0, MOST)],
                     method="highs")
    if solved.status == 2:
        return None
    if solved.status != 0:
        raise RuntimeError(f"the linear programme was not solved: {solved.message}")
    return float(solved.x[-1])


def limit_of(scene, live):
    """{inner, outer, hinging} of a scene; load factors null: it does not stand under its own weight."""
    scene = known_scene(scene)
    blocks = [Block(entry, scene["materials"]) for entry in scene["blocks"]]
    friction = math.tan(math.radians(scene["joint"]["friction_angle_deg"]))
    live = np.array(live, float)
    inner = load_factor(blocks, friction, live)
    outer = load_factor(blocks, friction / math.cos(math.pi / SIDES), live)
    rough = load_factor(blocks, 2 * friction, live)
    hinging = inner is None and rough is None or \
        None not in (inner, rough) and abs(rough - inner) <= SAME * max(rough, 1.0)
    return {"inner": inner, "outer": outer, "hinging": hinging}


def read(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def limit_of_file(entry):
    return limit_of(read(TOOLS / "scenes" / entry["scene"]), entry["live"])


def same(stored, found):
    if stored is None or found is None or isinstance(stored, bool):
        return stored == found
    return abs(stored - found) <= SAME * max(abs(stored), 1.0)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", nargs="?")
    parser.add_argument("--live", nargs=3, type=float, default=[1.0, 0.0, 0.0])
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    if given.scene:
        try:
            print(json.dumps(limit_of(read(given.scene), given.live)))
        except (OSError, ValueError, KeyError) as error:  # JSON's errors are ValueErrors
            missing = f"no {error}" if isinstance(error, KeyError) else error
            print(f"limit_analysis.py: {given.scene}: {missing}", file=sys.stderr)
            return 2
        return 0
    entries, failed = read(LOADS), 0
    for entry in entries:
        found = limit_of_file(entry)
        bad = [key for key, value in found.items() if not same(entry.get(key), value)]
        failed += bool(bad)
        print(f"{entry['name']}: {found}" + (f"; the file has another {', '.join(bad)}" if bad else ""))
        entry.update(found)
    if given.write:
        LOADS.write_text("[\n  " + ",\n  ".join(map(json.dumps, entries)) + "\n]\n", encoding="utf-8")
        return 0
    return 1 if failed and given.check else 0


if __name__ == "__main__":
    sys.exit(main())
