#!/usr/bin/env python3
"""Runs walls from sudden gravity by quoin, Bullet and ODE, and large scenes that move by quoin and Bullet: the
data of bench/large.md.

    bench/large.py --bench BENCH --out FILE.json [--quick] [--part rest|moving] [--scenes PATTERN]

BENCH: folder of bench_large and bench_moving. --quick: without the largest walls and scenes, peers for 3 s each
instead of 20. --part: the other part of FILE stays as it is. --scenes: of moving those whose titles the pattern is
found in; the rows of the others stay.
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile

from moving_scenes import hull_pile, jointed_slope, pile, shaken_wall, slope, struck_wall, vault

# Columns and rows, threads of quoin's runs, codes beside it. About 1e2 to 1e5 bricks.
WALLS = [(10, 10, (1,), ("bullet:10", "bullet:50", "bullet:250", "ode:50")),
         (46, 22, (1, 2), ("bullet:10", "bullet:50", "bullet:250", "ode:50")),
         (150, 67, (1, 2), ("bullet:10", "bullet:50", "bullet:250", "ode:50")),
         (471, 212, (2,), ("bullet:50", "ode:50"))]
REST_STEPS = 3    # the first comes to rest or near it, the others show what is left
PEER_STEPS = 50   # 0.5 s, as S7
LIMIT, QUICK_LIMIT = 20, 3  # CPU s of a peer's steps

# That move, in steps of 5 ms: walls shaken across by 0.5 g at 2 Hz, of 105, 1012, 3220 and 9632 bricks; others.
SHAKEN = [(shaken_wall(10, 10, "y", 0.05), 60), (shaken_wall(40, 25, "y", 0.05), 60),
          (shaken_wall(80, 40, "y", 0.05), 40), (shaken_wall(150, 64, "y", 0.05), 500)]  # with CPU s at most
OTHERS = [(pile(10, 10, 0.5), 40), (hull_pile(10, 10, 1), 60), (hull_pile(22, 21, 1), 120), (slope(22, 0.1), 40),
          (jointed_slope(20, 10, 5, 0.1), 60), (jointed_slope(40, 20, 5, 0.1), 90), (jointed_slope(50, 40, 5, 0.05), 600),
          (vault(31, 20, 5, 0.3), 60), (struck_wall(40, 25, 0.05), 40), (struck_wall(150, 67, 0.05), 500)]
MOVING_CODES = ("quoin", "bullet:50")
QUICK_BLOCKS = 1100  # at most


def rows_of(*words, may_break=False):
    """What a run prints; of a peer that breaks down what it printed before."""
    done = subprocess.run([str(word) for word in words], check=not may_break, stdout=subprocess.PIPE, text=True)
    print(*words[1:], done.stdout.splitlines()[-1:], file=sys.stderr, flush=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


def rest(given):
    program = given.bench / "bench_large"
    result = {"rest": [], "peers": []}
    for columns, rows, threads, codes in WALLS[:-1] if given.quick else WALLS:
        for count in threads:
            result["rest"].append(rows_of(program, "rest", columns, rows, "automatic", REST_STEPS, count))
        for code in codes:
            result["peers"].append(rows_of(program, "peer", columns, rows, code, PEER_STEPS,
                                           QUICK_LIMIT if given.quick else LIMIT, may_break=True))
    return result


def beside(program, document, limit, blocks):
    """Rows of bench_moving: quoin's, and the others' of as many steps where quoin has ended one."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        scene = pathlib.Path(folder) / "scene.json"
        for code in MOVING_CODES:
            scene.write_text(json.dumps(document), encoding="utf-8")
            rows += rows_of(program, scene, code, "--limit", limit, may_break=code != "quoin")
            document = {**document, "end_time": rows[0]["time"] or document["end_time"]}
    return [{"blocks": blocks, **row} for row in rows]


def moving(given, before):
    """Rows with the number of blocks that move; those of scenes that are not asked for as they were."""
    result = {}
    for name, scenes in (("shaken", SHAKEN), ("moving", OTHERS)):
        result[name] = []
        for document, limit in scenes:
            blocks = sum(block["kind"] == "rigid" for block in document["blocks"])
            if not re.search(given.scenes, document["title"]):
                result[name] += [row for row in before.get(name, []) if row["scene"] == document["title"]]
            elif not given.quick or blocks <= QUICK_BLOCKS:
                result[name] += beside(given.bench / "bench_moving", document, limit, blocks)
    return result


def measure(given):
    part = given.part or ("moving" if given.scenes else None)
    result = json.loads(given.out.read_text(encoding="utf-8")) if part and given.out.exists() else {}
    for name in (part,) if part else ("rest", "moving"):
        result.update(rest(given) if name == "rest" else moving(given, result))
        given.out.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bench", type=pathlib.Path, required=True, help="folder of bench_large and bench_moving")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--part", choices=("rest", "moving"), help="this one alone")
    parser.add_argument("--scenes", default="", help="of moving: a pattern of their titles")
    measure(parser.parse_args())


if __name__ == "__main__":
    main()
