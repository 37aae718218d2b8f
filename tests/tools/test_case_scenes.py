"""Every scene of tools/scenes/cases runs, unflagged, agrees with its references, and its ledger closes."""
import json
import pathlib
import subprocess
import sys

quoin, root = sys.argv[1], pathlib.Path(sys.argv[2])
LOSSES = ["friction_loss", "impact_loss", "algorithmic_loss"]
PARTS = ["kinetic", "potential", "strain", "contact", "work", *LOSSES]
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
    energy = summary["energy"]
    turned_over = sum(abs(energy[part]) for part in PARTS)
    if not abs(energy["closure"]) <= 1e-5 * turned_over + 1e-9:
        failures.append(f"{scene.name}: the ledger is off by {energy['closure']:.3g} J of {turned_over:.3g} J")
    failures += [f"{scene.name}: {loss} {energy[loss]:.3g} J" for loss in LOSSES
                 if not energy[loss] >= -1e-7 * turned_over - 1e-9]
for failure in failures:
    print("failed:", failure)
print("all passed" if scenes and not failures else f"{len(failures)} failed of {len(scenes)} scenes")
sys.exit(1 if failures or not scenes else 0)
