"""A scene, or a case file, turned by 47 degrees about a slanting axis and two million metres away: what it must come to
stays, since references and formulas are in its own axes. And what is wrong with a run of a scene with references."""
import json
import math
import re
import subprocess

AXIS, ANGLE, FAR = [1, 2, -0.5], 47.0, [0, 0, 0]
VECTORS = {"gravity", "velocity", "angular_velocity", "acceleration", "displacement", "rotation", "force", "traction", "towards", "along"}


def rotation(axis, angle_deg):
    """By Rodrigues' formula, by rows."""
    x, y, z = (c / math.hypot(*axis) for c in axis)
    c, s = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    return [[c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s],
            [y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s],
            [z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c)]]


COMPONENT = [["xx", "xy", "zx"], ["xy", "yy", "yz"], ["zx", "yz", "zz"]]
TURN = rotation(AXIS, ANGLE)


def place(axis):
    """A place before it was turned and moved, by what it is now."""
    column = "xyz".index(axis)
    return "(" + "+".join(f"({row[column]!r})*({now}-({far!r}))" for row, now, far in zip(TURN, "xyz", FAR)) + ")"


def by_rows(vector):
    return [sum(q * c for q, c in zip(row, vector)) for row in TURN]


def turned(value):
    """A vector, with expressions or without, or one of time."""
    if isinstance(value, dict):
        if "table" in value:
            return {"table": [[row[0], *turned(row[1:])] for row in value["table"]]}
        return {"formula": ["+".join(f"({q!r})*({part})" for q, part in zip(row, value["formula"])) for row in TURN]}
    if any(isinstance(c, str) for c in value):
        return ["=" + "+".join(f"({q!r})*({str(c).lstrip('=')})" for q, c in zip(row, value)) for row in TURN]
    return by_rows(value)


def moved(point):
    return [f"{there}+({far!r})" if isinstance(there, str) else there + far for there, far in zip(turned(point), FAR)]


def in_own_axes(text):
    """A formula of what a run shows: NAME_dx is the displacement along the scene's own x."""
    def own(found):
        column = "xyz".index(found[2])
        return "(" + "+".join(f"({row[column]!r})*{found[1]}{axis}" for row, axis in zip(TURN, "xyz")) + ")"
    def own_strain(found):  # as gamma beside the diagonal
        i, j = ("xyz".index(axis) for axis in found[2])
        return "(" + "+".join(f"({(1 + (i != j)) / (1 + (k != m)) * TURN[k][i] * TURN[m][j]!r})*{found[1]}{COMPONENT[k][m]}"
                              for k in range(3) for m in range(3)) + ")"
    return re.sub(r"\b(\w+_e)([xyz]{2})\b", own_strain, re.sub(r"\b(\w+_[dvrwfmpl])([xyz])\b", own, text))


def pose_of(pose):
    """The matrix by rows and the translation of TURN (R (x - about) + about + translation) + FAR."""
    turn = rotation(**pose["rotation"]) if "rotation" in pose else [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    about, way = pose.get("about", [0, 0, 0]), pose.get("translation", [0, 0, 0])
    left = [a + t - sum(q * c for q, c in zip(row, about)) for a, t, row in zip(about, way, turn)]
    columns = [by_rows([row[i] for row in turn]) for i in range(3)]
    return {"rotation": {"matrix": [list(row) for row in zip(*columns)]},
            "translation": [a + b for a, b in zip(by_rows(left), FAR)]}


def placed(value, key=""):
    key = key.rsplit("/", 1)[-1]
    if isinstance(value, str):
        return re.sub(r"\b[xyz]\b", lambda at: place(at[0]), value) if key in ("where", "pressure") else in_own_axes(value)
    if key in VECTORS:
        return turned(value)
    if key in ("point", "about", "centre"):
        return moved(value)
    if isinstance(value, list):
        return [placed(entry) for entry in value]
    if not isinstance(value, dict):
        return value
    made = {name: placed(entry, name) for name, entry in value.items() if name != "pose"}
    if "shape" in value or "parts" in value:
        made["pose"] = pose_of(value.get("pose", {}))
    if "monitor" in value and "component" in value:
        made["along"] = turned([float(value["component"] == axis) for axis in "xyz"])
        del made["component"]
    return made


def elsewhere(scene):
    there = scene.get("cases", {}).get("elsewhere", True)
    FAR[:] = [1e6, -2e6, 5e5] if there is True else there
    return placed({"gravity": [0, 0, -9.81], **scene})


LOSSES = ["friction_loss", "impact_loss", "algorithmic_loss"]
PARTS = ["kinetic", "potential", "strain", "contact", "work", *LOSSES]


def failures_of(quoin, name, path, noise=0.0, overlap=math.inf):
    """Flags, references that are not met, an overlap (m), a ledger that does not close (`noise`: in J), losses below 0."""
    done = subprocess.run([quoin, "run", path, "--json"], capture_output=True, text=True)
    if done.returncode != 0:
        return [f"{name}: {done.stderr.strip()}"]
    summary = json.loads(done.stdout)
    found = [f"{name}: flag {flag}" for flag in summary["flags"]]
    found += [f"{name}: {r['name']}: error {r['error']:.3g}, allowed {r['allowed']}"
              for r in summary["references"] if not (r["ok"] and r["steps_compared"] > 0)]
    if not summary["largest_overlap"] < overlap:
        found.append(f"{name}: overlap {summary['largest_overlap']:.3g} m")
    energy = summary["energy"]
    turned_over = sum(abs(energy[part]) for part in PARTS)
    if not abs(energy["closure"]) <= 1e-5 * turned_over + noise:
        found.append(f"{name}: the ledger is off by {energy['closure']:.3g} J of {turned_over:.3g} J")
    return found + [f"{name}: {loss} {energy[loss]:.3g} J" for loss in LOSSES
                    if not energy[loss] >= -1e-7 * turned_over - noise]
