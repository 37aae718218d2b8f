#!/usr/bin/env python3
"""Checks answers to the pairs of tests/pairs without quoin: numpy and fractions alone.

judge_pairs.py PAIRS.jsonl ANSWERS.jsonl [--error SHARE]

ANSWERS has one JSON object a line: "id", "gap" (m; negative: overlap), and where there are any
"normal" (unit, from A to B), "point_a", "point_b" (m) and "area" (m2); `quoin contact --pairs
PAIRS.jsonl` prints such lines. --error is what the library promises, as a share of the larger
diameter (default: 0).

With D the larger diameter a gap may be off by 1e-12 of itself, 16 eps D, 4 eps of the largest
coordinate and the promised error; places and areas by what follows from that. The distance along
the answer's normal is formed in fractions, without rounding. Exit code 1: an answer is wrong or
missing.
"""
import argparse
import collections
import json
import sys
from fractions import Fraction

import numpy as np

EPS = np.finfo(float).eps


def exact_points(solid):
    """The places t + A X as fractions."""
    if isinstance(solid, list):
        return [[Fraction(c) for c in point] for point in solid]
    place = [Fraction(number) for number in solid["placement"]]
    shift, rows = place[:3], [place[3:6], place[6:9], place[9:12]]
    points = [[Fraction(c) for c in point] for point in solid["points"]]
    return [[t + sum(r * x for r, x in zip(row, point)) for t, row in zip(shift, rows)] for point in points]


def dot(u, v):
    return sum(a * b for a, b in zip(u, v))


def diameter(points):
    places = np.array([[float(c - d) for c, d in zip(point, points[0])] for point in points])
    return max(np.linalg.norm(places - place, axis=1).max() for place in places)


def distance_to_hull(points, place):
    """Of a place from the convex hull of points, m, at least: all of them lie beyond a plane so far from it, which
    Wolfe's algorithm finds."""
    offsets = np.array([[float(c - Fraction(p)) for c, p in zip(point, place)] for point in points])
    size = np.linalg.norm(offsets, axis=1).max()
    chosen, weights = [int(np.argmin(np.linalg.norm(offsets, axis=1)))], np.array([1.0])
    for _ in range(1000):
        nearest = weights @ offsets[chosen]
        new = int(np.argmin(offsets @ nearest))
        if nearest @ nearest - offsets[new] @ nearest <= 8 * EPS * size * np.linalg.norm(nearest) or new in chosen:
            break
        chosen, weights = chosen + [new], np.append(weights, 0.0)
        while True:
            corral = offsets[chosen]
            system = np.ones((len(chosen) + 1, len(chosen) + 1))
            system[0, 0], system[1:, 1:] = 0.0, corral @ corral.T
            affine = np.linalg.lstsq(system, np.append(1.0, np.zeros(len(chosen))), rcond=None)[0][1:]
            if (affine > 0).all():
                weights = affine
                break
            falling = affine <= 0
            steps = weights[falling] / np.maximum(weights[falling] - affine[falling], 1e-300)
            weights = weights + steps.min() * (affine - weights)
            keep = weights > 1e-14
            chosen, weights = [c for c, k in zip(chosen, keep) if k], weights[keep] / weights[keep].sum()
            if len(chosen) == 1:
                weights = np.array([1.0])
                break
    nearest = weights @ offsets[chosen]
    length = np.linalg.norm(nearest)
    return max(0.0, float((offsets @ nearest).min() / length)) if length > 0 else 0.0


def faults(pair, answer, promised):
    a, b = exact_points(pair["a"]), exact_points(pair["b"])
    larger = max(diameter(a), diameter(b))
    coordinate = float(max(abs(c) for point in a + b for c in point))
    exact = pair["exact"]
    allowed = 1e-12 * abs(exact["gap"]) + (16 * EPS + promised) * larger + 4 * EPS * coordinate
    if not np.isfinite(answer["gap"]):
        return ["not finite"]
    if abs(Fraction(answer["gap"]) - Fraction(exact["gap"])) > allowed:
        return ["gap" if (answer["gap"] > 0) == (exact["gap"] > 0) else "sign"]
    found = []
    if "normal" in answer:
        normal = [Fraction(c) for c in answer["normal"]]
        length = float(np.linalg.norm(answer["normal"]))
        apart = float(min(dot(normal, q) for q in b) - max(dot(normal, p) for p in a))
        if not abs(length - 1) <= 1e-12 + promised or apart / length < exact["gap"] - 2 * allowed:
            found.append("normal")
    place = allowed + 8 * EPS * coordinate
    for name, points in (("point_a", a), ("point_b", b)):
        if name in answer and distance_to_hull(points, answer[name]) > 2 * place:
            found.append("witness")
    if "area" in answer and "area" in exact and abs(answer["area"] - exact["area"]) > 8 * larger * 2 * place:
        found.append("area")
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pairs")
    parser.add_argument("answers")
    parser.add_argument("--error", type=float, default=0.0, help="promised, as a share of the larger diameter")
    words = parser.parse_args()
    with open(words.answers, encoding="utf-8") as file:
        answers = {answer["id"]: answer for answer in map(json.loads, file) if "gap" in answer}
    count, kinds = 0, collections.Counter()
    with open(words.pairs, encoding="utf-8") as file:
        for pair in map(json.loads, file):
            count += 1
            answer = answers.get(pair["id"])
            for kind in faults(pair, answer, words.error) if answer else ["no answer"]:
                kinds[kind] += 1
                print(f"{pair['id']}: {kind}")
    print(f"{count} pairs, {sum(kinds.values())} faults" + "".join(f", {n} {k}" for k, n in sorted(kinds.items())))
    return 1 if kinds else 0


if __name__ == "__main__":
    sys.exit(main())
