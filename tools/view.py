#!/usr/bin/env python3
"""One page, to be opened by a browser without a network, of a run, a scene or pairs. `quoin view` calls it.

    quoin view RUN|SCENE.json [--out FILE.html]
    quoin view --pairs FILE.jsonl [--out FILE.html]

RUN is a folder that `quoin run --out` left. SCENE.json is shown before it is run, with what `quoin check` tells
of it. FILE.jsonl holds pairs of solids as `quoin contact` takes them: each with its contact polygon, normal,
nearest features and certificate. Needs numpy alone.

The motion of each block is stored as displacement and rotation vector (and strain where it can be seen), in
16 bits of the largest of the run. Contacts are kept for as many times as MOST_CONTACTS allows.
"""
import argparse
import base64
import itertools
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import zlib

import numpy as np

if __package__:  # of the Python module
    from .run_output import FIXED, Blocks, frame_labels, history, pieces, reading, run_program, series, shown_times
else:
    from run_output import FIXED, Blocks, frame_labels, history, pieces, reading, run_program, series, shown_times

HERE = pathlib.Path(__file__).parent
COMMAND = os.environ.get("QUOIN", "quoin")
MOST_CONTACTS = 400_000  # contact points of all times together; those of the last time are kept in any case
MOST_HISTORY = 2000  # lines
MOST_MARKS = 5000  # loads, points and motions of a scene
MOST_CORNERS = 48  # of a solid of --pairs that is drawn exactly
CODES = {"int16": "i2", "uint16": "u2", "float32": "f4", "uint32": "u4", "uint8": "u1"}


def short(values, digits=6):
    return [float(f"{x:.{digits}g}") for x in np.asarray(values, dtype=float).ravel()]


def write_page(head, parts, path):
    """The template with the head as JSON and the arrays of `parts` one after the other, deflated, in base64."""
    at, blob, sections = 0, [], {}
    for name, values in parts.items():
        raw = values.tobytes()
        sections[name] = {"type": CODES[values.dtype.name], "at": at, "count": int(values.size)}
        blob.append(raw + b"\0" * (-len(raw) % 8))
        at += len(blob[-1])
    data = base64.b64encode(zlib.compress(b"".join(blob), 1))
    text = json.dumps({**head, "sections": sections}, separators=(",", ":"), ensure_ascii=False)
    template = (HERE / "viewer" / "dist" / "page.html").read_bytes()
    before, middle, after = re.split(b"@HEAD@|@DATA@", template)
    with open(path, "wb") as file:
        file.writelines((before, text.replace("<", "\\u003c").encode(), middle, data, after))


def shapes_of(blocks, points):
    """Shapes that differ, by which each block has one; the centre of each block's corners."""
    shapes, shape_of, origins = [], np.empty(len(blocks.kind), dtype="<u4"), np.empty((len(blocks.kind), 3))
    for rows, faces in blocks.topologies:
        places = points[blocks.first[rows][:, None] + np.arange(1 + max(v for face in faces for v in face))]
        origins[rows] = places.mean(axis=1)
        arms = places - origins[rows][:, None]
        size = np.abs(arms).max()
        keys = np.ascontiguousarray(np.round(arms.reshape(len(rows), -1) / size * 1e7).astype("<i8"))
        _, one, which = np.unique(keys.view(f"V{keys.itemsize * keys.shape[1]}").ravel(), return_index=True,
                                  return_inverse=True)
        shape_of[rows] = len(shapes) + which
        shapes += [{"p": short(arms[i], 7), "f": faces} for i in one]
    return shapes, shape_of, origins


def spanning_corners(blocks, points):
    """Four corners of each block that span it, and the inverse of the arms from the first to the others."""
    corners, inverse = np.empty((len(blocks.kind), 4), dtype=int), np.empty((len(blocks.kind), 3, 3))
    for rows, faces in blocks.topologies:
        index = blocks.first[rows][:, None] + np.arange(1 + max(v for face in faces for v in face))
        arms = points[index] - points[index[:, :1]]
        every = np.arange(len(rows))
        one = np.argmax((arms**2).sum(axis=2), axis=1)
        a = arms[every, one][:, None]
        two = np.argmax((np.cross(a, arms)**2).sum(axis=2), axis=1)
        b = arms[every, two][:, None]
        three = np.argmax(np.abs((np.cross(a, b) * arms).sum(axis=2)), axis=1)
        chosen = np.stack([np.zeros_like(one), one, two, three], axis=1)
        corners[rows] = np.take_along_axis(index, chosen, axis=1)
        inverse[rows] = np.linalg.inv(np.stack([arms[every, k] for k in (one, two, three)], axis=1))
    return corners, inverse


def cross(a, b):
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def rotations(maps):
    """The rotation R of each map A = R (I + E), 3 × 3 × blocks, by Newton's iteration for the polar decomposition
    [Higham 1986]."""
    turned = maps
    for _ in range(20):
        cofactors = np.stack([cross(turned[1], turned[2]), cross(turned[2], turned[0]), cross(turned[0], turned[1])])
        following = (turned + cofactors / (turned[0] * cofactors[0]).sum(axis=0)) / 2
        change = np.abs(following - turned).max()
        turned = following
        if change < 1e-9:  # it converges quadratically
            break
    return turned


def rotation_vectors(R):
    """Of rotations, 3 × blocks, rad, by the largest component of the quaternion [Shepperd 1978]."""
    sums = np.stack([R[0, 0] + R[1, 1] + R[2, 2], R[0, 0] - R[1, 1] - R[2, 2], R[1, 1] - R[0, 0] - R[2, 2],
                     R[2, 2] - R[0, 0] - R[1, 1]])
    x, y, z = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    xy, yz, zx = R[0, 1] + R[1, 0], R[1, 2] + R[2, 1], R[0, 2] + R[2, 0]
    one, best = 1 + sums, np.argmax(sums, axis=0)
    q = np.stack([np.choose(best, row) for row in ((one[0], x, y, z), (x, one[1], xy, zx), (y, xy, one[2], yz),
                                                   (z, zx, yz, one[3]))])  # w x y z, times some number
    q *= np.where(q[0] < 0, -1, 1)
    sine = np.sqrt((q[1:]**2).sum(axis=0))
    return q[1:] * (2 * np.arctan2(sine, q[0]) / np.maximum(sine, 1e-300))


def motion_of(moved, maps):
    """Blocks × 12, of one time: displacement of the origin, rotation vector, strain (xx yy zz xy yz xz)."""
    R = rotations(maps)
    strain = [(R[:, i] * maps[:, j]).sum(axis=0) - (i == j) for i, j in zip((0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2))]
    return np.concatenate([moved, rotation_vectors(R), np.stack(strain)]).T.astype("<f4")


def packed_motion(motion, size):
    """(head, array) of times × blocks × 12, in 16 bits; without strain, where it can't be seen."""
    limits = [max(float(np.abs(motion[..., part]).max()), 1e-30) / 32767 for part in (slice(3), slice(3, 6), slice(6, 12))]
    per = 12 if limits[2] * size > limits[0] / 32767 and limits[2] > 1e-10 else 6  # single precision leaves 1e-7
    values = motion[..., :per] / np.repeat(limits, [3, 3, 6])[:per].astype("<f4")
    return {"per": per, "u": limits[0], "r": limits[1], "e": limits[2]}, np.rint(values).astype("<i2")


def by_block(found, name, order):
    return np.concatenate([piece[name] for piece in found])[order]


def read_frames(listed, first, points, origins):
    """Of all times: motion, speed, compression, kind; box of what moves."""
    corners, inverse = spanning_corners(first, points)
    start = np.ascontiguousarray(points[corners.T].transpose(0, 2, 1))  # corner × axis × block
    arms, inverse = origins.T - start[0], np.ascontiguousarray(inverse.transpose(1, 2, 0))
    motion, speed, compression, kinds = [], [], [], []
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for _, path in listed:
        with reading(path):
            found = pieces(path)
            order = np.argsort(np.concatenate([piece["block"] for piece in found]), kind="stable")
            places = np.ascontiguousarray(np.concatenate([piece["Points"] for piece in found])[corners.T].transpose(0, 2, 1))
            change = places - start
            sides = change[1:] - change[0]
            B = np.stack([[(inverse[i] * sides[:, k]).sum(axis=0) for i in range(3)] for k in range(3)])  # change = B arm
            motion.append(motion_of(change[0] + (B * arms).sum(axis=1), B + np.eye(3)[:, :, None]))
            speed.append(by_block(found, "speed", order))
            compression.append(-by_block(found, "principal_stress", order)[:, 2])
            kinds.append(by_block(found, "kind", order))
            seen = places[:, :, kinds[-1] < FIXED] if (kinds[-1] < FIXED).any() else places
            low, high = np.minimum(low, seen.min(axis=2).min(axis=0)), np.maximum(high, seen.max(axis=2).max(axis=0))
    return [np.array(x) for x in (motion, speed, compression, kinds)], low, high


def chosen_times(counts):
    """Of which times the contacts are kept: evenly spread, the last in any case."""
    if sum(counts) <= MOST_CONTACTS:
        return list(range(len(counts)))
    kept = max(1, min(len(counts), int(MOST_CONTACTS / max(1, max(counts)))))
    return sorted({round(i) for i in np.linspace(len(counts) - 1, 0, kept)})


def contact_parts(listed, offset):
    """(times kept, arrays) of contact points, those of a pair one after the other."""
    def count(path):
        size = path.stat().st_size - 8192
        return max(0, size // 148)  # bytes a point

    times = chosen_times([count(path) for _, path in listed])
    columns = ["Points", "normal", "force_on_b", "gap", "area", "slip", "block_a", "block_b", "state", "failed"]
    parts, first = {name: [] for name in columns}, [0]
    for number in times:
        with reading(listed[number][1]):
            found = pieces(listed[number][1])
            joined = {name: np.concatenate([np.atleast_1d(piece[name]).reshape(
                -1, *([3] if name in columns[:3] else [])) for piece in found]) for name in columns}
        order = np.lexsort((joined["block_b"], joined["block_a"]))
        for name in columns:
            parts[name].append(joined[name][order])
        first.append(first[-1] + len(order))
    joined = {name: np.concatenate(parts[name]) for name in columns}
    floats = {"contact_point": joined["Points"] - offset, "contact_normal": joined["normal"],
              "contact_force": joined["force_on_b"], "contact_gap": joined["gap"], "contact_area": joined["area"],
              "contact_slip": joined["slip"]}
    return times, {**{name: values.astype("<f4") for name, values in floats.items()},
                   "contact_pair": np.stack([joined["block_a"], joined["block_b"]], axis=1).astype("<u4"),
                   "contact_state": (joined["state"] + 4 * (joined["failed"] > 0)).astype("u1"),
                   "contact_first": np.array(first, dtype="<u4")}


def tie_parts(folder, frames, offset):
    """Ends of each tie (m), its force (N) and whether it is broken, of all frames one after the other."""
    if not (folder / "ties.pvd").exists():
        return {}
    ends, force, broken, first = [], [], [], [0]
    for _, path in series(folder, "ties")[:frames]:
        with reading(path):
            for piece in pieces(path):
                ends.append(piece["Points"].reshape(-1, 6) - np.tile(offset, 2))
                force.append(np.atleast_1d(piece["force"]))
                broken.append(np.atleast_1d(piece["broken"]))
        first.append(sum(len(values) for values in force))
    return {"tie_ends": np.concatenate(ends).astype("<f4"), "tie_force": np.concatenate(force).astype("<f4"),
            "tie_broken": np.concatenate(broken).astype("u1"), "tie_first": np.array(first, dtype="<u4")}


def history_of(folder):
    table = history(folder)
    step = max(1, -(-len(table["time"]) // MOST_HISTORY))
    return {name: [x if np.isfinite(x) else None for x in short(values[::step])]  # JSON knows no NaN
            for name, values in table.items() if name != "stage"}


def names_of(path):
    """Names and materials of the blocks of a frame."""
    names, materials = {}, {}
    for piece in pieces(path):
        for block, name, material in zip(piece["block"].tolist(), piece["name"], piece["material_name"]):
            names[block], materials[block] = name, material
    return [names[b] for b in sorted(names)], [materials[b] for b in sorted(materials)]


def flags_of(summary):
    """What a run says of itself: text, and names of blocks."""
    def told(number):
        return "–" if number is None else f"{number:.3g}"  # JSON knows no infinity

    flags = [(f"{f['flag']}: {told(f['value'])}, limit {told(f['limit'])}, from t = {told(f['first_time'])} s on", f["blocks"])
             for f in summary["flags"]]
    return flags + [(failure, []) for failure in summary["failures"]]


def run_page(folder, out, more=None):
    folder = pathlib.Path(folder)
    is_scene = (more or {}).get("kind") == "scene"
    listed = series(folder, "blocks")[:1 if is_scene else None]
    first = Blocks(listed[0][1])
    shapes, shape_of, origins = shapes_of(first, first.points)
    (motion, speed, compression, kinds), low, high = read_frames(listed, first, first.points, origins)
    offset = (low + high) / 2
    about, motion = packed_motion(motion, float(np.linalg.norm(high - low)))
    parts = {"motion": motion, "origin": (origins - offset).astype("<f4"), "shape": shape_of,
             "kind": kinds.astype("u1") if (kinds != kinds[0]).any() else kinds[0].astype("u1")}
    scalars = {}
    for name, unit, values in (("speed", "m/s", speed), ("compression", "Pa", compression)):
        least, most = float(values.min()), float(values.max())
        if most > least:
            scalars[name] = {"low": least, "high": most, "unit": unit}
            parts[name] = np.round((values - least) / (most - least) * 65535).astype("<u2")
    names, materials = names_of(listed[0][1])
    contact_times, contacts = contact_parts(series(folder, "contacts")[-1 if is_scene else 0:], offset)
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    kinds_of_material = sorted(set(materials))
    parts["group"] = np.array([kinds_of_material.index(m) for m in materials], dtype="<u2")
    head = {"title": summary["title"] or folder.name, "kind": "run", "blocks": len(names), "names": names,
            "groups": kinds_of_material, "shapes": shapes, "motion": about, "times": shown_times(folder)[:len(listed)],
            "labels": frame_labels(folder)[:len(listed)], "low": short(low - offset), "high": short(high - offset),
            "offset": short(offset, 12), "scalars": scalars, "contactTimes": contact_times,
            "history": history_of(folder), "notes": flags_of(summary), "ties": [tie["name"] for tie in summary.get("ties", [])],
            **(more or {})}
    number = {name: i for i, name in reversed(list(enumerate(names)))}
    head["notes"] = [{"text": text, "blocks": [number[name] for name in blocks if name in number]}
                     for text, blocks in head["notes"]]
    write_page(head, {**parts, **contacts, **tie_parts(folder, len(listed), offset)}, out)


def notes_of(report):
    """What `quoin check` complains of: text, and names of the blocks."""
    notes = [(f"without support: {name}", [name]) for name in report.get("without_support", [])]
    for what in ("overlaps", "gaps"):
        notes += [(f"{what[:-1]} of {abs(p['gap']):.3g} m between {p['a']} and {p['b']}", [p["a"], p["b"]])
                  for p in report.get("contacts", {}).get(what, [])]
    notes += [(f"{p['what']} outside {p['block']}", [p["block"]]) for p in report.get("points_outside", [])]
    tried = report.get("trial_step", {})
    notes += [(tried["message"], [])] if tried and not tried.get("converged", True) else []
    if report.get("refused"):
        notes.insert(0, ("quoin run refuses this scene: blocks overlap by more than 1e-3 of the smaller one", []))
    return notes


def ask(*words, codes=(0,)):
    done = subprocess.run([COMMAND, *words], capture_output=True, text=True)
    if done.returncode not in codes or not done.stdout:
        sys.stderr.write(done.stderr)
        sys.exit(done.returncode or 1)
    return done.stdout


def scene_page(path, out):
    report = json.loads(ask("check", path, "--json", codes=(0, 1, 2)))
    with tempfile.TemporaryDirectory() as folder:
        run = tried_step(path, pathlib.Path(folder) / "scene", report["refused"])
        contacts = report["contacts"]
        run_page(run, out, {"kind": "scene", "notes": notes_of(report), "marks": report["marks"][:MOST_MARKS], "history": {},
                            "title": report["title"] or pathlib.Path(path).name,
                            "facts": [f"{contacts['pairs']} touching pairs, {contacts['area']:.4g} m²",
                                      f"{report['blocks']['mass']:.4g} kg that move"]})


def tried_step(path, folder, refused):
    """The folder of a run of one static step, whose contacts are shown; of none, where the scene has no such step."""
    command = [COMMAND, "run", path, "--out", str(folder)]
    step = ["--set", '/stages=[{"analysis": "static", "max_steps": 1}]', "--set", "/references=[]"]
    if refused:
        ask(*command[1:], "--max-seconds", "0", "--set", '/initial_overlap="keep"', codes=(0, 1))
    elif subprocess.run([*command, *step], capture_output=True).returncode not in (0, 1):
        ask(*command[1:], "--max-seconds", "0", codes=(0, 1))
    return folder


def hull_faces(points):
    """Faces of a convex hull, by corner, counter-clockwise from outside; of few points."""
    centre, size = points.mean(axis=0), np.ptp(points, axis=0).max()
    faces = {}
    for three in itertools.combinations(range(len(points)), 3):
        a, b, c = points[list(three)]
        normal = np.cross(b - a, c - a)
        if np.linalg.norm(normal) <= 1e-12 * size**2:
            continue
        normal /= np.linalg.norm(normal)
        normal = -normal if (centre - a) @ normal > 0 else normal
        height = (points - a) @ normal
        if height.max() > 1e-9 * size:
            continue
        on = np.flatnonzero(height > -1e-9 * size)
        arms = points[on] - points[on].mean(axis=0)
        angle = np.arctan2(arms @ np.cross(normal, arms[0]), arms @ arms[0])
        faces[tuple(on)] = on[np.argsort(angle)].tolist()
    return list(faces.values())


def placed_points(solid):
    if isinstance(solid, list):
        return np.array(solid, dtype=float)
    points, placement = np.array(solid["points"], dtype=float), solid.get("placement")
    if placement is None:
        return points
    return points @ np.array(placement[3:], dtype=float).reshape(3, 3).T + placement[:3]


def pairs_page(path, out):
    lines = [line for line in pathlib.Path(path).read_text(encoding="utf-8").splitlines() if line.strip()]
    answers = [json.loads(line) for line in ask("contact", "--pairs", path, codes=(0, 2)).splitlines()]
    shapes, origins, pairs = [], [], []
    for line, answer in zip(lines, answers):
        try:
            solids = [placed_points(json.loads(line)[side]) for side in "ab"]
        except (ValueError, KeyError, TypeError):
            continue
        offset = np.concatenate(solids).mean(axis=0)
        for points in solids:
            few = points if len(points) <= MOST_CORNERS else points[np.unique(np.argmax(
                points @ np.random.default_rng(1).normal(size=(3, MOST_CORNERS)), axis=0))]
            centre = few.mean(axis=0)
            shapes.append({"p": short(few - centre, 7), "f": hull_faces(few)})
            origins.append(centre - offset)
        every = np.concatenate(solids) - offset
        pairs.append({**answer, "offset": short(offset, 17), "low": short(every.min(axis=0)),
                      "high": short(every.max(axis=0)), "corners": [short(p - offset, 7) for p in solids]})
    if not pairs:
        sys.exit(f"quoin view: {path}: holds no pair")
    count = len(shapes)
    head = {"title": pathlib.Path(path).name, "kind": "pairs", "blocks": count, "names": ["A", "B"] * len(pairs),
            "groups": ["A", "B"], "shapes": shapes, "motion": {"per": 6, "u": 0, "r": 0, "e": 0},
            "times": list(range(len(pairs))), "labels": [str(p.get("id") or i) for i, p in enumerate(pairs)],
            "low": pairs[0]["low"], "high": pairs[0]["high"], "offset": [0, 0, 0], "scalars": {},
            "contactTimes": [], "history": {}, "notes": [], "pairs": pairs}
    write_page(head, {"motion": np.zeros(6 * count, dtype="<i2"), "origin": np.array(origins, dtype="<f4"),
                      "shape": np.arange(count, dtype="<u4"), "kind": np.ones(count, dtype="u1"),
                      "group": (np.arange(count) % 2).astype("<u2")}, out)


def main():
    parser = argparse.ArgumentParser(prog="quoin view", description=__doc__.splitlines()[0])
    parser.add_argument("shown", nargs="?", help="folder that quoin run --out left, or SCENE.json")
    parser.add_argument("--pairs", help="pairs of solids, as quoin contact takes them")
    parser.add_argument("--out", help="the page (default: beside what is shown)")
    given = parser.parse_args()
    if (given.shown is None) == (given.pairs is None):
        print("quoin view: needs a folder, a scene or --pairs FILE", file=sys.stderr)
        sys.exit(2)
    source = pathlib.Path(given.shown or given.pairs)
    out = given.out or str(source.with_suffix("") if source.is_file() else source).rstrip("/") + ".html"
    page = pairs_page if given.pairs else run_page if source.is_dir() else scene_page
    page(str(source), out)
    print(out)


if __name__ == "__main__":
    run_program(main)
