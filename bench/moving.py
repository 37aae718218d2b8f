#!/usr/bin/env python3
"""Runs the scenes of moving_scenes.py, in which many blocks move at once: bench/moving.md.

    bench/moving.py iterations --quoin QUOIN            each contact iteration: a table
    bench/moving.py tolerances --quoin QUOIN            all kinds of scenes by tolerance: a table
    bench/moving.py peers --bench BENCH --out FILE      quoin, Bullet and ODE, and series of them: JSON
    bench/moving.py problems --bench BENCH --out FILE   the problems of bench/problems.tar.xz: CSV
    bench/moving.py endure --quoin QUOIN                scenes for 5 s by all steps and stiffnesses: a table
    bench/moving.py endure --large --quoin QUOIN        the large ones, in steps of 10 and 5 ms
    bench/moving.py creep --quoin QUOIN                 a minute of shaking that all sticks through: a table
    bench/moving.py uneven --quoin QUOIN                a boulder that slides on pebbles, by mass ratio: a table
    bench/moving.py pictures --quoin QUOIN              bench/moving_pile.png, bench/moving_wall.png
    bench/moving.py dump --quoin QUOIN                  makes bench/problems.tar.xz

QUOIN is the command, BENCH the folder of bench_moving and contact_problems. --work FOLDER: for what is made on
the way (default: moving).
"""
import argparse
import csv
import json
import math
import pathlib
import resource
import shutil
import subprocess
import sys
import tarfile

from moving_scenes import (boulder, deformable, dominoes, falling_arch, hull_pile, pile, pulled_base, shaken_wall,
                           slope, swarms)
from tables import head, row

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROBLEMS = ROOT / "bench" / "problems.tar.xz"
ITERATIONS = ("open_close", "proximal_newton", "automatic")
LIMIT = 60  # s on the clock of one run of the command, and CPU s of the steps of bench_moving

MEASURED = [pile(4, 4, 1.5), shaken_wall(10, 10, "y", 0.5), shaken_wall(10, 10, "x", 0.5), dominoes(10, 1.5),
            pulled_base(6, 0.8), falling_arch(9, 0.8), slope(3, 0.6)]

HELD = [pile(4, 4, 1.5), pile(8, 8, 0.6), hull_pile(4, 4, 1.5), shaken_wall(10, 10, "y", 0.5),
        shaken_wall(10, 10, "x", 0.5), shaken_wall(40, 25, "y", 0.05), shaken_wall(40, 25, "x", 0.05),
        dominoes(100, 4, thickness=0.15, friction=30), pulled_base(30, 2), falling_arch(9, 0.8), slope(16, 0.1)]
TOLERANCES = (1e-10, 1e-12, 1e-14)  # gaps by the smallest block; a crowd's: 1e4 times as much

COMPARED = [pile(4, 4, 1.5), pile(8, 8, 0.6), shaken_wall(10, 10, "y", 0.5), shaken_wall(10, 10, "x", 0.5),
            shaken_wall(40, 25, "y", 0.05), dominoes(100, 4, thickness=0.15, friction=30), pulled_base(30, 2),
            slope(16, 0.3), swarms(3, 1.5)]
CODES = ("quoin", "bullet:50", "ode:50", "ode:0")
# Of the picture: codes over time steps (s).
SERIES_SCENES = [pile(4, 4, 1.5), shaken_wall(10, 10, "y", 0.5)]
SERIES = {"quoin": (5e-3, 2.5e-3, 1e-3), "bullet:10": (5e-3, 1e-3, 5e-4, 2e-4, 1e-4),
          "bullet:50": (5e-3, 1e-3, 5e-4, 2e-4, 1e-4), "bullet:250": (5e-3, 1e-3, 5e-4, 2e-4, 1e-4),
          "ode:50": (5e-3, 1e-3, 5e-4, 2e-4, 1e-4)}

# Output interval (s), times shown, direction of the eye, box shown (m), blocks left out (two sides of the bin).
PICTURES = {"pile": (pile(4, 4, 2), 0.1, (0, 0.5, 1, 2), (-0.6, -1, 0.55), (-3, -3, -1.2, 2.6, 2.6, 4.2), (1, 3)),
            "wall": (shaken_wall(10, 10, "y", 4), 0.05, (0, 1, 2, 4), (-1, -0.8, 0.35), None, ())}

# And every how many steps the problem of the largest island is written.
DUMPED = {"pile": (pile(3, 2, 1.2), 5), "pile_large": (pile(4, 4, 1.5), 70),
          "pile_deformable": (deformable(pile(2, 2, 1.2), 1e9), 10),
          "wall_across": (shaken_wall(2, 6, "y", 0.6), 8), "wall_across_large": (shaken_wall(5, 5, "y", 0.6), 40),
          "wall_in_plane": (shaken_wall(2, 4, "x", 0.6), 7),
          "wall_deformable": (deformable(shaken_wall(2, 4, "y", 0.6), 1e10), 11),
          "dominoes": (dominoes(10, 2, thickness=0.15, friction=30), 3), "pulled_base": (pulled_base(6, 0.8), 6),
          "arch": (falling_arch(9, 0.8), 7), "slope": (slope(2, 0.6), 6), "swarms": (swarms(2, 1.5), 5)}
FEWEST_CONTACTS = 4  # of a problem that is kept

# Each for LONG s by all of STEPS and kinds of blocks: some 15 minutes of CPU time.
ENDURED = [dominoes(10, 0), pulled_base(6, 0), falling_arch(9, 0), pile(3, 2, 0), shaken_wall(5, 5, "x", 0),
           shaken_wall(5, 5, "y", 0), slope(3, 0)]
ENDURED_LARGE = [dominoes(100, 0, thickness=0.15, friction=30), pulled_base(30, 0), pile(4, 4, 0), hull_pile(4, 4, 0),
                 shaken_wall(10, 10, "x", 0), shaken_wall(10, 10, "y", 0)]
# As rigid blocks alone.
ENDURED_RIGID = [pile(8, 8, 0), slope(16, 0), shaken_wall(40, 25, "x", 0), shaken_wall(40, 25, "y", 0)]
LONG = 5  # s
MINUTE = 60  # s

# A boulder on pebbles of 0.1 m: mass ratios, seeds.
RATIOS = (1e2, 3e2, 1e3, 1e4, 1e5)
DRAWS = (1, 2, 3)
STEPS = (0.01, 0.005, 0.001)  # s
YOUNGS = (None, 1e8, 1e10, 1e12)  # Pa; None: rigid


def written(document, file):
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(document), encoding="utf-8")
    return file


def run(quoin, document, folder, *words, limit=LIMIT):
    """Runs it into the folder; user CPU time, s."""
    file = written(document, folder.with_suffix(".json"))
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run([quoin, "run", file, "--out", folder, "--max-seconds", str(limit), *words], check=False,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def summary_of(folder):
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


# --- each contact iteration


def most_solves(folder):
    """In a step of the run."""
    with open(folder / "history.csv", encoding="utf-8") as history:
        return max(int(line["linear_solves"]) for line in csv.DictReader(history))


def how_it_ended(summary):
    return "yes" if summary["status"] == "completed" else f"{summary['status']} at {summary['time']:.3g} s"


def iteration_row(document, iteration, folder, seconds):
    summary = summary_of(folder)
    steps, energy = summary["steps"], summary["energy"]
    return row(document["title"], iteration, how_it_ended(summary), f"{summary['factorizations'] / steps:.1f}",
               most_solves(folder), f"{summary['proximal_newton_attempts']} of {steps}", f"{summary['largest_overlap']:.1e}",
               f"{energy['growth'] / energy['scale']:.1e}", f"{1e3 * seconds / steps:.1f}")


def iterations(given):
    print(*head("scene", "iteration", "ended", "factorizations a step", "most solves in a step",
                "attempts by proximal Newton", "largest overlap m", "energy growth", "CPU ms a step"), sep="\n")
    for number, document in enumerate(MEASURED):
        for iteration in ITERATIONS:
            folder = given.work / f"{number}_{iteration}"
            seconds = run(given.quoin, document, folder, "--set", f"/contact_iteration={iteration}")
            print(iteration_row(document, iteration, folder, seconds), flush=True)


def tolerances(given):
    """Solves a step, most in one step; largest overlap, m; energy growth by its scale; CPU ms a step."""
    print(*head("scene", *(f"`tolerance` {tolerance:.0e}" for tolerance in TOLERANCES)), sep="\n")
    for document in HELD:
        cells = []
        for tolerance in TOLERANCES:
            folder = given.work / "held"
            seconds = run(given.quoin, document, folder, "--set", f"/tolerance={tolerance}")
            summary = summary_of(folder)
            steps, energy = summary["steps"], summary["energy"]
            cells.append(f"{summary['linear_solves'] / steps:.1f}, {most_solves(folder)}; "
                         f"{summary['largest_overlap']:.0e}; {energy['growth'] / energy['scale']:.0e}; "
                         f"{1e3 * seconds / steps:.1f}"
                         + ("" if summary["status"] == "completed" else f" ({how_it_ended(summary)})"))
            shutil.rmtree(folder)
        print(row(document["title"], *cells), flush=True)


# --- Bullet and ODE beside it


def judged(given, document, code, step):
    """What bench_moving says of one run; a code that broke down says nothing."""
    file = written(document, given.work / "scene.json")
    done = subprocess.run([given.bench / "bench_moving", file, code, "--dt", str(step), "--limit", str(LIMIT)],
                          check=False, stdout=subprocess.PIPE, text=True)
    row = json.loads(done.stdout) if done.returncode == 0 else None
    print(f"{document['title']}, {code}, {step} s: {row}", file=sys.stderr, flush=True)
    return row


def peers(given):
    rows = [judged(given, document, code, document["time_step"]) for document in COMPARED for code in CODES]
    series = [judged(given, document, code, step)
              for document in SERIES_SCENES for code, steps in SERIES.items() for step in steps]
    result = {"compared": [row for row in rows if row], "series": [row for row in series if row]}
    given.out.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


# --- single contact problems


def problems(given):
    folder = given.work / "problems"
    shutil.rmtree(folder, ignore_errors=True)
    with tarfile.open(PROBLEMS) as archive:
        archive.extractall(folder)
    with open(given.out, "w", encoding="utf-8") as out:
        subprocess.run([given.bench / "contact_problems", folder], check=True, stdout=out)


def largest_islands(folder):
    """Of each step's problems, one an island, the one of most contacts."""
    best = {}
    for file in sorted(folder.glob("contact_problem_*.txt")):
        step = file.stem.split("_")[2]
        contacts = next(int(line.split()[1]) for line in file.open(encoding="utf-8") if line.startswith("contacts "))
        if contacts >= FEWEST_CONTACTS and contacts > best.get(step, (0, None))[0]:
            best[step] = contacts, file
    return [file for _, file in best.values()]


def dump(given):
    folder = given.work / "dumped"
    shutil.rmtree(folder, ignore_errors=True)
    for name, (document, every) in DUMPED.items():
        run(given.quoin, document, given.work / name, "--dump-steps", str(every))
        (folder / name).mkdir(parents=True)
        for file in largest_islands(given.work / name):
            shutil.copy(file, folder / name)

    def plain(entry):  # the same bytes for the same problems, whoever made them when
        entry.mtime = entry.uid = entry.gid = 0
        entry.uname = entry.gname = ""
        return entry

    with tarfile.open(PROBLEMS, "w:xz", preset=9) as archive:
        for file in sorted(folder.glob("*/*.txt")):
            archive.add(file, file.relative_to(folder), filter=plain)


# --- long runs


def endured(given, document, step, young, folder):
    """One run of LONG s in a cell: steps lost; solves a step; energy growth; what ended it before its time."""
    document = {**(deformable(document, young) if young else document), "time_step": step, "end_time": LONG}
    seconds = run(given.quoin, document, folder, "--on-failure", "accept", limit=10 * LIMIT)
    summary = summary_of(folder)
    energy = summary["energy"]
    words = (f"{summary['unconverged_steps']}; {summary['linear_solves'] / summary['steps']:.1f}; "
             f"{energy['growth'] / energy['scale']:.0e}")
    if summary["status"] != "completed":
        words += f" ({summary['status']} at {summary['time']:.2g} s)"
    shutil.rmtree(folder)
    return words, seconds


def endure(given):
    """A line for each scene and time step, printed as soon as it is there."""
    scenes, steps = (ENDURED_LARGE + ENDURED_RIGID, STEPS[:2]) if given.large else (ENDURED, STEPS)
    print(*head("scene", "dt ms", *(f"E {young:.0e} Pa" if young else "rigid" for young in YOUNGS), "CPU s"), sep="\n",
          flush=True)
    for step in steps:
        for document in scenes:
            youngs = YOUNGS[:1] if document in ENDURED_RIGID else YOUNGS
            cells = [endured(given, document, step, young, given.work / "long") for young in youngs]
            words = [cell for cell, _ in cells] + [""] * (len(YOUNGS) - len(youngs))
            seconds = sum(seconds for _, seconds in cells)
            print(row(document["title"], f"{1e3 * step:g}", *words, f"{seconds:.0f}"), flush=True)


def creep(given):
    """Largest displacement of a brick against the base, m."""
    print(*head("direction", "iteration", "displacement m", "solves a step", "CPU s"), sep="\n", flush=True)
    for direction in "xy":
        document = shaken_wall(3, 4, direction, MINUTE, amplitude=0.2)
        for iteration in ("automatic", "proximal_newton"):
            folder = given.work / f"creep_{direction}_{iteration}"
            seconds = run(given.quoin, {**document, "output_interval": MINUTE}, folder, "--set",
                          f"/contact_iteration={iteration}", limit=10 * LIMIT)
            with open(folder / "blocks.csv", encoding="utf-8") as blocks:
                base, *bricks = [[float(line[name]) for name in ("ux", "uy", "uz")] for line in csv.DictReader(blocks)]
            summary = summary_of(folder)
            moved = max(math.dist(base, brick) for brick in bricks)
            solves = summary["linear_solves"] / summary["steps"]
            print(row(direction, iteration, f"{moved:.1e}", f"{solves:.1f}", f"{seconds:.0f}"), flush=True)


# --- light blocks under heavy ones


def uneven(given):
    """At worst of DRAWS: growth in a run or flagged in a sub-step, overlap, m; solves a step, their mean."""
    print(*head("mass ratio", *ITERATIONS), sep="\n", flush=True)
    for ratio in RATIOS:
        cells = []
        for iteration in ITERATIONS:
            rows = []
            for seed in DRAWS:
                run(given.quoin, boulder(seed, 0.1, ratio), given.work / "boulder", "--set",
                    f"/contact_iteration={iteration}")
                rows.append(summary_of(given.work / "boulder"))
            growth = [flag["value"] for row in rows for flag in row["flags"] if flag["flag"] == "energy_growth"]
            growth += [row["energy"]["growth"] / row["energy"]["scale"] for row in rows]
            lost = sum(row["status"] != "completed" for row in rows)
            cells.append(f"{max(growth):.0e}; {max(row['largest_overlap'] for row in rows):.0e}; "
                         f"{sum(row['linear_solves'] / row['steps'] for row in rows) / len(rows):.0f}"
                         + (f" ({lost} lost)" if lost else ""))
        print(row(f"{ratio:.0e}", *cells), flush=True)


# --- pictures


def pictures(given):
    from PIL import Image  # with matplotlib

    import picture

    picture.COMMAND = str(pathlib.Path(given.quoin).resolve())
    for name, (document, interval, times, direction, fit, hidden) in PICTURES.items():
        run(given.quoin, {**document, "output_interval": interval}, given.work / name, limit=10 * LIMIT)
        path = ROOT / "bench" / f"moving_{name}.png"
        picture.render(given.work / name, path, times, direction, fit, hidden)
        Image.open(path).convert("RGB").quantize(256, kmeans=2).save(path, optimize=True)


def main():
    parts = {"iterations": iterations, "tolerances": tolerances, "peers": peers, "problems": problems, "endure": endure, "creep": creep,
             "uneven": uneven, "pictures": pictures, "dump": dump}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=parts)
    parser.add_argument("--quoin", help="the command")
    parser.add_argument("--bench", type=pathlib.Path, help="folder of bench_moving and contact_problems")
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("--large", action="store_true", help="endure: the large scenes")
    parser.add_argument("--work", type=pathlib.Path, default=pathlib.Path("moving"))
    given = parser.parse_args()
    for name in ("bench", "out") if given.what in ("peers", "problems") else ("quoin",):
        if getattr(given, name) is None:
            parser.error(f"{given.what} needs --{name}")
    parts[given.what](given)


if __name__ == "__main__":
    main()
