"""`quoin import`: files of other programs as scenes; blocks of several parts; `join`.

usage: test_import_command.py QUOIN SOURCE_DIR
"""
import json
import sys
import unittest

from folder_test import FolderTest, block, box

CORNERS = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)]  # an L in x, z


def ell(x=0.0):
    """OBJ of the L swept along y by 1."""
    lines = ["o ell"] + [f"v {x + a} {y} {b}" for y in (0, 1) for a, b in CORNERS]
    lines += ["f 1 2 3 4 5 6", "f 12 11 10 9 8 7"]
    lines += [f"f {(i + 1) % 6 + 1} {i + 1} {i + 7} {(i + 1) % 6 + 7}" for i in range(6)]
    return "\n".join(lines) + "\n"


FLOOR = block("floor", [-5, -5, -1], [5, 5, 0], "fixed")


class Import(FolderTest):
    def results(self, scene):
        return self.run_scene(scene), self.rows("blocks.csv")

    def scene_with(self, blocks, **more):
        return {"materials": {"stone": {"density": 2000}}, "joint": {"friction_angle_deg": 30},
                "gravity": [0, 0, -10], "stages": [{"analysis": "static"}], "blocks": [FLOOR, *blocks], **more}

    def test_an_ell_is_split_and_stands(self):
        (self.folder / "ell.obj").write_text(ell())
        self.quoin("split", "ell.obj", "--density", 2000, "--out", "split.json", code=0,
                   says="1 blocks (0 fixed; 1 of 2 convex parts), 4 m3\n")
        scene = json.loads((self.folder / "split.json").read_text())
        self.assertEqual(len(scene["blocks"][0]["parts"]), 2)
        scene = self.scene_with([{**scene["blocks"][0], "material": "stone"}])
        told, rows = self.results(scene)
        self.assertAlmostEqual(told["base_reaction"][2], -80000, delta=1e-3)
        self.assertAlmostEqual(float(rows[1]["volume"]), 4, delta=1e-12)
        self.assertAlmostEqual(float(rows[1]["x"]), 0.75, delta=1e-9)
        self.assertEqual(self.told("check", "scene.json")["without_support"], [])
        self.quoin("import", "ell.obj", "--out", "split.json", code=1)  # it is there

    def test_parts_join_and_a_split_file_are_one_block(self):
        (self.folder / "ell.obj").write_text(ell())
        low, high = box([0, 0, 0], [2, 1, 1]), box([0, 0, 1], [1, 1, 3])
        stone = {"kind": "rigid", "material": "stone"}
        ways = {"parts": self.scene_with([{"name": "ell", **stone, "parts": [low, high]}]),
                "join": self.scene_with([{"name": "a1", **stone, "shape": low}, {"name": "b", **stone, "shape": high}],
                                        join=[{"blocks": ["a*", "b"], "name": "ell"}]),
                "file": self.scene_with([{"file": "ell.obj", "split": True, **stone}])}
        found = {name: self.results(scene) for name, scene in ways.items()}
        for name, (told, rows) in found.items():
            self.assertEqual([row["name"] for row in rows], ["floor", "ell"], name)
            for key in ("x", "z", "mass"):
                self.assertAlmostEqual(float(rows[1][key]), float(found["parts"][1][1][key]), delta=1e-9, msg=name)
            self.assertAlmostEqual(told["base_reaction"][2], -80000, delta=1e-3)

    def test_parts_that_overlap_are_told(self):
        for high, said in ((1, 0), (0.9, 1)):
            stone = {"name": "tee", "kind": "rigid", "material": "stone",
                     "parts": [box([0, 0, 0], [2, 1, 1]), box([0.5, 0, high], [1.5, 1, 2])]}
            for command in ("check", "run"):
                done = self.quoin(command, self.written(self.scene_with([stone])))
                self.assertEqual((done.stdout + done.stderr).count(
                    'block "tee": its parts 0 and 1 overlap by 0.1 m, more than 1e-3 of the smaller one'), said)

    def test_a_brick_file_becomes_a_scene(self):
        cube = [f"{x},{y},{z}" for x in (0, 1) for y in (0, 1) for z in (0, 1)]
        high = [f"{x},{y},{z}" for x in (0, 1) for y in (1, 2) for z in (0, 1)]
        (self.folder / "bricks.txt").write_text(
            "0,1,1,1,1800, 0,0,0, 0,0,0, " + ", ".join(cube) + "\n1,0,1,1,1700, 0,0,0, 0,0,0, " + ", ".join(high) + "\n")
        self.quoin("import", "bricks.txt", "--format", "chrono", "--out", "bricks.json", code=0)
        self.assertAlmostEqual(self.told("run", "bricks.json")["base_reaction"][1], -1700 * 9.81, delta=1e-6)


unittest.main(argv=[sys.argv[0]], verbosity=2)
