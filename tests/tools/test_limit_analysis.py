"""The linear programme against closed forms, and the file that quoin stability judges by against it."""
import math
import pathlib
import subprocess
import sys

root = pathlib.Path(sys.argv[2])
sys.path.insert(0, str(root / "tools"))
import limit_analysis  # noqa: E402

failures = []


def check(name, found, exact, allowed):
    if not abs(found - exact) <= allowed * abs(exact):
        failures.append(f"{name}: {found}, exact {exact}")


def box(low, high, kind="rigid"):
    return {"kind": kind, "shape": {"type": "box", "min": low, "max": high}}


def scene(friction_deg, blocks):
    return {"materials": {"stone": {"density": 2000}}, "joint": {"friction_angle_deg": friction_deg},
            "blocks": blocks}


GROUND = box([-9, -9, -1], [9, 9, 0], "fixed")

# One block: it slides at tan(phi), or turns over at width / height, whichever comes first.
flat = limit_analysis.limit_of(scene(20, [GROUND, box([0, 0, 0], [2, 1, 0.5])]), [1, 0, 0])
check("block slides, inner", flat["inner"], math.tan(math.radians(20)), 1e-9)
check("block slides, outer", flat["outer"], math.tan(math.radians(20)), 2.5e-3)
if flat["hinging"] or flat["outer"] < flat["inner"]:
    failures.append(f"block slides: {flat}")
slim = limit_analysis.limit_of(scene(40, [GROUND, box([0, 0, 0], [0.5, 3, 2])]), [1, 0, 0])
check("block turns over", slim["inner"], 0.25, 1e-9)
check("block turns over, outer", slim["outer"], 0.25, 1e-9)
if not slim["hinging"]:
    failures.append("block turns over: hinging was not found")

# A column of three turns over as one; the upper two lean out by half their width: nothing holds them.
column = [GROUND] + [box([0, 0, i], [1, 1, i + 1]) for i in range(3)]
check("column", limit_analysis.limit_of(scene(40, column), [0, 1, 0])["inner"], 1 / 3, 1e-9)
out = [GROUND, box([0, 0, 0], [1, 1, 1]), box([0.51, 0, 1], [1.51, 1, 2])]
if limit_analysis.limit_of(scene(40, out), [1, 0, 0])["inner"] is not None:
    failures.append("a block that leans out by more than half stands")

# Placed by a pose, as hulls, with expressions, of two materials: the same column.
turned = {"rotation": {"axis": [0, 0, 1], "angle_deg": "=quarter"}, "about": [0.5, 0.5, 0], "translation": [3, 0, "=h"]}
corners = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
posed = scene("=2*h+38", [GROUND] + [
    {"kind": "rigid", "material": "light" if i == 0 else "stone", "shape": {"type": "hull", "points": corners},
     "pose": {**turned, "translation": [3, 0, i]}} for i in range(3)])
posed["parameters"] = {"quarter": 90, "h": 1}
posed["materials"]["light"] = {"density": 1000}
# About the edge of the base: (0.5 + 2 * 1.5 + 2 * 2.5) lambda = (1 + 2 + 2) * 0.5.
check("posed column", limit_analysis.limit_of(posed, [1, 0, 0])["inner"], 2.5 / 8.5, 1e-9)
for change, where in (({"joint": {"friction_angle_deg": 30, "cohesion": 1e4}}, "/joint/cohesion"),
                      ({"loads": []}, "/loads"), ({"gravity": [1, 0, -9]}, "/gravity")):
    try:
        limit_analysis.limit_of({**posed, **change}, [1, 0, 0])
        failures.append(f"{where} is taken")
    except ValueError as error:
        if not str(error).startswith(where):
            failures.append(f"{where}: {error}")


def arch(thickness, count=27):
    """Semicircle of mean radius 1 on two abutments, friction enough."""
    def at(radius, joint):
        angle = math.pi * joint / count
        return [-radius * math.cos(angle), 0, radius * math.sin(angle)]

    inner, outer = 1 - 0.5 * thickness, 1 + 0.5 * thickness
    blocks = [{"kind": "fixed" if i in (-1, count) else "rigid",
               "shape": {"type": "prism", "sweep": [0, 0.2, 0],
                         "polygon": [at(inner, i), at(outer, i), at(outer, i + 1), at(inner, i + 1)]}}
              for i in range(-1, count + 1)]
    return scene(60, blocks)


# A semicircle of 27 voussoirs stands from a thickness of 0.1067 of its radius on; of endlessly many
# from 0.1075 on [Milankovitch 1907].
for thickness, stands in ((0.1060, False), (0.1074, True)):
    if (limit_analysis.limit_of(arch(thickness), [1, 0, 0])["outer"] is not None) != stands:
        failures.append(f"arch of 27, {thickness} thick: stands is not {stands}")

done = subprocess.run([sys.executable, root / "tools/limit_analysis.py", "--check"], capture_output=True,
                      text=True, check=False)
if done.returncode != 0:
    failures.append(done.stdout + done.stderr)

for failure in failures:
    print("failed:", failure)
print("all passed" if not failures else f"{len(failures)} failed")
sys.exit(1 if failures else 0)
