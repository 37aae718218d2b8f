"""Every scene of tools/scenes/field agrees with its closed form, unflagged: as it is written, and with deformable blocks,
turned by 47 degrees about a slanting axis and two million metres away."""
import json
import math
import pathlib
import subprocess
import sys
import tempfile

from elsewhere import elsewhere, failures_of

quoin, root = sys.argv[1], pathlib.Path(sys.argv[2])


def soft_elsewhere(scene):
    """The scene with deformable blocks, turned and moved."""
    scene = elsewhere(scene)
    for block in scene["blocks"]:
        block["kind"] = {"rigid": "deformable"}.get(block["kind"], block["kind"])
    return scene


# Friction (degrees), and the factor of safety of strength with which the scene is lost when let go.
FACTORS = {"wet_wedge_slides": (30.0, 0.50851132),  # [Hoek & Bray 1981], less the water's pressure on both joints
           "dam": (math.degrees(math.atan(0.6)), 0.6 * (2400 * 9.81 - 9810) * 8.6 / 98100)}


def factor_failures(name, path):
    friction, exact = FACTORS[name]
    scene = json.loads(path.read_text())
    scene["joint"], scene["stages"] = {"friction_angle_deg": friction}, [{"analysis": "static"}]
    del scene["references"]
    path.write_text(json.dumps(scene))
    done = subprocess.run([quoin, "limit", path, "--vary", "strength=0.2:2", "--json"], capture_output=True, text=True)
    if done.returncode != 0:
        return [f"{name}: {done.stderr.strip()}"]
    sudden = json.loads(done.stdout)["loading"]["sudden"]
    return [] if sudden["holds"] <= exact * (1 + 1e-4) and exact <= sudden["lost"] * (1 + 1e-4) else [
        f"{name}: factor of safety {exact} is not between {sudden['holds']} and {sudden['lost']}"]


failures = []
scenes = sorted((root / "tools/scenes/field").glob(sys.argv[3] if len(sys.argv) > 3 else "*.json"))
with tempfile.TemporaryDirectory() as folder:
    for scene in scenes:
        failures += failures_of(quoin, scene.stem, scene)
        copy = pathlib.Path(folder) / scene.name
        copy.write_text(json.dumps(soft_elsewhere(json.loads(scene.read_text()))))
        failures += failures_of(quoin, f"{scene.stem} elsewhere", copy)
        if scene.stem in FACTORS:
            failures += factor_failures(scene.stem, copy)
            copy.write_text(scene.read_text())
            failures += factor_failures(scene.stem, copy)
for failure in failures:
    print("failed:", failure)
print("all passed" if scenes and not failures else f"{len(failures)} failures in {len(scenes)} scenes")
sys.exit(1 if failures or not scenes else 0)
