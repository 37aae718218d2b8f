#!/usr/bin/env python3
"""Checks certificates of `quoin limit` and `quoin run` by itself: numpy and scipy alone, contacts anew from vertices.

    tools/check_limit.py DIR [SCENE.json]    # exit code 0: all are proved, and of this scene (check_limit_scene.py)
stands: forces balance weight and load of every block that moves, act where two blocks touch (or hold a held point),
and stay within |f_t| <= mu f_n + C A, f_n >= -t A; A: area of the point; C: max(c, mu t), of joints that are whole c.
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

# Of the smaller block: what touches; unbalance and forces outside their limits, by the largest load; closing, by speed.
NEAR, ALLOWED, SHORT = 2e-6, 1e-7, 1e-7

class Part:  # the hull of its points
    def __init__(self, points):
        self.points, self.middle = points, (middle := points.mean(axis=0))
        hull = ConvexHull(points - middle)
        self.planes, corners = hull.equations, points[hull.simplices] - middle
        parts = np.abs(np.linalg.det(corners)) / 6
        self.volume = parts.sum()
        self.centroid = middle + (parts[:, None] * corners.sum(axis=1) / 4).sum(axis=0) / self.volume
        normals = np.unique(hull.equations[:, :3].round(9), axis=0)
        self.normals = normals / np.linalg.norm(normals, axis=1)[:, None]
        self.ends = np.unique(np.sort(hull.simplices[:, [[0, 1], [0, 2], [1, 2]]].reshape(-1, 2), axis=1), axis=0)
        edges = points[self.ends[:, 1]] - points[self.ends[:, 0]]
        self.edges = np.unique((edges / np.linalg.norm(edges, axis=1)[:, None]).round(9), axis=0)
    def is_near(self, point, near):
        return (self.planes[:, :3] @ (point - self.middle) + self.planes[:, 3]).max() <= near

class Solid:
    def __init__(self, entry):
        self.points, self.moves, self.entry = np.array(entry["vertices"], float), entry["moves"], entry
        ends = np.cumsum(entry.get("parts") or [len(self.points)])  # vertices of each convex part
        self.parts = [Part(points) for points in np.split(self.points, ends)[:-1]]
        self.size, self.volume = np.linalg.norm(np.ptp(self.points, axis=0)), sum(p.volume for p in self.parts)
        self.centroid = sum(p.volume * p.centroid for p in self.parts) / self.volume
    def load(self, document):
        weight = self.entry["density"] * self.volume * np.r_[np.array(document["gravity"], float), 0, 0, 0]
        return weight + np.array(self.entry["applied"], float) + document["factor"] * np.array(self.entry["live"], float)
    def velocity(self, point):
        return (v := np.array(self.entry["velocity"], float))[:3] + np.cross(v[3:], point - self.centroid)

def normals_between(a, b, near, known):
    """Unit normals from a to b of the widest gap (separating axes; `known` ones, too), and that gap."""
    crosses = np.cross(a.edges[:, None], b.edges[None]).reshape(-1, 3)
    crosses = crosses[np.linalg.norm(crosses, axis=1) > 1e-6]
    crosses /= np.linalg.norm(crosses, axis=1)[:, None]
    normals = np.concatenate([np.reshape(known, (-1, 3)), a.normals, -b.normals, crosses, -crosses])
    gaps = (normals @ b.points.T).min(axis=1) - (normals @ a.points.T).max(axis=1)
    widest = gaps[len(known):].max()
    return normals[(gaps > widest - 1e-3 * near) & (np.abs(np.linalg.norm(normals, axis=1) - 1) < 1e-9)], widest

def contact_polygon(a, b, normal, near):
    """Corners of what the two share in the plane of contact, in order, and its area."""
    level, frame = (a.points @ normal).max(), np.linalg.svd(normal[None])[2][1:]
    flush = a.points @ normal > level - near, b.points @ normal < (b.points @ normal).min() + near
    shared = [p @ frame.T for p in a.points[flush[0]] if b.is_near(p, 2 * near)]
    shared += [p @ frame.T for p in b.points[flush[1]] if a.is_near(p, 2 * near)]
    one, two = (part.points[part.ends[f[part.ends].all(axis=1)]] @ frame.T for part, f in zip((a, b), flush))
    for (p, q), (r, s) in itertools.product(one, two):
        matrix = np.array([q - p, r - s]).T
        crossed = abs(np.linalg.det(matrix)) > 1e-9 * np.linalg.norm(q - p) * np.linalg.norm(s - r)
        t, u = np.linalg.solve(matrix, r - p) if crossed else (-1, -1)
        if -1e-9 <= t <= 1 + 1e-9 and -1e-9 <= u <= 1 + 1e-9:
            shared.append(p + t * (q - p))
    flat, area = np.array(shared).reshape(-1, 2), 0.0
    if min(*map(np.sum, flush)) > 2 < len(flat) and np.linalg.svd(flat - flat.mean(axis=0))[1][-1] > 10 * near:
        hull = ConvexHull(flat)
        flat, area = flat[hull.vertices], hull.volume
    return flat @ frame + level * normal, area

def strength_points(joint, corners, area):
    """Where a joint's strength acts, and on what area: corners, and a point of each triangle (centroid, corner, next)
    if it has any, so that area, its first moments and twist are exact. Of a whole joint with tension: at its core."""
    if not area > 0 or not max(joint["cohesion"], joint["tension"]) > 0:
        return corners, np.full(len(corners), area / max(len(corners), 1))
    norm, q = lambda v: np.linalg.norm(v, axis=1), np.roll(corners, -1, axis=0)
    parts = norm(np.cross(corners - corners[0], q - corners[0]))
    p = corners - (parts[:, None] * (corners[0] + corners + q)).sum(axis=0) / parts.sum() / 3
    parts, sides = norm(np.cross(p, q := np.roll(p, -1, axis=0))) / 2, (q - p) / norm(q - p)[:, None]
    height = norm(np.cross(p, sides))
    if joint.get("whole") and joint["tension"] > 0:
        second = sum(np.einsum("k,ki,kj->ij", parts / parts.sum() / 12, v, v) for v in (p, q, p + q))
        return corners - p - (p - (p * sides).sum(axis=1)[:, None] * sides) @ second / height[:, None] ** 2, parts
    ends = np.array([(p * sides).sum(axis=1), (q * sides).sum(axis=1)])
    integrals = (ends * np.hypot(height, ends) + height ** 2 * np.arcsinh(ends / height)) / 2  # of the distance
    exact, least = height / 3 @ (integrals[1] - integrals[0]), parts @ norm(inner := np.sqrt(.4) * (p + q) / 2)
    share = np.clip((exact - least) / (parts @ (norm(p) + norm(q)) / 2 - least), 0, 1)
    return np.r_[corners, corners - p + inner], np.r_[share / 2 * (parts + np.roll(parts, 1)), (1 - share) * parts]

def joint_of(document, a, b):
    groups, pair = {a.entry["group"], b.entry["group"]}, sorted([a.entry["index"], b.entry["index"]])
    own = [j for j in document["joints"] if j.get("blocks") == pair]
    return (own or [j for j in document["joints"] if set(j["groups"] or []) == groups] or document["joints"])[0]

def touching(document, solids):
    """Parts that touch: blocks, normals, polygon, area. Between edges the certificate's, too, if it parts as well."""
    of_pair = itertools.groupby(document["contacts"], lambda contact: (contact["a"], contact["b"]))
    known = {pair: [contact["normal"] for contact in contacts] for pair, contacts in of_pair}
    parts = [(i, part) for i, solid in sorted(solids.items()) for part in solid.parts]
    low, high = (np.array([f(part.points, axis=0) for _, part in parts]) for f in (np.min, np.max))
    for k, (i, a) in enumerate(parts):
        gaps = np.maximum(low[k] - high, low - high[k]).max(axis=1)
        for j, b in (parts[m] for m in np.flatnonzero(gaps <= NEAR * solids[i].size) if m > k):
            near = NEAR * min(solids[i].size, solids[j].size)
            normals, gap = normals_between(a, b, near, known.get((i, j), []))
            if i != j and (solids[i].moves or solids[j].moves) and gap <= near:
                yield i, j, normals, *contact_polygon(a, b, normals[0], near)

def check_stands(document, solids):
    left = {i: s.load(document) for i, s in solids.items()}
    scale = max(np.abs(load[:3]).max() for i, load in left.items() if solids[i].moves) or 1.0
    pairs, at_point, worst = {}, {}, 0.0
    for contact in document["contacts"]:
        force, point = np.array(contact["force"], float), np.array(contact["point"], float)
        for i, sign in ((contact["a"], -1), (contact["b"], 1)):
            if i >= 0:
                left[i] = left[i] + sign * np.concatenate([force, np.cross(point - solids[i].centroid, force)])
        if contact["held"] and contact["a"] < 0:
            worst = max(worst, np.linalg.norm(np.cross(force, contact["normal"])) * bool(contact.get("guided")))
            continue
        a, b, normal = solids[contact["a"]], solids[contact["b"]], np.array(contact["normal"], float)
        near, f_n, joint = NEAR * min(a.size, b.size), force @ normal, joint_of(document, a, b)
        key, borne = (contact["a"], contact["b"]), 0.0
        for pair in itertools.product(a.parts, b.parts):
            if max(*(pair[0].points - point) @ normal, *(point - pair[1].points) @ normal) > near:
                continue
            if pair not in pairs:
                pairs[pair] = strength_points(joint, *contact_polygon(*pair, normal, near))
            place = shrunk(document, pairs[pair][0], point, -1)
            if all(part.is_near(place, near) for part in pair):
                here = np.linalg.norm(pairs[pair][0] - place, axis=1) <= 4 * near
                key, borne = (*key, pair, here.tobytes()), borne + pairs[pair][1][here].sum()
        if len(key) == 2 or abs(np.linalg.norm(normal) - 1) > 1e-9:
            return f"blocks {contact['a']} and {contact['b']} do not touch at {point.tolist()} along that normal", 0.0
        beyond = at_point.setdefault(key, np.array([-joint["cohesion"], -joint["tension"]]) * borne)
        rubs = joint["friction"] * (f_n if joint["cohesion"] > 0 else max(f_n, 0.0))
        beyond += max(0.0, np.linalg.norm(force - f_n * normal) - rubs), max(0.0, -f_n)
    sizes = {i: np.repeat([1.0, solid.size], 3) for i, solid in solids.items() if solid.moves}
    worst = np.max([worst, *map(np.max, at_point.values()), *(np.abs(left[i] / sizes[i]).max() for i in sizes)]) / scale
    return "" if worst <= ALLOWED else f"unbalance or violation {worst:.3g} of the largest load", worst

def shrunk(document, joint_points, points, power):
    """Of a limit on joints that shrink about the middle of their points and keep their strength."""
    middle, share = joint_points.sum(axis=0) / max(len(joint_points), 1), np.clip(document.get("shrink", 1.0), 1e-9, 1)
    return middle + share ** power * (points - middle)

def check_falls(document, solids):
    fastest, taken = max(np.abs(s.velocity(s.points)).max() for s in solids.values()), 0.0
    power = sum(s.load(document) @ np.array(s.entry["velocity"]) for s in solids.values() if s.moves)
    if any(np.any(s.entry["velocity"]) for s in solids.values() if not s.moves):
        return "a fixed block moves", 0.0
    for contact in (c for c in document["contacts"] if c["held"]):
        v = solids[contact["b"]].velocity(np.array(contact["point"]))
        if np.abs(v @ np.array(contact["normal"]) if contact.get("guided") else v).max() > SHORT * fastest:
            return "a held point moves", 0.0
    for i, j, normals, corners, area in touching(document, solids):
        points, areas = strength_points(joint := joint_of(document, solids[i], solids[j]), corners, area)
        v = np.subtract(*(solids[k].velocity(shrunk(document, points, points, 1)) for k in (j, i)))
        v_t = [np.linalg.norm(v - np.outer(v @ n, n), axis=1) for n in normals[:1 if area > 0 else None]]
        apart = [v @ n - joint["friction"] * slip for n, slip in zip(normals, v_t)]
        best = max(range(len(v_t)), key=lambda k: apart[k].min(initial=0))  # any of an edge alone
        if not (closing := apart[best].min(initial=0)) >= -SHORT * fastest:
            return f"blocks {i} and {j} close by {-closing / fastest:.3g} of the largest speed", 0.0
        taken += areas @ (joint["cohesion"] * v_t[best] + joint["tension"] * np.maximum(apart[best], 0.0))
    wrong = "" if power > taken * (1 + 1e-9) and power > 0 else "the loads work less than the contacts can take"
    return wrong, (power - taken) / max(power, 1e-300)

def check(path, scene=None):
    document = json.loads(path.read_text(encoding="utf-8"), parse_constant=int)
    solids = {entry["index"]: Solid(entry) for entry in document["blocks"]}
    wrong = check_limit_scene.differences(document, scene, solids)[:3] if scene else []
    for entry in document["joints"]:
        entry["whole"] = document.get("joints_are") == "whole" and document["certificate"] == "stands"
        entry["cohesion"] = max(entry["cohesion"], 0 if entry["whole"] else entry["friction"] * entry["tension"])
    proof, size = {"stands": check_stands, "falls": check_falls}[document["certificate"]](document, solids)
    return document["value"], "; ".join(filter(None, [*wrong, proof])), size

def judge(folder, scene=None):
    values, bad, scene = {}, 0, scene and check_limit_scene.read(scene)
    for path in sorted(p for end in ("stands", "falls", "mechanism") for p in pathlib.Path(folder).glob(f"*{end}.json")):
        try:
            value, wrong, size = check(path, scene)
        except (NotImplementedError, ValueError, KeyError, TypeError, IndexError, QhullError) as error:
            value, wrong, size = 0.0, f"it can't be read: {error!r}", 0.0
        print(f"{path.stem} at {value:.9g}: " + (f"NOT proved: {wrong}" if wrong else f"proved ({size:.2g})"))
        values[path.stem], bad = value, bad + bool(wrong)
    if {"stands", "falls"} <= set(values):
        low, high = sorted([abs(values["falls"]), abs(values["stands"])])
        print(f"digits: {-np.log10(max(1 - low / max(high, 1e-300), 1e-16)):.1f}")
    values or print(f"{folder}: no certificates (*stands.json, *falls.json, mechanism.json) in this folder")
    return int(bad or not values)
if __name__ == "__main__": sys.exit(judge(*sys.argv[1:3]))
