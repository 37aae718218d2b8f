"""Every scene of tools/scenes/cases and study runs, unflagged, agrees with its references, and its ledger closes.
Case files with `elsewhere` in their `cases` come to what they say turned and far away (tests/unit/test_case_files.cpp: as
they are). A case file of `quoin validate` that says something wrong fails, and says what."""
import copy
import json
import math
import pathlib
import subprocess
import sys
import tempfile

from elsewhere import elsewhere, failures_of

quoin, root = sys.argv[1], pathlib.Path(sys.argv[2])
failures = []
scenes = sorted(scene for kind in ("cases", "study") for scene in (root / "tools/scenes" / kind).glob("*.json"))
files = {scene: json.loads(scene.read_text()) for scene in scenes if '"cases"' in scene.read_text()}

with tempfile.TemporaryDirectory() as folder:
    for scene, file in files.items():
        if "elsewhere" in file["cases"]:
            (pathlib.Path(folder) / scene.name.replace("_", "-")).write_text(json.dumps(elsewhere(file)))
    done = subprocess.run([quoin, "validate", "--folder", folder, "--json"], capture_output=True, text=True)
    failures += [f"{row['case']} elsewhere: {row['quantity']}: {row['result']}, exact {row['exact']}"
                 for row in json.loads(done.stdout or "[]") if not row["ok"]]
    if done.returncode != 0 and not failures:
        failures.append(done.stderr.strip())
for scene in (scene for scene in scenes if scene not in files):
    failures += failures_of(quoin, scene.name, scene, 1e-9, 1e-12 if scene.parent.name == "study" else math.inf)

CASE = json.loads((root / "tools/scenes/validation/V03.json").read_text())

def validated(change):
    """Exit code and output of `quoin validate` on a case file that is changed so."""
    with tempfile.TemporaryDirectory() as folder:
        document = copy.deepcopy(CASE)
        change(document["cases"])
        (pathlib.Path(folder) / "V03.json").write_text(json.dumps(document))
        done = subprocess.run([quoin, "validate", "--folder", folder], capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr

for what, change, code, said in (
        ("as it is", lambda cases: None, 0, "21 rows, 0 not ok"),
        ("a wrong reference", lambda cases: cases["rows"][0].update(exact="0.14"), 1, "21 rows, 3 not ok"),
        ("a wrong bound", lambda cases: cases["rows"][0].update(at_least=1e9), 1, "21 rows, 3 not ok"),
        ("NaN", lambda cases: cases["rows"][0].update(result="0/0"), 1, "21 rows, 3 not ok"),
        ("a flag that is not raised", lambda cases: cases["runs"][0].update(flags=["overlap"]), 1, "flags other than"),
        ("a flag within a list", lambda cases: cases["runs"][0].update(flags=[["overlap"]]), 2,
         'V03.json: /cases/runs/0/flags/0: must be'),
        ("a text to vary", lambda cases: cases["runs"][0].update(vary={"mu": ["=1/6"]}), 2, 'V03.json: /cases/runs/0/vary/mu/0: '),
        ("a key that there is not", lambda cases: cases.update(flag=["overlap"]), 2, 'V03.json: /cases/flag: unknown key "flag"'),
        ("no runs", lambda cases: cases.pop("runs"), 2, 'V03.json: /cases: missing key "runs"'),
        ("no rows", lambda cases: cases.pop("rows"), 2, 'V03.json: /cases/runs/0: missing key "rows"'),
        ("nothing allowed", lambda cases: [cases["rows"][0].pop(key, None) for key in ("allowed", "relative")], 2,
         'V03.json: /cases/rows: missing key "allowed"'),
        ("a run that breaks off", lambda cases: cases["runs"][0].update(set={"/stages": [{"analysis": "static"}],
                                                                          "/end_time": None}), (1, 2), "stage"),
        ("a name that there is not", lambda cases: cases["rows"][0].update(result="c_dx"), 2, "V03.json: /cases/rows/result: "),
        ("no result", lambda cases: cases["rows"][0].pop("result"), 2, 'V03.json: /cases/rows/0: missing key "result"')):
    got, text = validated(change)
    if got not in (code if isinstance(code, tuple) else (code,)) or said not in text:
        failures.append(f"quoin validate, {what}: exit code {got}: {text[-300:]}")

for failure in failures:
    print("failed:", failure)
print("all passed" if scenes and not failures else f"{len(failures)} failed of {len(scenes)} scenes")
sys.exit(1 if failures or not scenes else 0)
