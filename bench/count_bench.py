#!/usr/bin/env python3
"""Counts instructions, branches missed and cache misses of the timed calls that have a goal (W1 to W5), by callgrind.

  count_bench.py PROGRAMS_DIRECTORY --out COUNTS.json [--filter REGEX]

Callgrind knows no AVX-512: quoin's AVX2 kernels are counted. Its caches are those of a core with 48 KB, 1 MB
behind them; of branches it has a simple model. A pass over the same pairs goes before, and wrong answers count.
The programs must have been built with valgrind's header callgrind.h there.
"""
import argparse
import functools
import json
import os
import re
import shutil
import subprocess
import sys

from tables import GOALS, reference_of

CACHES = ["--I1=32768,8,64", "--D1=49152,12,64", "--LL=1048576,16,64"]


@functools.cache
def count(program, workload, peer):
    """Events of one query: instructions, branches missed, and data misses of the first and second cache."""
    command = ["valgrind", "--tool=callgrind", "--instr-atstart=no", "--toggle-collect=quoin::bench::counted*", "--cache-sim=yes",
               "--branch-sim=yes", "--callgrind-out-file=/dev/null", *CACHES,
               program, "--filter", f"^{re.escape(workload)}$", "--count", peer]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode != 0:
        lines = [line for line in run.stderr.splitlines() if line and not line.startswith("==")]
        sys.exit(f"{program}: {lines[-1] if lines else f'exit {run.returncode}'}")
    queries = int(re.search(r"counted (\d+) queries", run.stdout).group(1))
    names = re.search(r"Events +: (.*)", run.stderr).group(1).split()
    events = dict(zip(names, map(int, re.search(r"Collected : (.*)", run.stderr).group(1).split())))
    if events["Ir"] == 0:
        sys.exit(f"{program} was built without valgrind/callgrind.h")
    sums = {"instructions": ["Ir"], "branches_missed": ["Bcm", "Bim"], "first_cache_missed": ["D1mr", "D1mw"],
            "second_cache_missed": ["DLmr", "DLmw"]}
    return {name: round(sum(events[e] for e in parts) / queries, 2) for name, parts in sums.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("programs", metavar="DIRECTORY", help="where bench_nearest_features and bench_contact_points are")
    parser.add_argument("--out", required=True, metavar="FILE")
    parser.add_argument("--filter", default="", help="of the workloads")
    arguments = parser.parse_args()
    try:
        chosen = re.compile(arguments.filter)
    except re.error as error:
        parser.error(f"--filter {arguments.filter}: {error}")
    workloads = [workload for workload in GOALS if workload[0] == "W" and chosen.search(workload)]
    if not workloads:
        parser.error(f"no workload with a goal fits --filter {arguments.filter}")
    if shutil.which("valgrind") is None:
        sys.exit("valgrind is not installed")
    counts = []
    for workload in workloads:
        entry, _ = GOALS[workload]
        stage = "contact_points" if workload.startswith("W4") else "nearest_features"
        program = os.path.join(arguments.programs, "bench_" + stage)
        if not os.access(program, os.X_OK):
            sys.exit(f"{program} has not been built")
        # ODE is the yardstick of all of W4, asked for overlapping boxes.
        asked = "W4/box-overlap" if workload.startswith("W4") else workload
        for peer, what in ((entry, workload), (reference_of(workload), asked)):
            counts.append({"workload": workload, "peer": peer, **count(program, what, peer)})
            print(counts[-1], flush=True)
    with open(arguments.out, "w", encoding="utf-8") as file:
        file.write("[\n  " + ",\n  ".join(json.dumps(row) for row in counts) + "\n]\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
