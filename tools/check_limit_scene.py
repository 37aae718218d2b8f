"""Does a certificate speak of the scene? Densities, vertices, loads, gravity and joints against the scene file.

Scenes in plain numbers: boxes, hulls and prisms without pose, body and point loads. For all else `differences` says
that it was not compared, which is no agreement.
"""
import math

import numpy as np

NEAR = 1e-9  # relative


def equal(one, other, size=0.0):
    one, other = np.array(one, float), np.array(other, float)
    size = max(size, np.abs(other).max(initial=0.0))
    return one.shape == other.shape and bool((np.abs(one - other) <= NEAR * size).all())


def vertices(shape):
    kind = shape["type"]
    if kind == "box":
        return [[x, y, z] for x, y, z in np.stack(np.meshgrid(*zip(shape["min"], shape["max"])), -1).reshape(-1, 3)]
    if kind == "hull":
        return shape["points"]
    if kind == "prism":
        return [*shape["polygon"], *(np.array(shape["polygon"]) + shape["sweep"]).tolist()]
    raise NotImplementedError(f"shapes of type {kind}")


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
    """Force and moment about the centroid, by block's name."""
    names = {solid.entry["name"]: solid for solid in solids.values()}
    result = {name: np.zeros(6) for name in names}
    for load in scene.get("loads", []):
        solid, force = names[load["block"]], np.array(load.get("force", []), float)
        if load["type"] not in ("body", "point") or force.shape != (3,):
            raise NotImplementedError(f"loads of type {load['type']}, or that vary in time")
        whole = np.concatenate([force * solid.volume, np.zeros(3)])
        if load["type"] == "point":
            whole = np.concatenate([force, np.cross(np.array(load["point"], float) - solid.centroid, force)])
        result[load["block"]] += factor_of(load) * whole
    return result


def differences(document, scene, solids):
    """One line for each; [] when the certificate is of this scene."""
    vary, value, wrong = document["vary"], document["value"], []
    if scene.get("parameters") or scene.get("import") or scene.get("overrides") or vary["what"].startswith("/"):
        raise NotImplementedError("parameters, imported blocks, overrides or a JSON pointer")
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
        if not equal([mine["friction"], mine["cohesion"], mine["tension"]], joint(entry, vary, value)):
            wrong.append("the strength of a joint is not the scene's")
    held = [contact for contact in document["contacts"] if contact["held"]]
    if len(held) != len(scene.get("fixed_points", [])):
        wrong.append("other held points than in the scene")
    live = loads_of(scene, solids, lambda load: float(vary["what"] == "load" and load.get("name") == vary["name"]))
    dead = loads_of(scene, solids, lambda load: 1.0 - (vary["what"] == "load" and load.get("name") == vary["name"]))
    if vary["what"] == "load" and not equal(vary["from"] + document["factor"], value, 1.0):
        wrong.append("the factor of the loads is not the value")
    blocks = {entry["name"]: entry for entry in scene["blocks"]}
    if set(blocks) != {solid.entry["name"] for solid in solids.values()}:
        return [*wrong, "other blocks than in the scene"]
    for solid in solids.values():
        mine, name = solid.entry, solid.entry["name"]
        entry = blocks[name]
        moves = entry.get("kind", "deformable") in ("deformable", "rigid")
        if "pose" in entry:
            raise NotImplementedError("blocks with a pose")
        if mine["moves"] != moves or not same_points(mine["vertices"], vertices(entry["shape"])):
            wrong.append(f"block {name} is not that of the scene")
        if not moves:
            continue
        if not equal(mine["density"], scene["materials"][entry["material"]]["density"]):
            wrong.append(f"block {name}: density {mine['density']}")
        size = max(np.abs(live[name]).max(), np.abs(dead[name]).max(), mine["density"] * solid.volume)
        factor = vary["from"] if vary["what"] == "load" else 0.0
        if not equal(mine["live"], live[name], size) or not equal(mine["applied"], dead[name] + factor * live[name], size):
            wrong.append(f"block {name}: its loads are not the scene's")
    return wrong
