#!/usr/bin/env python3
"""Runs walls from sudden gravity by quoin, Bullet and ODE: the data of bench/large.md.

    tools/large.py --bench BENCH --out FILE.json [--quick]

BENCH: folder of bench_large. --quick: without the largest wall, peers for 3 s each instead of 20.
"""
import argparse
import json
import pathlib
import subprocess
import sys

# Columns and rows, threads of quoin's runs, codes beside it. About 1e2 to 1e5 bricks.
WALLS = [(10, 10, (1,), ("bullet:10", "bullet:50", "bullet:250", "ode:50")),
         (46, 22, (1, 2), ("bullet:10", "bullet:50", "bullet:250", "ode:50")),
         (150, 67, (1, 2), ("bullet:10", "bullet:50", "bullet:250", "ode:50")),
         (471, 212, (2,), ("bullet:50", "ode:50"))]
REST_STEPS = 3    # the first comes to rest or near it, the others show what is left
PEER_STEPS = 50   # 0.5 s, as S7
LIMIT, QUICK_LIMIT = 20, 3  # CPU s of a peer's steps


def rows_of(*words, may_break=False):
    """What a run prints; of a peer that breaks down what it printed before."""
    done = subprocess.run([str(word) for word in words], check=not may_break, stdout=subprocess.PIPE, text=True)
    print(*words[1:], done.stdout.splitlines()[-1:], file=sys.stderr, flush=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


def measure(given):
    program = given.bench / "bench_large"
    result = {"machine": rows_of(program, "machine")[0], "rest": [], "peers": []}
    for columns, rows, threads, codes in WALLS[:-1] if given.quick else WALLS:
        for count in threads:
            result["rest"].append(rows_of(program, "rest", columns, rows, "automatic", REST_STEPS, count))
        for code in codes:
            result["peers"].append(rows_of(program, "peer", columns, rows, code, PEER_STEPS,
                                           QUICK_LIMIT if given.quick else LIMIT, may_break=True))
        given.out.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bench", type=pathlib.Path, required=True, help="folder of bench_large")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--quick", action="store_true")
    measure(parser.parse_args())


if __name__ == "__main__":
    main()
