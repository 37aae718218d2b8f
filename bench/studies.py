#!/usr/bin/env python3
"""Runs the shipped studies: CSV, JSON and a work-precision picture of each.

    bench/studies.py --quoin build-release/tools/quoin [--peers build-release/bench/bench_study]
                     [--out bench/studies] [--only NAME …]

Bullet and ODE run the same scenes when --peers names their program (-DQUOIN_BUILD_BENCH=ON); else
what they did last is drawn.
"""
import argparse
import pathlib
import shutil
import subprocess
import sys
import tempfile

TOOLS = pathlib.Path(__file__).resolve().parent.parent / "tools"
sys.path.append(str(TOOLS))
import plot_study  # noqa: E402

SCENES = TOOLS / "scenes"
STEPS = "dt=0.02,0.01,0.005,0.0025,0.00125"
DEFAULT = "method=augmented_lagrangian"  # uses no penalty
SOURCE = "method=paper,penalty"          # the source's own methods

# name: title, scene, changes, what quoin varies, what the peers vary, and for the source's examples what
# its own methods vary
STUDIES = {
    "incline": ("5.1 Block on an incline, friction 10°", "paper/incline.json", ["phi=10"],
                [STEPS, DEFAULT, "/blocks/1/kind=deformable,rigid"], [STEPS],
                [STEPS, SOURCE, "penalty=5e7,5e8,5e10"]),
    "two_forces": ("5.2 Block pushed by two forces", "paper/two_forces.json", [],
                   ["dt=0.02,0.01,0.005,0.0025", DEFAULT], ["dt=0.02,0.01,0.005,0.0025"],
                   ["dt=0.02,0.01,0.005,0.0025", SOURCE, "penalty=1e8"]),
    "stays": ("S3 Cube on 20°, friction 20.1° (error in m)", "study/friction_limit.json",
              ["phi=20.1"], [STEPS], [STEPS]),
    "slides": ("S3 Cube on 20°, friction 19.9°", "study/friction_limit.json", ["phi=19.9"],
               [STEPS], [STEPS]),
    "tower_10": ("S4 Tower of 10", "study/tower_10.json", [],
                 ["dt=0.02,0.01,0.005,0.002,0.001", "tolerance=1e-6,1e-8,1e-10"],
                 ["dt=0.02,0.01,0.005,0.002,0.001"]),
    "tower_30": ("S4 Tower of 30", "study/tower_30.json", [],
                 ["dt=0.02,0.01,0.005,0.002,0.001", "tolerance=1e-6,1e-8,1e-10"],
                 ["dt=0.02,0.01,0.005,0.002,0.001"]),
    "dominoes": ("S5 Dominoes, against the finest run of quoin", "study/dominoes.json", [],
                 ["dt=0.02,0.01,0.005,0.0025,0.00125,0.000625,0.0003125"],
                 ["dt=0.01,0.005,0.0025,0.00125,0.000625"]),
    "rocking": ("S6 Rocking block", "study/rocking.json", [],
                ["dt=0.04,0.02,0.01,0.005,0.0025,0.00125,0.000625",
                 "scheme=constant_acceleration,energy_momentum"],
                ["dt=0.04,0.02,0.01,0.005,0.0025,0.00125,0.000625"]),
    "first_impacts": ("Eight boxes fall into a bin, against the finest run of quoin", "study/first_impacts.json", [],
                      ["dt=0.01,0.005,0.0025,0.00125,0.000625,0.0003125"],
                      ["dt=0.01,0.005,0.0025,0.00125,0.000625,0.0003125"]),
    "pulled_base": ("Tower of 6 whose base is pulled away, against the finest run of quoin",
                    "study/pulled_base.json", [], ["dt=0.01,0.005,0.0025,0.00125,0.000625,0.0003125"],
                    ["dt=0.01,0.005,0.0025,0.00125,0.000625,0.0003125"]),
    "shaken_wall": ("Wall of 10 shaken across, against the finest run of quoin", "study/shaken_wall.json", [],
                    ["dt=0.01,0.005,0.0025,0.00125,0.000625,0.0003125"],
                    ["dt=0.01,0.005,0.0025,0.00125,0.000625,0.0003125"]),
    "arch_1_percent": ("S8 Arch, 1 % above its least thickness", "study/arch.json",
                       ["ratio=0.1078"], ["dt=0.02,0.01,0.005", "tolerance=1e-6,1e-8,1e-10"],
                       ["dt=0.01,0.005,0.0025,0.00125"]),
    "arch_10_percent": ("S8 Arch, 10 % above its least thickness", "study/arch.json",
                       ["ratio=0.1174"], ["dt=0.02,0.01,0.005", "tolerance=1e-6,1e-8,1e-10"],
                       ["dt=0.01,0.005,0.0025,0.00125"]),
}


def options(flag, values):
    return [word for value in values for word in (flag, value)]


def study(name, quoin, peers, out):
    title, scene, changes, vary, peers_vary, *source_vary = STUDIES[name]
    common = [str(SCENES / scene)] + options("--set", changes)
    results = []
    for folder, grid in zip((out / name, out / name / "source"), (vary, *source_vary)):
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as made:
            subprocess.run([quoin, "study", *common, *options("--vary", grid), "--out", made + "/out"],
                           check=True, stdout=subprocess.DEVNULL)
            for file in ("study.csv", "study.json"):
                shutil.copy(f"{made}/out/{file}", folder)
        results.append(folder / "study.json")
    folder = out / name
    if (folder / "peers.json").exists() or peers:
        results.append(folder / "peers.json")
    if peers:
        with open(folder / "peers.csv", "w", encoding="utf-8") as csv:
            subprocess.run([peers, *common, *options("--vary", peers_vary), "--against",
                            str(results[0]), "--out", str(results[-1])], check=True, stdout=csv)
    plot_study.draw(out / f"{name}.png", title, [plot_study.read(path) for path in results], None)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", required=True)
    parser.add_argument("--peers")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("bench/studies"))
    parser.add_argument("--only", nargs="+", choices=STUDIES, default=list(STUDIES))
    given = parser.parse_args()
    for i, name in enumerate(given.only):
        print(f"[{i + 1}/{len(given.only)}] {STUDIES[name][0]}", flush=True)
        study(name, given.quoin, given.peers, given.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
