#!/usr/bin/env python3
"""Checks certificates of `quoin limit` and `quoin run` by itself: numpy and scipy alone, contacts anew from vertices.

    tools/check_limit.py DIR [SCENE.json]    # DIR/*stands.json, *falls.json, mechanism.json; exit code 0: all proved
With SCENE.json also that densities, vertices, loads and joints are those of the scene (check_limit_scene.py).
stands: forces balance weight and load of every block that moves, act where two blocks touch (or hold a held point),
and stay within |f_t| <= mu f_n + C A, f_n >= -t A; A: area; C: max(c, mu t), of a run c + mu t (tools/guides/limit.md).
falls: along the velocities no contact closes (v_n >= mu |v_t|), no held point moves, and the loads do more work than
cohesion and tension can take. Then no forces within these limits balance the loads [Drucker, Prager & Greenberg 1952].
"""
import itertools
import json
import pathlib
import sys
import numpy as np
from scipy.spatial import ConvexHull, QhullError
import check_limit_scene

NEAR = 2e-6                   # of the smaller block: what touches
ALLOWED, SHORT = 1e-7, 1e-7   # unbalance and forces outside their limits, by the largest load; closing, by speed

class Solid:
    def __init__(self, entry):
        if "parts" in entry:
            sys.exit(f"block {entry['name']}: of several parts, which are not checked")
        self.points, self.moves, self.entry = np.array(entry["vertices"], float), entry["moves"], entry
        self.size = np.linalg.norm(np.ptp(self.points, axis=0))
        middle = self.points.mean(axis=0)
        hull = ConvexHull(self.points - middle)
        corners = self.points[hull.simplices] - middle
        parts = np.abs(np.linalg.det(corners)) / 6
        self.volume = parts.sum()
        self.centroid = middle + (parts[:, None] * corners.sum(axis=1) / 4).sum(axis=0) / self.volume
        normals = np.unique(hull.equations[:, :3].round(9), axis=0)
        self.normals = normals / np.linalg.norm(normals, axis=1)[:, None]
        edges = np.array([self.points[[i, j]] for s in hull.simplices for i, j in itertools.combinations(s, 2)])
        edges = (edges[:, 1] - edges[:, 0]) / np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)[:, None]
        edges *= np.sign(edges[np.arange(len(edges)), np.abs(edges).argmax(axis=1)])[:, None]
        self.edges = np.unique(edges.round(9), axis=0)
    def load(self, gravity, factor):
        weight = np.concatenate([self.entry["density"] * self.volume * gravity, np.zeros(3)])
        return weight + np.array(self.entry["applied"], float) + factor * np.array(self.entry["live"], float)
    def velocity(self, point):
        v = np.array(self.entry["velocity"], float)
        return v[:3] + np.cross(v[3:], point - self.centroid)

def normal_between(a, b):
    """Unit normal from a to b of the widest gap, and that gap (separating axes)."""
    crosses = np.cross(a.edges[:, None], b.edges[None]).reshape(-1, 3)
    crosses = crosses[np.linalg.norm(crosses, axis=1) > 1e-6]
    crosses /= np.linalg.norm(crosses, axis=1)[:, None]
    normals = np.concatenate([a.normals, -b.normals, crosses, -crosses])
    gaps = (normals @ b.points.T).min(axis=1) - (normals @ a.points.T).max(axis=1)
    return normals[np.argmax(gaps > gaps.max() - 1e-9 * min(a.size, b.size))], gaps.max()

def outline(points):
    try:
        return points[ConvexHull(points).vertices]
    except (QhullError, ValueError):  # a point, or a segment: its ends
        along = points - points.mean(axis=0)
        key = along @ np.linalg.svd(along)[2][0]
        return points[[key.argmin(), key.argmax()]]

def inside(point, shape, near):
    edges, to = np.roll(shape, -1, axis=0) - shape, point - shape
    if len(shape) == 2:
        along = np.clip(to[0] @ edges[0] / max(edges[0] @ edges[0], 1e-300), 0, 1)
        return np.linalg.norm(to[0] - along * edges[0]) <= near
    return ((edges[:, 0] * to[:, 1] - edges[:, 1] * to[:, 0]) >= -near * np.linalg.norm(edges, axis=1)).all()

def contact_polygon(a, b, normal, near):
    """Corners of what the two share in the plane of contact, in order, and its area."""
    level = (a.points @ normal).max()
    first = np.linalg.svd(normal[None])[2][1]
    frame = np.array([first, np.cross(normal, first)])
    one = outline(a.points[a.points @ normal > level - near] @ frame.T)
    two = outline(b.points[b.points @ normal < (b.points @ normal).min() + near] @ frame.T)
    shared = [*(p for p in one if inside(p, two, near)), *(p for p in two if inside(p, one, near))]
    for (p, q), (r, s) in itertools.product(*(zip(shape, np.roll(shape, -1, axis=0)) for shape in (one, two))):
        matrix = np.array([q - p, r - s]).T
        if abs(np.linalg.det(matrix)) > 1e-9 * np.linalg.norm(q - p) * np.linalg.norm(s - r):
            t, u = np.linalg.solve(matrix, r - p)
            if -1e-9 <= t <= 1 + 1e-9 and -1e-9 <= u <= 1 + 1e-9:
                shared.append(p + t * (q - p))
    flat, area = np.array(shared).reshape(-1, 2), 0.0
    if len(flat) > 2 and np.linalg.svd(flat - flat.mean(axis=0))[1][-1] > 10 * near:
        hull = ConvexHull(flat)
        flat, area = flat[hull.vertices], hull.volume
    return flat @ frame + level * normal, area

def joint_of(document, a, b):
    groups = {a.entry["group"], b.entry["group"]}
    return next((j for j in document["joints"][1:] if set(j["groups"]) == groups), document["joints"][0])

def touching(solids):
    for i, j in itertools.combinations(sorted(solids), 2):
        a, b, near = solids[i], solids[j], NEAR * min(solids[i].size, solids[j].size)
        apart = np.maximum(a.points.min(axis=0) - b.points.max(axis=0), b.points.min(axis=0) - a.points.max(axis=0))
        if not (a.moves or b.moves) or apart.max() > near:
            continue
        normal, gap = normal_between(a, b)
        if gap <= near:
            yield i, j, normal, *contact_polygon(a, b, normal, near)

def shrunk(document, corners, area):
    """Of a limit on joints shrunk about the middle of their corners, which keep their strength."""
    middle, share = corners.mean(axis=0), float(np.clip(document.get("shrink", 1.0), 0, 1))
    return middle + share * (corners - middle), area

def check_stands(document, solids, gravity):
    left = {i: s.load(gravity, document["factor"]) for i, s in solids.items()}
    scale = max(np.abs(load[:3]).max() for i, load in left.items() if solids[i].moves) or 1.0
    pairs, worst = {}, 0.0
    for contact in document["contacts"]:
        force, point = np.array(contact["force"], float), np.array(contact["point"], float)
        for i, sign in ((contact["a"], -1), (contact["b"], 1)):
            if i >= 0:
                left[i] = left[i] + sign * np.concatenate([force, np.cross(point - solids[i].centroid, force)])
        if contact["held"] and contact["a"] < 0:
            worst = max(worst, np.linalg.norm(np.cross(force, contact["normal"])) * bool(contact.get("guided")))
            continue
        a, b = solids[contact["a"]], solids[contact["b"]]
        normal, near = np.array(contact["normal"], float), NEAR * min(a.size, b.size)
        heights = [(a.points - point) @ normal, (point - b.points) @ normal]
        if abs(np.linalg.norm(normal) - 1) > 1e-9 or max(h.max() for h in heights) > near:
            return f"the normal between {contact['a']} and {contact['b']} parts them not", 0.0
        key = contact["a"], contact["b"]
        if key not in pairs:
            pairs[key] = [joint_of(document, a, b), *shrunk(document, *contact_polygon(a, b, normal, near)), 0.0, 0.0]
        joint, corners, f_n = *pairs[key][:2], force @ normal
        if len(corners) == 0 or not covers(corners, point, near):
            return f"blocks {key} do not touch at {point.tolist()}", 0.0
        pairs[key][3] += max(0.0, np.linalg.norm(force - f_n * normal) - joint["friction"] * f_n)
        pairs[key][4] += max(0.0, -f_n)
    for joint, _, area, shear, pull in pairs.values():
        worst = max(worst, shear - joint["cohesion"] * area, pull - joint["tension"] * area)
    for i in (i for i, solid in solids.items() if solid.moves):
        worst = max(worst, np.abs(left[i][:3]).max(), np.abs(left[i][3:]).max() / solids[i].size)
    worst /= scale
    return "" if worst <= ALLOWED else f"unbalance or violation {worst:.3g} of the largest load", worst

def covers(corners, point, near):
    axes = np.linalg.svd(corners - corners[0])[2][:2].T
    return inside((point - corners[0]) @ axes, outline((corners - corners[0]) @ axes), 10 * near)

def check_falls(document, solids, gravity):
    fastest, taken = max(np.abs(s.velocity(p)).max() for s in solids.values() for p in s.points), 0.0
    power = sum(s.load(gravity, document["factor"]) @ np.array(s.entry["velocity"]) for s in solids.values() if s.moves)
    if any(np.abs(s.entry["velocity"]).max() > 0 for s in solids.values() if not s.moves):
        return "a fixed block moves", 0.0
    for contact in (c for c in document["contacts"] if c["held"]):
        v = solids[contact["b"]].velocity(np.array(contact["point"]))
        if np.abs(v @ np.array(contact["normal"]) if contact.get("guided") else v).max() > SHORT * fastest:
            return "a held point moves", 0.0
    for i, j, normal, corners, area in touching(solids):
        joint, (corners, area), rates = joint_of(document, solids[i], solids[j]), shrunk(document, corners, area), []
        for corner in [corners.mean(axis=0), *corners]:
            v = solids[j].velocity(corner) - solids[i].velocity(corner)
            v_n, v_t = v @ normal, np.linalg.norm(v - (v @ normal) * normal)
            apart = v_n - joint["friction"] * v_t
            if not apart >= -SHORT * fastest:
                return f"blocks {i} and {j} close by {-apart / fastest:.3g} of the largest speed", 0.0
            rates.append(joint["cohesion"] * v_t + joint["tension"] * max(apart, 0.0))
        taken += area * fan(corners, rates) if area > 0 else 0.0
    proved = power > taken * (1 + 1e-9) and power > 0
    return "" if proved else "the loads work less than the contacts can take", (power - taken) / max(power, 1e-300)

def fan(corners, rates):
    """Mean of a convex rate over a polygon, from above: linear on triangles from its middle."""
    arms, rates = corners - corners.mean(axis=0), np.array(rates)
    areas = 0.5 * np.linalg.norm(np.cross(arms, np.roll(arms, -1, axis=0)), axis=1)
    return (areas * (rates[0] + rates[1:] + np.roll(rates[1:], -1)) / 3).sum() / areas.sum()

def check(path, scene=None):
    document = json.loads(path.read_text(encoding="utf-8"), parse_constant=int)
    solids = {entry["index"]: Solid(entry) for entry in document["blocks"]}
    wrong = check_limit_scene.differences(document, scene, solids)[:3] if scene else []
    for entry in document["joints"]:
        c, apex = entry["cohesion"], entry["friction"] * entry["tension"]
        entry["cohesion"] = c + apex if document["vary"]["what"] == "run" else max(c, apex)
    checked = {"stands": check_stands, "falls": check_falls}[document["certificate"]]
    proof, size = checked(document, solids, np.array(document["gravity"], float))
    return document["value"], "; ".join(filter(None, [*wrong, proof])), size

def judge(folder, scene=None):
    values, bad, scene = {}, 0, scene and json.loads(pathlib.Path(scene).read_text(encoding="utf-8"))
    for path in sorted(p for end in ("stands", "falls", "mechanism") for p in pathlib.Path(folder).glob(f"*{end}.json")):
        try:
            value, wrong, size = check(path, scene)
        except (NotImplementedError, ValueError, KeyError, TypeError, IndexError, QhullError) as error:
            value, wrong, size = 0.0, f"it can't be read: {error!r}", 0.0
        bad += bool(wrong)
        print(f"{path.stem} at {value:.9g}: " + (f"NOT proved: {wrong}" if wrong else f"proved ({size:.2g})"))
        values[path.stem] = value
    if {"stands", "falls"} <= set(values):
        low, high = sorted([abs(values["falls"]), abs(values["stands"])])
        print(f"digits: {-np.log10(max(1 - low / high, 1e-16)):.1f}")
    values or print(f"{folder}: no certificates (*stands.json, *falls.json, mechanism.json) in this folder")
    return 1 if bad or not values else 0
if __name__ == "__main__": sys.exit(judge(*sys.argv[1:3]))
