#!/usr/bin/env python3
"""Checks a certificate of `quoin limit --out` by itself: numpy and scipy alone, contacts worked out anew from vertices.

    tools/check_limit.py DIR        # DIR/stands.json and DIR/falls.json; exit code 0: what is there is proved
stands: the forces balance weight and applied load of every block that moves, act where two blocks touch (or hold a
held point), and stay within |f_t| <= mu f_n + c A, f_n >= -t A, A the contact's area.
falls: along the velocities no contact closes (v_n >= mu |v_t|), no held point moves, and the loads do more work than
cohesion and tension can take. Then no forces within these limits balance the loads [Drucker, Prager & Greenberg 1952].
"""
import itertools
import json
import pathlib
import sys
import numpy as np
from scipy.spatial import ConvexHull, QhullError

NEAR = 2e-6          # of the smaller block: what touches
ALLOWED = 1e-7       # of the largest load: unbalance, forces outside their limits
SHORT = 1e-7         # of the largest speed: by how much a contact may close

class Solid:
    def __init__(self, entry):
        self.points = np.array(entry["vertices"], float)
        self.moves, self.entry = entry["moves"], entry
        self.size = np.linalg.norm(np.ptp(self.points, axis=0))
        middle = self.points.mean(axis=0)
        hull = ConvexHull(self.points - middle)
        corners = self.points[hull.simplices] - middle
        parts = np.abs(np.linalg.det(corners)) / 6
        self.volume = parts.sum()
        self.centroid = middle + (parts[:, None] * corners.sum(axis=1) / 4).sum(axis=0) / self.volume
        self.normals = np.unique(hull.equations[:, :3].round(9), axis=0)
        self.normals /= np.linalg.norm(self.normals, axis=1)[:, None]
        edges = [self.points[j] - self.points[i] for s in hull.simplices for i, j in itertools.combinations(s, 2)]
        edges = np.array(edges) / np.linalg.norm(edges, axis=1)[:, None]
        edges *= np.sign(edges[np.arange(len(edges)), np.abs(edges).argmax(axis=1)])[:, None]
        self.edges = np.unique(edges.round(9), axis=0)
    def load(self, gravity, factor):
        applied = np.array(self.entry["applied"], float) + factor * np.array(self.entry["live"], float)
        applied[:3] += self.entry["density"] * self.volume * gravity
        return applied
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
    best = gaps.max()
    return normals[np.argmax(gaps > best - 1e-9 * min(a.size, b.size))], best

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
        t = np.clip(to[0] @ edges[0] / max(edges[0] @ edges[0], 1e-300), 0, 1)
        return np.linalg.norm(to[0] - t * edges[0]) <= near
    return ((edges[:, 0] * to[:, 1] - edges[:, 1] * to[:, 0]) >= -near * np.linalg.norm(edges, axis=1)).all()

def contact_polygon(a, b, normal, near):
    """Corners of what the two share in the plane of contact, in order, and its area."""
    level = (a.points @ normal).max()
    first = np.linalg.svd(normal[None])[2][1]
    frame = np.array([first, np.cross(normal, first)])
    one = outline(a.points[a.points @ normal > level - near] @ frame.T)
    two = outline(b.points[b.points @ normal < (b.points @ normal).min() + near] @ frame.T)
    shared = [p for p in one if inside(p, two, near)] + [p for p in two if inside(p, one, near)]
    for p, q in zip(one, np.roll(one, -1, axis=0)):
        for r, s in zip(two, np.roll(two, -1, axis=0)):
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
    joints, groups = document["joints"], {a.entry["group"], b.entry["group"]}
    return next((j for j in joints[1:] if set(j["groups"]) == groups), joints[0])

def touching(solids):
    keys = sorted(solids)
    for i, j in itertools.combinations(keys, 2):
        a, b = solids[i], solids[j]
        near = NEAR * min(a.size, b.size)
        apart = np.maximum(a.points.min(axis=0) - b.points.max(axis=0), b.points.min(axis=0) - a.points.max(axis=0))
        if not (a.moves or b.moves) or apart.max() > near:
            continue
        normal, gap = normal_between(a, b)
        if gap <= near:
            yield i, j, normal, *contact_polygon(a, b, normal, near)

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
            continue
        a, b = solids[contact["a"]], solids[contact["b"]]
        normal, near = np.array(contact["normal"], float), NEAR * min(a.size, b.size)
        heights = [(a.points - point) @ normal, (point - b.points) @ normal]
        if abs(np.linalg.norm(normal) - 1) > 1e-9 or max(h.max() for h in heights) > near:
            return f"the normal between {contact['a']} and {contact['b']} parts them not", 0.0
        key = contact["a"], contact["b"]
        if key not in pairs:
            pairs[key] = [joint_of(document, a, b), *contact_polygon(a, b, normal, near), 0.0, 0.0]
        joint, corners = pairs[key][:2]
        if len(corners) == 0 or not covers(corners, point, near):
            return f"blocks {key} do not touch at {point.tolist()}", 0.0
        f_n = force @ normal
        pairs[key][3] += max(0.0, np.linalg.norm(force - f_n * normal) - joint["friction"] * f_n)
        pairs[key][4] += max(0.0, -f_n)
    for joint, _, area, shear, pull in pairs.values():
        worst = max(worst, shear - joint["cohesion"] * area, pull - joint["tension"] * area)
    for i, solid in solids.items():
        if solid.moves:
            worst = max(worst, np.abs(left[i][:3]).max(), np.abs(left[i][3:]).max() / solid.size)
    return ("" if worst <= ALLOWED * scale else f"unbalance or violation {worst / scale:.3g} of the largest load"), \
        worst / scale

def covers(corners, point, near):
    axes = np.linalg.svd(corners - corners[0])[2][:2]
    return inside((point - corners[0]) @ axes.T, outline((corners - corners[0]) @ axes.T), 10 * near)

def check_falls(document, solids, gravity):
    fastest = max(np.abs(s.velocity(p)).max() for s in solids.values() for p in s.points)
    power = sum(s.load(gravity, document["factor"]) @ np.array(s.entry["velocity"]) for s in solids.values() if s.moves)
    taken = 0.0
    if any(np.abs(s.entry["velocity"]).max() > 0 for s in solids.values() if not s.moves):
        return "a fixed block moves", 0.0
    for contact in document["contacts"]:
        if contact["held"] and np.abs(solids[contact["b"]].velocity(np.array(contact["point"]))).max() > SHORT * fastest:
            return "a held point moves", 0.0
    for i, j, normal, corners, area in touching(solids):
        joint = joint_of(document, solids[i], solids[j])
        rates = []
        for corner in [corners.mean(axis=0), *corners]:
            v = solids[j].velocity(corner) - solids[i].velocity(corner)
            v_n, v_t = v @ normal, np.linalg.norm(v - (v @ normal) * normal)
            apart = v_n - joint["friction"] * v_t
            if not apart >= -SHORT * fastest:
                return f"blocks {i} and {j} close by {-apart / fastest:.3g} of the largest speed", 0.0
            rates.append(dissipation(joint, v_n, v_t, max(apart, 0.0)))
        taken += fan(corners, rates) if area > 0 else 0.0
    return ("" if power > taken * (1 + 1e-9) and power > 0 else "the loads work less than the contacts can take"), \
        (power - taken) / max(power, 1e-300)

def dissipation(joint, v_n, v_t, apart):
    cut_off = joint["friction"] == 0 or joint["friction"] * joint["tension"] < joint["cohesion"]
    return joint["cohesion"] * v_t + joint["tension"] * apart if cut_off else joint["cohesion"] * v_n / joint["friction"]

def fan(corners, rates):
    """Integral of a convex rate over a polygon, from above: linear on triangles from its middle."""
    arms, rates = corners - corners.mean(axis=0), np.array(rates)
    areas = 0.5 * np.linalg.norm(np.cross(arms, np.roll(arms, -1, axis=0)), axis=1)
    return (areas * (rates[0] + rates[1:] + np.roll(rates[1:], -1)) / 3).sum()

def check(path):
    document = json.loads(path.read_text(encoding="utf-8"), parse_constant=int)
    solids = {entry["index"]: Solid(entry) for entry in document["blocks"]}
    judge = {"stands": check_stands, "falls": check_falls}[document["certificate"]]
    return document["certificate"], document["value"], *judge(document, solids, np.array(document["gravity"], float))

def judge(folder):
    values, bad = {}, 0
    for path in sorted(pathlib.Path(folder).glob("[sf]*s.json")):
        try:
            kind, value, wrong, size = check(path)
        except (ValueError, KeyError, TypeError, IndexError, QhullError) as error:
            kind, value, wrong, size = path.stem, 0.0, f"it can't be read: {error!r}", 0.0
        bad += bool(wrong)
        print(f"{kind} at {value:.9g}: " + (f"NOT proved: {wrong}" if wrong else f"proved ({size:.2g})"))
        values[kind] = value
    if len(values) == 2:
        between = abs(values["falls"] - values["stands"]) / max(map(abs, values.values()))
        print(f"digits: {-np.log10(max(between, 1e-16)):.1f}")
    return 1 if bad or not values else 0

if __name__ == "__main__":
    sys.exit(judge(sys.argv[1]))
