#!/usr/bin/env python3
"""Scenes in which many blocks move at once: runs them by each contact iteration, or dumps their problems.

    tools/moving.py measure --quoin QUOIN [--problems CONTACT_PROBLEMS] [--work FOLDER]   tables on standard output
    tools/moving.py dump --quoin QUOIN [--work FOLDER]          bench/problems/, from the small scenes
"""
import argparse
import csv
import json
import pathlib
import resource
import shutil
import subprocess

from moving_scenes import deformable, dominoes, falling_arch, pile, pulled_base, shaken_wall, slope

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROBLEMS = ROOT / "bench" / "problems"
ITERATIONS = ("open_close", "proximal_newton", "automatic")
LIMIT = 60  # s on the clock of one run


MEASURED = [pile(4, 4, 1.5), shaken_wall(10, 10, "y", 0.5), shaken_wall(10, 10, "x", 0.5), dominoes(10, 1.5),
            pulled_base(6, 0.8), falling_arch(9, 0.8), slope(3, 0.6)]
# And every how many steps one problem is written.
DUMPED = {"pile": (pile(3, 2, 1.2), 20), "wall_across": (shaken_wall(2, 6, "y", 0.6), 24),
          "wall_in_plane": (shaken_wall(2, 4, "x", 0.6), 24), "dominoes": (dominoes(10, 1.5), 20),
          "pulled_base": (pulled_base(6, 0.8), 16), "arch": (falling_arch(9, 0.8), 20),
          "slope": (slope(2, 0.6), 30)}


# Small ones, each for LONG s by all of STEPS and kinds of blocks.
ENDURED = [pile(2, 2, 0), shaken_wall(2, 4, "y", 0), shaken_wall(2, 4, "x", 0), dominoes(5, 0), pulled_base(4, 0),
           falling_arch(7, 0), slope(2, 0)]
LONG = 5  # s
STEPS = (0.01, 0.005, 0.001)  # s
YOUNGS = (None, 1e8, 1e10, 1e12)  # Pa; None: rigid


def run(quoin, document, folder, *words):
    folder.parent.mkdir(parents=True, exist_ok=True)
    file = folder.with_suffix(".json")
    file.write_text(json.dumps(document), encoding="utf-8")
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run([quoin, "run", file, "--out", folder, "--max-seconds", str(LIMIT), *words], check=False,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def row(document, iteration, folder, seconds):
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    with open(folder / "history.csv", encoding="utf-8") as history:
        solves = [int(line["linear_solves"]) for line in csv.DictReader(history)]
    steps, energy = summary["steps"], summary["energy"]
    ended = "yes" if summary["status"] == "completed" else f"{summary['status']} at {summary['time']:.3g} s"
    return (f"| {document['title']} | {iteration} | {ended} | {summary['factorizations'] / steps:.1f} | {max(solves)} "
            f"| {summary['proximal_newton_attempts']} of {steps} | {summary['largest_overlap']:.1e} "
            f"| {energy['growth'] / energy['scale']:.1e} | {1e3 * seconds / steps:.1f} |")


def measure(quoin, problems, work):
    print("| scene | iteration | ended | factorizations a step | most solves in a step | attempts by proximal Newton "
          "| largest overlap m | energy growth | CPU ms a step |\n|---|---|---|---|---|---|---|---|---|")
    for number, document in enumerate(MEASURED):
        for iteration in ITERATIONS:
            folder = work / f"{number}_{iteration}"
            seconds = run(quoin, document, folder, "--set", f"/contact_iteration={iteration}")
            print(row(document, iteration, folder, seconds), flush=True)
    if problems:
        print("\nThe problems of `bench/problems`:\n", flush=True)
        subprocess.run([problems, PROBLEMS], check=True)


def endured(quoin, document, step, young, folder):
    """One run of LONG s in a cell: steps it lost, solves a step, most energy growth; what ended it before its time."""
    document = {**(deformable(document, young) if young else document), "time_step": step, "end_time": LONG}
    seconds = run(quoin, document, folder, "--on-failure", "accept")
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    energy = summary["energy"]
    lost = summary["unconverged_steps"]
    words = f"{lost}; {summary['linear_solves'] / summary['steps']:.1f}; {energy['growth'] / energy['scale']:.0e}"
    if summary["status"] != "completed":
        words += f" ({summary['status']} at {summary['time']:.2g} s)"
    shutil.rmtree(folder)
    return words, seconds


def endure(quoin, work):
    print("| scene | dt ms | " + " | ".join(f"E {young:.0e} Pa" if young else "rigid" for young in YOUNGS)
          + " | CPU s |\n|---|---|" + "---|" * (len(YOUNGS) + 1), flush=True)
    for step in STEPS:
        for number, document in enumerate(ENDURED):
            cells = [endured(quoin, document, step, young, work / f"long_{number}") for young in YOUNGS]
            print(f"| {document['title']} | {1e3 * step:g} | " + " | ".join(words for words, _ in cells)
                  + f" | {sum(seconds for _, seconds in cells):.0f} |", flush=True)


def dump(quoin, work):
    for name, (document, every) in DUMPED.items():
        run(quoin, document, work / name, "--dump-steps", str(every))
        (PROBLEMS / name).mkdir(parents=True, exist_ok=True)
        for file in sorted((work / name).glob("contact_problem_*.txt")):
            shutil.copy(file, PROBLEMS / name)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("measure", "dump", "endure"))
    parser.add_argument("--quoin", required=True)
    parser.add_argument("--problems", help="the program contact_problems")
    parser.add_argument("--work", type=pathlib.Path, default=pathlib.Path("moving"))
    given = parser.parse_args()
    if given.what == "measure":
        measure(given.quoin, given.problems, given.work)
    elif given.what == "endure":
        endure(given.quoin, given.work)
    else:
        dump(given.quoin, given.work)


if __name__ == "__main__":
    main()
