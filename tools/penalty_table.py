#!/usr/bin/env python3
"""Does the result or the cost depend on the penalty? Table over 1e3 … 1e14 N/m, by `quoin study`.

    tools/penalty_table.py --quoin build-release/tools/quoin [OUT.md]

Exit code 1 when the default method misses a goal: results within 1e-6 of each other, overlap at most
1e-9 of the block, mean linear solves a step within 1.5 between best and worst penalty and at most 8
in quiet contact. Plain Uzawa is run beside it on the first example, for a shorter time.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

SCENES = pathlib.Path(__file__).resolve().parent / "scenes"
PENALTIES = [f"1e{k}" for k in range(3, 15)]
SAME, OVERLAP, RATIO, QUIET_SOLVES = 1e-6, 1e-9, 1.5, 8
# name: scene, changes, largest edge of a block (m), quiet (contacts stay as they are)
RUNS = {
    "5.1 incline, friction 10°": ("paper/incline.json", ["phi=10"], 1.0, True),
    "5.1 incline, frictionless": ("paper/incline.json", ["phi=0"], 1.0, True),
    "5.2 two forces": ("paper/two_forces.json", [], 1.0, True),
    "5.3 falling block": ("paper/falling_block.json", [], 1.0, False),
    "5.4 five blocks, pushed": ("paper/five_blocks.json", ["push=1"], 1.6, False),
    "tower of 30": ("study/tower_30.json", [], 1.0, True),
    "arch, 1 % above its limit": ("study/arch.json", ["ratio=0.1078"], 1.0, True),
    "dominoes": ("study/dominoes.json", [], 1.5, False),
}
UZAWA = ("paper/incline.json", ["phi=10", "/end_time=0.2", "/max_iterations=5000"])


def study(quoin, scene, changes, method):
    with tempfile.TemporaryDirectory() as folder:
        command = [quoin, "study", str(SCENES / scene), "--vary", "penalty=" + ",".join(PENALTIES),
                   "--set", f"/method={method}", "--out", folder]
        for change in changes:
            command += ["--set", change]
        subprocess.run(command, stdout=subprocess.DEVNULL, check=False)
        return json.loads((pathlib.Path(folder) / "study.json").read_text())["points"]


def spread(points):
    """Largest difference of an end from that of the first point, by the largest displacement."""
    first = points[0]["ends"]
    scale = max((math.dist(end, (0, 0, 0)) for end in first if end[0] is not None), default=0)
    worst = max((math.dist(a, b) for p in points for a, b in zip(p["ends"], first)
                 if a[0] is not None), default=0)
    return worst / scale if scale > 1e-9 else worst


def row(name, points, size, quiet):
    failed = [p for p in points if p["failure"]]
    if failed:
        return f"| {name} | | | | | | MISSED: {len(failed)} of {len(points)} runs failed |", False
    solves = [p["solves_per_step"] for p in points]
    overlap = max(p["largest_overlap"] for p in points)
    ratio = max(solves) / min(solves)
    met = (spread(points) <= SAME and overlap <= OVERLAP * size and ratio <= RATIO
           and (not quiet or max(solves) <= QUIET_SOLVES))
    return (f"| {name} | {spread(points):.1e} | {overlap:.1e} | {min(solves):.2f} | {max(solves):.2f} "
            f"| {ratio:.2f} | {'met' if met else 'MISSED'} |"), met


def uzawa(points):
    lines = ["| penalty N/m | solves a step | error | |", "|---|---|---|---|"]
    for penalty, p in zip(PENALTIES, points):
        error = "" if p["error"] is None else f"{p['error']:.1e}"
        told = "does not converge, and says so" if p["failure"] else ""
        lines.append(f"| {penalty} | {p['solves_per_step']:.1f} | {error} | {told} |")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", required=True)
    parser.add_argument("out", nargs="?", type=pathlib.Path)
    given = parser.parse_args()
    lines = ["| scene | results differ by | largest overlap m | solves a step, best | worst "
             "| worst / best | goals |", "|---|---|---|---|---|---|---|"]
    print(*lines, sep="\n")
    all_met = True
    for name, (scene, changes, size, quiet) in RUNS.items():
        line, met = row(name, study(given.quoin, scene, changes, "augmented_lagrangian"), size, quiet)
        all_met = all_met and met
        lines.append(line)
        print(line, flush=True)
    plain = uzawa(study(given.quoin, *UZAWA, "uzawa"))
    print("", *plain, sep="\n")
    if given.out:
        given.out.write_text("\n".join([*lines, "", *plain]) + "\n", encoding="utf-8")
    return 0 if all_met else 1


if __name__ == "__main__":
    sys.exit(main())
