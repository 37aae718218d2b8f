"""`quoin cut`: a scene with `cut` and the scene that is written of it run alike; OBJ names joints.

usage: test_cut_command.py QUOIN SOURCE_DIR
"""
import sys
import unittest

from folder_test import FolderTest, block, box


def column(**changes):
    return {"gravity": [0, 0, -10], "materials": {"stone": {"density": 2000}},
            "joint": {"friction_angle_deg": 30}, "stages": [{"analysis": "static"}],
            "blocks": [block("ground", [-1, -1, -1], [2, 2, 0], "fixed")],
            "cut": {"name": "drum", "block": {"kind": "rigid", "material": "stone"},
                    "body": box([0, 0, 0], [1, 1, 2]),
                    "cuts": [{"type": "joint_set", "name": "bed", "dip_deg": 0,
                              "origin": [0, 0, 0], "spacing": 0.5}], **changes}}


class Cut(FolderTest):
    def forces(self, out):
        return [(row["name_a"], row["name_b"], row["normal_force"]) for row in self.rows("contacts.csv", out)]

    def test_a_column(self):
        scene = self.written(column())
        told = self.told("cut", scene)
        self.assertEqual((told["blocks"], told["volume"]), (4, 2))
        self.assertLess(abs(told["closure"]), 1e-12)
        self.told("cut", scene, "--out", "blocks.json")
        for source in ("scene", "blocks"):
            self.told("run", f"{source}.json", "--out", source)
        self.assertEqual(self.forces("scene"), self.forces("blocks"))
        bottom = sum(float(f) for a, b, f in self.forces("scene") if "ground" in (a, b))
        self.assertAlmostEqual(bottom, 40000, delta=1e-6)  # N
        self.told("cut", scene, "--out", "blocks.obj")
        lines = (self.folder / "blocks.obj").read_text(encoding="utf-8").splitlines()
        self.assertEqual(sum(line.startswith("o ") for line in lines), 4)
        self.assertEqual(lines.count("usemtl bed"), 6)  # two faces of each of three planes


unittest.main(argv=[sys.argv[0]], verbosity=2)
