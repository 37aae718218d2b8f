"""Every scene of tools/scenes/cases runs, unflagged, and agrees with its references."""
import json
import pathlib
import subprocess
import sys

quoin, root = sys.argv[1], pathlib.Path(sys.argv[2])
failures = []
scenes = sorted((root / "tools/scenes/cases").glob("*.json"))
for scene in scenes:
    done = subprocess.run([quoin, "run", scene, "--json"], capture_output=True, text=True)
    if done.returncode != 0:
        failures.append(f"{scene.name}: {done.stderr.strip()}")
        continue
    summary = json.loads(done.stdout)
    failures += [f"{scene.name}: flag {flag}" for flag in summary["flags"]]
    failures += [f"{scene.name}: {r['name']}: error {r['error']:.3g}, allowed {r['allowed']}"
                 for r in summary["references"] if not (r["ok"] and r["steps_compared"] > 0)]
for failure in failures:
    print("failed:", failure)
print("all passed" if scenes and not failures else f"{len(failures)} failed of {len(scenes)} scenes")
sys.exit(1 if failures or not scenes else 0)
