#!/usr/bin/env python3
"""Holds `quoin run --mpi` on several ranks against one process, over the scenes of `quoin make`: the table of
solver/README.md.

    bench/compare_ranks.py --quoin QUOIN [--only SCENE …] [--linear SOLVER]

Of each scene: time steps, the longest way of a block, and the largest difference of a centroid, m, between one process
and another run: one process with gravity 1e-12 larger; 2 and 4 ranks. SOLVER: automatic (default), elimination, multigrid.
"""
import argparse
import csv
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile

NUDGED = "[0,0,-9.81000000000981]"  # the default, 1e-12 larger
# What `quoin make` is asked for.
SCENES = {
    "wall": ("wall", "--length", "4", "--height", "2"),
    "wall, deformable": ("wall", "--length", "2.4", "--height", "1", "--young", "1e9"),
    "arch": ("arch",),
    "dome": ("dome",),
    "stair": ("stair",),
    "tower": ("tower",),
    "slope": ("slope", "--end-time", "0.4"),
    "jointed slope": ("jointed-slope", "--rows", "4", "--columns", "2", "--sheets", "2", "--end-time", "0.4"),
    "shaken wall": ("shaken-wall", "--length", "2", "--height", "1", "--end-time", "0.3"),
    "shaken wall, deformable": ("shaken-wall", "--length", "1.6", "--height", "0.75", "--young", "1e9",
                                "--end-time", "0.2"),
    "struck wall": ("struck-wall", "--length", "2.4", "--height", "1", "--end-time", "0.3"),
    "vault that loses a pier": ("vault", "--radius", "1", "--length", "1.6", "--courses", "7", "--end-time", "0.3"),
    "pile": ("pile", "--blocks", "30", "--end-time", "0.6"),
    "bin": ("bin", "--blocks", "40", "--end-time", "0.6"),
}
SHIPPED = {"dominoes": "study/dominoes.json", "arch that loses its supports": "field/arch_spread.json"}
FOLDER = pathlib.Path(__file__).resolve().parent.parent / "tools" / "scenes"
# Of Open MPI: more ranks than cores, also as the superuser of a container.
ENVIRONMENT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
               "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_mpi_yield_when_idle": "1",
               "OMPI_MCA_hwloc_base_binding_policy": "none", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def made(quoin, name, folder):
    """The scene's file."""
    if name in SHIPPED:
        return FOLDER / SHIPPED[name]
    path = folder / "scene.json"
    path.unlink(missing_ok=True)
    subprocess.run([quoin, "make", *SCENES[name], "--out", path], check=True, stdout=subprocess.DEVNULL)
    return path


def centroids(*command, out):
    """Displacements of all blocks at the end, and how many steps that took. A scene may be cut before it rests."""
    done = subprocess.run([*map(str, command), "--out", str(out), "--json"], capture_output=True, text=True,
                          env={**os.environ, **ENVIRONMENT}, check=False)
    if not done.stdout.startswith("{"):
        sys.exit(f"{command}: {done.stderr}")
    rows = list(csv.DictReader((out / "blocks.csv").read_text(encoding="utf-8").splitlines()))
    last = [row for row in rows if row["stage"] == rows[-1]["stage"] and row["time"] == rows[-1]["time"]]
    return json.loads(done.stdout)["steps"], [[float(row[k]) for k in ("ux", "uy", "uz")] for row in last]


def apart(one, other):
    return max(math.dist(a, b) for a, b in zip(one, other, strict=True))


def compared(given, name, folder):
    scene = made(given.quoin, name, folder)
    alone = (given.quoin, "run", scene)
    on_ranks = (*alone, "--mpi", "--set", f"/linear_solver={given.linear}")
    steps, one = centroids(*alone, out=folder / "one")
    way = max(math.hypot(*u) for u in one)
    _, nudged = centroids(*alone, "--set", f"/gravity={NUDGED}", out=folder / "nudged")
    others = [centroids("mpirun", "-n", ranks, *on_ranks, out=folder / f"ranks{ranks}")[1] for ranks in (2, 4)]
    return steps, way, [apart(one, other) for other in (nudged, *others)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quoin", required=True, type=pathlib.Path)
    parser.add_argument("--only", nargs="+", choices=(*SCENES, *SHIPPED), default=(*SCENES, *SHIPPED))
    parser.add_argument("--linear", choices=("automatic", "elimination", "multigrid"), default="automatic")
    given = parser.parse_args()
    print("| scene | steps | longest way, m | gravity 1e-12 larger | 2 ranks | 4 ranks |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for name in given.only:
            steps, way, differences = compared(given, name, pathlib.Path(folder))
            cells = (f"{d:.0e}" if d > 0 else "0" for d in differences)
            print(f"| {name} | {steps} | {way:.2g} |", " | ".join(cells), "|", flush=True)


if __name__ == "__main__":
    main()
