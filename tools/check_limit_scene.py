"""Does a certificate speak of the scene? Densities, vertices, loads, gravity and joints against the scene file.

Scenes in plain numbers: blocks of any shape, parts and pose, OBJ files, body and point loads. Of all else (formulas,
overrides, cuts, other files, water, face loads, joints by place) `differences` says that it was not compared, which is
no agreement.
"""
import json
import math
import pathlib

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial.transform import Rotation

NEAR = 1e-9  # relative


def equal(one, other, size=0.0):
    one, other = np.array(one, float), np.array(other, float)
    size = max(size, np.abs(other).max(initial=0.0))
    return one.shape == other.shape and bool((np.abs(one - other) <= NEAR * size).all())


def read(path):
    """A scene whose formulas are at most names of its parameters; with others it keeps its parameters."""
    text = pathlib.Path(path).read_text(encoding="utf-8")
    for name, value in json.loads(text).get("parameters", {}).items():
        text = text.replace(f'"={name}"', json.dumps(value))
    scene = json.loads(text)
    if '"=' not in text and '"formula"' not in text:
        scene.pop("parameters", None)
    return {**scene, "folder": pathlib.Path(path).parent}


def vertices(shape):
    kind = shape["type"]
    if kind == "box":
        return [[x, y, z] for x, y, z in np.stack(np.meshgrid(*zip(shape["min"], shape["max"])), -1).reshape(-1, 3)]
    if kind == "hull":
        return shape["points"]
    if kind == "prism":
        return [*shape["polygon"], *(np.array(shape["polygon"]) + shape["sweep"]).tolist()]
    return shape["vertices"]


def placed(points, pose):
    """x -> R (x - about) + about + translation."""
    about, turn = np.array(pose.get("about", [0, 0, 0]), float), pose.get("rotation", {"matrix": np.eye(3)})
    if "axis" in turn:
        axis = np.array(turn["axis"], float)
        turn = Rotation.from_rotvec(math.radians(turn["angle_deg"]) * axis / np.linalg.norm(axis))
    elif "matrix" in turn:
        turn = Rotation.from_matrix(turn["matrix"])
    else:
        turn = Rotation.from_quat(np.roll(turn["quaternion"], -1))
    return turn.apply(np.array(points, float) - about) + about + np.array(pose.get("translation", [0, 0, 0]), float)


def obj_surfaces(path):
    """Places of each closed surface of an OBJ file."""
    points, faces = [], []
    for words in map(str.split, path.read_text(encoding="utf-8").splitlines()):
        if words[:1] == ["v"]:
            points.append([float(word) for word in words[1:4]])
        if words[:1] == ["f"]:
            faces.append([int(word.split("/")[0]) for word in words[1:]])
    pairs = np.array([(f[0], v) for f in faces for v in f])
    pairs = np.where(pairs > 0, pairs - 1, len(points) + pairs)
    _, group = connected_components(coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(points),) * 2))
    used = np.unique(pairs)
    return [np.array(points)[used[group[used] == g]] for g in dict.fromkeys(group[pairs[:, 0]])]


def blocks_of(scene):
    """Entry and places of each block, in the order of the scene."""
    listed = scene["blocks"] if isinstance(scene["blocks"], list) else [scene["blocks"]]
    for entry in listed:
        shapes = [vertices(shape) for shape in entry.get("parts") or [entry.get("shape")] if shape]
        if "file" in entry:
            if pathlib.Path(entry["file"]).suffix != ".obj" or {"format", "units", "split", "supports"} & set(entry):
                raise NotImplementedError("block files but OBJ in metres, whose blocks all move")
            for points in obj_surfaces(scene["folder"] / entry["file"]):
                yield entry, placed(points, entry.get("pose", {}))
        else:
            yield entry, placed(np.concatenate(shapes), entry.get("pose", {}))


def same_points(one, other):
    one, other = np.array(one, float), np.array(other, float)
    near = 1e-9 * max(1e-300, np.ptp(other, axis=0).max())
    return len(one) == len(other) and all(np.abs(other - p).max(axis=1).min() <= near for p in one)


def turned(gravity, vary, value):
    """The ground turns, gravity does not: in the frame of the ground it turns back."""
    axis, angle, g = np.array(vary["axis"], float), -math.radians(value), np.array(gravity, float)
    return g * math.cos(angle) + np.cross(axis, g) * math.sin(angle) + axis * (axis @ g) * (1 - math.cos(angle))


def joint(entry, vary, value):
    slope = math.tan(math.radians(entry.get("friction_angle_deg", 0.0)))
    if vary["what"] == "friction":
        slope = math.tan(math.radians(value))
    part = value if vary["what"] == "strength" else 1.0
    return [slope / part, entry.get("cohesion", 0.0) / part, entry.get("tension", 0.0) / part]


def loads_of(scene, solids, factor_of):
    """Force and moment about the centroid, by the block's number."""
    named = {solid.entry["name"]: solid for solid in solids.values()}
    result = {number: np.zeros(6) for number in solids}
    for load in scene.get("loads", []):
        solid, force = named.get(load["block"]) or solids[load["block"]], np.array(load.get("force", []), float)
        if load["type"] not in ("body", "point") or force.shape != (3,):
            raise NotImplementedError(f"loads of type {load['type']}, or that vary in time")
        whole = np.concatenate([force * solid.volume, np.zeros(3)])
        if load["type"] == "point":
            whole = np.concatenate([force, np.cross(np.array(load["point"], float) - solid.centroid, force)])
        result[solid.entry["index"]] += factor_of(load) * whole
    return result


def differences(document, scene, solids):
    """One line for each; [] when the certificate is of this scene."""
    vary, value, wrong = document["vary"], document["value"], []
    if vary["what"].startswith("/") or {"parameters", "overrides", "cut", "water", "ties", "quiet_faces"} & set(scene):
        raise NotImplementedError("parameters, overrides, cuts, water, ties, quiet faces or a JSON pointer")
    gravity = scene.get("gravity", [0, 0, -9.81])
    gravity = turned(gravity, vary, value) if vary["what"] == "tilt" else gravity
    if document.get("shrink", 1.0) != 1.0:
        wrong.append("joints are shrunk")
    if not equal(document["gravity"], gravity):
        wrong.append(f"gravity is {document['gravity']}, the scene has {list(gravity)}")
    joints = [scene.get("joint", {}), *scene.get("joints", [])]
    if any({"blocks", "planes", "where"} & set(entry) for entry in joints):
        raise NotImplementedError("joints by blocks, planes or place")
    if len(joints) != len(document["joints"]):
        wrong.append("other joints than in the scene")
    for mine, entry in zip(document["joints"], joints):
        strength, least = [mine["friction"], mine["cohesion"], mine["tension"]], joint(entry, vary, value)
        weaker = document["certificate"] == "stands" and (np.array(strength) <= least).all()
        if not (weaker or equal(strength, least)):
            wrong.append("the strength of a joint is not the scene's")
    held = [contact for contact in document["contacts"] if contact["held"]]
    if len(held) != len(scene.get("fixed_points", [])):
        wrong.append("other held points than in the scene")
    live = loads_of(scene, solids, lambda load: float(vary["what"] == "load" and load.get("name") == vary["name"]))
    dead = loads_of(scene, solids, lambda load: 1.0 - (vary["what"] == "load" and load.get("name") == vary["name"]))
    if vary["what"] == "load" and not equal(vary["from"] + document["factor"], value, 1.0):
        wrong.append("the factor of the loads is not the value")
    blocks = list(blocks_of(scene))
    if len(blocks) != len(solids):
        return [*wrong, "other blocks than in the scene"]
    for (entry, points), (number, solid) in zip(blocks, sorted(solids.items())):
        mine, name = solid.entry, solid.entry["name"]
        moves = entry.get("kind", "deformable") in ("deformable", "rigid")
        if mine["moves"] != moves or entry.get("name", name) != name or not same_points(mine["vertices"], points):
            wrong.append(f"block {name} is not that of the scene")
        if not moves:
            continue
        if not equal(mine["density"], scene["materials"][entry["material"]]["density"]):
            wrong.append(f"block {name}: density {mine['density']}")
        size = max(np.abs(live[number]).max(), np.abs(dead[number]).max(), mine["density"] * solid.volume)
        factor = vary["from"] if vary["what"] == "load" else 0.0
        loads = [*live[number], *(dead[number] + factor * live[number])]
        if not equal([*mine["live"], *mine["applied"]], loads, size):
            wrong.append(f"block {name}: its loads are not the scene's")
    return wrong
