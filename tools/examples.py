#!/usr/bin/env python3
"""Runs the paper's examples, prints what came out, makes the pictures. Called by tools/demo.

What is newer than the command, the scene and this program is not made again.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys

import plot
import render

HERE = pathlib.Path(__file__).resolve().parent
SCENES = HERE / "scenes" / "paper"
METHODS = {"penalty": "penalty", "augmented_lagrangian": "augmented Lagrangian"}
SLOPE = math.radians(20)


def run_list():
    """[(folder name, example, scene, method, penalty N/m, changes)]"""
    runs = []
    for phi in (0, 10):
        for penalty in (5e7, 5e8, 5e10):
            for method in METHODS:
                runs.append((f"incline_phi{phi}_{method}_{penalty:.0e}", f"5.1 incline, {phi} deg",
                             "incline", method, penalty, [f"phi={phi}"]))
    for example, scene, penalties in (("5.2 two forces", "two_forces", (1e8,)),
                                      ("5.3 falling block", "falling_block", (5e7,)),
                                      ("5.4 five blocks, pushed", "five_blocks", (4e7, 2e7))):
        changes = ["push=1"] if scene == "five_blocks" else []
        for penalty in penalties:
            for method in METHODS:
                runs.append((f"{scene}_{method}_{penalty:.0e}", example, scene, method, penalty,
                             changes))
    return runs


def is_newer(result, *sources):
    return result.exists() and all(result.stat().st_mtime >= s.stat().st_mtime for s in sources)


def run(quoin, folder, scene, method, penalty, changes):
    """The summary of one run; None when it failed."""
    summary = folder / "summary.json"
    path = SCENES / f"{scene}.json"
    if not is_newer(summary, pathlib.Path(quoin), path, HERE / "examples.py"):
        command = [quoin, "run", str(path), "--out", str(folder), "--set", f"/method={method}",
                   "--set", f"/penalty={penalty:g}"]
        for change in changes:
            command += ["--set", change]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            print(f"   {folder.name}: {done.stderr.strip()}")
        if not summary.exists():
            return None
    return json.loads(summary.read_text(encoding="utf-8"))


def largest_error(summary):
    errors = [r["error"] for r in summary["references"]]
    return f"{max(errors):.1e}" if errors else "-"


def table(rows):
    head = ["example", "method", "penalty N/m", "error", "largest overlap m", "steps", "run time s"]
    rows = [head] + rows
    widths = [max(len(row[i]) for row in rows) for i in range(len(head))]
    lines = ["  ".join(cell.ljust(w) if i < 2 else cell.rjust(w)
                       for i, (cell, w) in enumerate(zip(row, widths))) for row in rows]
    lines.insert(1, "  ".join("-" * w for w in widths))
    return "\n".join(lines)


def row(example, method, penalty, summary):
    if summary is None:
        return [example, METHODS[method], f"{penalty:.0e}", "failed", "", "", ""]
    steps = str(summary["steps"])
    if summary["status"] != "completed":
        steps += f" ({summary['status']})"
    return [example, METHODS[method], f"{penalty:.0e}", largest_error(summary),
            f"{summary['largest_overlap']:.1e}", steps, f"{summary['wall_seconds']:.2f}"]


def label(method, penalty):
    names = {5e7: "50 MN/m", 5e8: "500 MN/m", 5e10: "50 GN/m", 1e8: "100 MN/m", 4e7: "40 MN/m",
             2e7: "20 MN/m"}
    return f"{METHODS[method]}, {names[penalty]}"


def labelled(out, runs, prefix, order=("penalty", "augmented_lagrangian")):
    """[(folder, label)] of the runs whose name begins with `prefix`, penalty first."""
    chosen = [r for r in runs if r[0].startswith(prefix) and (out / "runs" / r[0]).exists()]
    chosen.sort(key=lambda r: order.index(r[3]))
    return [(out / "runs" / r[0], label(r[3], r[4])) for r in chosen]


def plots(out, runs):
    """(picture, what makes it) of each plot."""
    down = (math.cos(SLOPE), 0, -math.sin(SLOPE))

    def incline(phi):
        rate = 9.81 / 2 * (math.sin(SLOPE) - math.cos(SLOPE) * math.tan(math.radians(phi)))
        plot.displacement_figure(out / f"incline_phi{phi}.png",
                                 f"Block on a 20° incline, friction {phi}°",
                                 labelled(out, runs, f"incline_phi{phi}_"), "block", down,
                                 lambda t: rate * t**2)

    def two_forces():
        plot.displacement_figure(out / "two_forces.png", "Block pushed by two forces",
                                 labelled(out, runs, "two_forces"), "block", (2, -1, 0),
                                 lambda t: math.hypot(500, 250) / 4000 * t**2)

    def falling_block():
        plot.path_figure(out / "falling_block.png", "Path of the centroid",
                         labelled(out, runs, "falling_block"), "block", (0.5, 2.5), SLOPE)

    def five_blocks():
        plot.energy_figure(out / "five_blocks.png", "Five blocks",
                           labelled(out, runs, "five_blocks"), [f"block {i}" for i in range(1, 5)])

    return [("incline_phi0.png", lambda: incline(0)), ("incline_phi10.png", lambda: incline(10)),
            ("two_forces.png", two_forces), ("falling_block.png", falling_block),
            ("five_blocks.png", five_blocks)]


def renders(out):
    """(picture, run, times, direction to the eye, box to show or None)"""
    return [
        ("incline_blocks.png", "incline_phi10_augmented_lagrangian_5e+10", (0, 1.5, 2.5, 3.5),
         (-0.35, -1, 0.45), None),
        ("two_forces_blocks.png", "two_forces_augmented_lagrangian_1e+08", (0, 2, 3, 4.5),
         (-0.5, -1, 0.75), (0, 0, -1.5, 5, 3.5, 1)),
        ("falling_block_blocks.png", "falling_block_augmented_lagrangian_5e+07", (0, 0.6, 1.2, 2.4),
         (-0.35, -1, 0.3), (-0.5, 0, -4.5, 10, 1, 3.5)),
        ("five_blocks_blocks.png", "five_blocks_augmented_lagrangian_4e+07", (0, 0.7, 1.3, 5),
         (-0.45, -1, 0.42), None),
    ]


def pictures(out, runs):
    made = []
    for name, make in plots(out, runs):
        newest = [f / "summary.json" for f, _ in labelled(out, runs, name.removesuffix(".png"))]
        if newest and not is_newer(out / name, *newest, HERE / "plot.py", HERE / "examples.py"):
            make()
            made.append(name)
    for name, folder, times, direction, fit in renders(out):
        source = out / "runs" / folder / "summary.json"
        if source.exists() and not is_newer(out / name, source, HERE / "render.py",
                                            HERE / "examples.py"):
            render.render(out / "runs" / folder, out / name, times, direction, fit)
            made.append(name)
            print(f"   {name}", flush=True)
    return made


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", required=True, help="the command")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    given = parser.parse_args()
    runs = run_list()
    rows, failed = [], False
    print("== Running the paper's examples")
    for i, (name, example, scene, method, penalty, changes) in enumerate(runs):
        print(f"   [{i + 1}/{len(runs)}] {example}: {label(method, penalty)}", flush=True)
        summary = run(given.quoin, given.out / "runs" / name, scene, method, penalty, changes)
        failed = failed or summary is None or summary["status"] != "completed"
        rows.append(row(example, method, penalty, summary))
    print("== Making pictures")
    pictures(given.out, runs)
    text = table(rows)
    (given.out / "table.txt").write_text(text + "\n", encoding="utf-8")
    print(f"\n{text}\n\nError: largest difference from the exact answer by its largest value, over all "
          f"steps (5.3: free flight).\nPictures: {given.out}/*.png   "
          f"ParaView: {given.out}/runs/*/blocks.pvd, contacts.pvd")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
