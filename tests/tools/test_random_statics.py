"""Static stages of random towers and walls against a linear program that shares no code with quoin."""
import json
import math
import random
import sys
import unittest

import numpy as np
from scipy.optimize import linprog

from folder_test import FolderTest

SIDES = 16  # of the pyramid inside the friction cone; the one around it is wider by 1 / cos(pi / SIDES)


def structure(seed):
    """Boxes (low, high), the first one fixed, and a friction coefficient."""
    dice = random.Random(seed)
    boxes = [((-20, -20, -1), (20, 20, 0))]
    low = 0.0
    for _ in range(dice.randint(2, 5)):
        high, left = low + dice.uniform(0.2, 0.6), dice.uniform(-0.15, 0.15)
        depth = dice.uniform(0.4, 0.8)
        for _ in range(dice.randint(1, 3) if seed % 2 else 1):
            right = left + dice.uniform(0.5, 1.0)
            boxes.append(((left, -depth / 2, low), (right, depth / 2, high)))
            left = right
        low = high
    return boxes, dice.uniform(0.3, 0.9)


def contacts(boxes):
    """a, b, axis of the normal from a to b, corners of what they share."""
    for b, (low_b, high_b) in enumerate(boxes):
        for a, (low_a, high_a) in enumerate(boxes):
            for axis in range(3):
                if abs(high_a[axis] - low_b[axis]) > 1e-12:
                    continue
                ends = [[max(low_a[i], low_b[i]), min(high_a[i], high_b[i])] for i in range(3)]
                ends[axis] = [low_b[axis]]
                if all(len(e) == 1 or e[1] - e[0] > 1e-12 for e in ends):
                    yield a, b, axis, [np.array([x, y, z]) for x in ends[0] for y in ends[1] for z in ends[2]]


def limit(boxes, friction):
    """Largest weight along x, by the vertical one, that forces in the pyramid bear; None: not even 0."""
    columns, rows = [], 6 * (len(boxes) - 1)
    middle = [(np.array(low) + np.array(high)) / 2 for low, high in boxes]
    for a, b, axis, corners in contacts(boxes):
        normal = np.eye(3)[axis]
        first, second = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
        for corner in corners:
            for side in range(SIDES):
                angle = 2 * math.pi * side / SIDES
                force = normal + friction * (math.cos(angle) * first + math.sin(angle) * second)
                column = np.zeros(rows)
                for block, sign in ((a, -1), (b, 1)):
                    if block:
                        column[6 * block - 6:6 * block] += sign * np.concatenate([force, np.cross(corner - middle[block], force)])
                columns.append(column)
    weights = np.zeros(rows)
    pushes = np.zeros(rows)
    for block, (low, high) in enumerate(boxes[1:]):
        weights[6 * block + 2] = -np.prod(np.array(high) - np.array(low))
        pushes[6 * block] = -weights[6 * block + 2]
    matrix = np.column_stack(columns + [pushes])
    found = linprog(-np.eye(len(columns) + 1)[-1], A_eq=matrix, b_eq=-weights, method="highs")
    return found.x[-1] if found.status == 0 else None


class RandomStatics(FolderTest):
    def run_at(self, boxes, friction, push):
        blocks = [{"kind": "rigid" if i else "fixed", "material": "m", "shape": {"type": "box", "min": low, "max": high}}
                  for i, (low, high) in enumerate(boxes)]
        return json.loads(self.quoin("run", self.written(
            {"materials": {"m": {"density": 2000}}, "gravity": [10 * push, 0, -10], "blocks": blocks,
             "joint": {"friction_angle_deg": math.degrees(math.atan(friction))}, "stages": [{"analysis": "static"}]}),
            "--json").stdout)

    def test_towers_and_walls(self):
        seen = {"rest": 0, "mechanism": 0, "admissible": 0}
        unproved = 0  # found by steps: a contact that a tenth of both blocks' sizes closes may hold
        for seed in range(int(sys.argv[3]) if len(sys.argv) > 3 else 14):
            boxes, friction = structure(seed)
            inside = limit(boxes, friction)
            if inside is None:
                summary = self.run_at(boxes, friction * math.cos(math.pi / SIDES), 0)  # the pyramid holds the cone
                self.assertNotEqual(summary["stages"][0]["verdict"], "rest", seed)
                continue
            around = limit(boxes, friction / math.cos(math.pi / SIDES))
            for push in (0.5 * inside, 0.98 * inside, 1.02 * around, 1.5 * around):
                summary = self.run_at(boxes, friction, push)
                stage = summary["stages"][0]
                seen[stage["verdict"]] += 1
                with self.subTest(seed=seed, push=push / inside, message=summary["message"]):
                    self.assertIn(stage["verdict"], ("rest", "mechanism", "admissible"))
                    if push > inside:
                        self.assertEqual(stage["verdict"], "mechanism")
                        self.assertEqual(stage["steps"] == 0, summary["proof"] is not None)
                        unproved += summary["proof"] is None
                        self.assertLessEqual((summary["proof"] or {"factorizations": 0})["factorizations"], 40)
                    else:
                        self.assertIsNone(summary["proof"])
        self.assertGreater(min(seen["rest"], seen["mechanism"]), 10)
        self.assertLessEqual(unproved, 0.03 * seen["mechanism"])
        print(seen, "unproved:", unproved)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
