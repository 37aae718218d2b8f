"""`quoin cut`: a scene with `cut` and the scene that is written of it run alike; OBJ names joints.

usage: test_cut_command.py QUOIN SOURCE_DIR
"""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

QUOIN = sys.argv[1]
failures = []


def expect(holds, what):
    if not holds:
        failures.append(what)


def quoin(*arguments):
    return subprocess.run([QUOIN, *map(str, arguments)], capture_output=True, text=True)


def column(**changes):
    return {"gravity": [0, 0, -10], "materials": {"stone": {"density": 2000}},
            "joint": {"friction_angle_deg": 30}, "stages": [{"analysis": "static"}],
            "blocks": [{"name": "ground", "kind": "fixed",
                        "shape": {"type": "box", "min": [-1, -1, -1], "max": [2, 2, 0]}}],
            "cut": {"name": "drum", "block": {"kind": "rigid", "material": "stone"},
                    "body": {"type": "box", "min": [0, 0, 0], "max": [1, 1, 2]},
                    "cuts": [{"type": "joint_set", "name": "bed", "dip_deg": 0,
                              "origin": [0, 0, 0], "spacing": 0.5}], **changes}}


def forces(folder):
    with open(folder / "contacts.csv", encoding="utf-8") as file:
        return [(row["name_a"], row["name_b"], row["normal_force"]) for row in csv.DictReader(file)]


with tempfile.TemporaryDirectory() as name:
    root = pathlib.Path(name)
    scene = root / "column.json"
    scene.write_text(json.dumps(column()), encoding="utf-8")
    told = json.loads(quoin("cut", scene, "--json").stdout)
    expect(told["blocks"] == 4 and abs(told["closure"]) < 1e-12 and told["volume"] == 2,
           f"counts and volumes: {told}")
    expect(quoin("cut", scene, "--out", root / "blocks.json").returncode == 0, "writes a scene")
    for source in ("column", "blocks"):
        done = quoin("run", root / f"{source}.json", "--out", root / source)
        expect(done.returncode == 0, f"{source} runs: {done.stderr}")
    expect(forces(root / "column") == forces(root / "blocks"), "both scenes have the same forces")
    bottom = sum(float(f) for a, b, f in forces(root / "column") if "ground" in (a, b))
    expect(abs(bottom - 40000) < 1e-6, f"the ground bears 40 kN: {bottom} N")

    expect(quoin("cut", scene, "--out", root / "blocks.obj").returncode == 0, "writes OBJ")
    lines = (root / "blocks.obj").read_text(encoding="utf-8").splitlines()
    expect(sum(line.startswith("o ") for line in lines) == 4, "an object a block")
    expect(lines.count("usemtl bed") == 6, "two faces of each of three planes are of the joint")

    scene.write_text(json.dumps({**column(), "cut": None}), encoding="utf-8")
    expect(quoin("cut", scene).returncode == 2, "a cut that is no object")
    wrong = column(cuts=[{"type": "plane", "dip_deg": 0, "pont": [0, 0, 0]}])
    scene.write_text(json.dumps(wrong), encoding="utf-8")
    refused = quoin("run", scene, "--out", root / "none")
    expect(refused.returncode == 2 and "/cut/cuts/0" in refused.stderr, f"its place: {refused.stderr}")

for failure in failures:
    print("failed:", failure)
sys.exit(1 if failures else 0)
