"""Scenes of bench/moving_scenes.py that bench/large.py runs: blocks lie as they should, and move.

usage: test_moving_scenes.py QUOIN SOURCE_DIR
"""
import pathlib
import sys
import unittest

from folder_test import FolderTest

SOURCE = pathlib.Path(sys.argv[2])
sys.path.insert(0, str(SOURCE / "bench"))
from moving_scenes import hull_pile, jointed_slope, pile, struck_wall, vault  # noqa: E402


class MovingScenes(FolderTest):
    def moves(self, document, blocks, loose=(), growth=1e-9):
        """`blocks`: that move; `loose`: that touch nothing that holds them. Displacements by name, m."""
        self.assertEqual(sum(block["kind"] == "rigid" for block in document["blocks"]), blocks)
        report = self.told("check", self.written(document))
        self.assertEqual(report["contacts"]["overlaps"], [])
        self.assertEqual(sorted(report["without_support"]), sorted(loose))
        summary = self.run_scene(document)
        self.assertEqual((summary["status"], summary["unconverged_steps"]), ("completed", 0))
        self.assertLess(summary["largest_overlap"], 1e-6)
        self.assertLess(summary["energy"]["growth"], growth * summary["energy"]["scale"])
        return {row["name"]: [float(row[key]) for key in ("ux", "uy", "uz")] for row in self.rows("blocks.csv")}

    def test_a_vault_falls_where_its_pier_is_gone(self):
        moved = self.moves(vault(9, 6, 3, 0.05), 5 * 6 + 4 * 7)
        self.assertLess(moved["stone0_5"][2], -1e-3)
        self.assertGreater(moved["stone0_0"][2], -1e-6)  # on its pier

    def test_a_jointed_slope_slides_as_one_block(self):
        moved = self.moves(jointed_slope(4, 2, 3, 0.05), 2 * (4 + 5 + 4))
        way = 0.5 * 9.81 * (1 - 0.46630765815499864) / 2 * 0.05 ** 2  # along x and down: sin and cos of 45 degrees
        for name, (x, _, z) in moved.items():
            if name != "bed":
                self.assertAlmostEqual(x / way, 1, places=6)
                self.assertAlmostEqual(z / way, -1, places=6)

    def test_open_close_solves_the_first_step_of_a_slope_without_its_toe(self):
        # Were forces shared out between redundant contacts to all digits, proximal Newton would take it over.
        self.quoin("make", "jointed-slope", "--end-time", 0.02, "--out", "slope.json", code=0)
        self.assertEqual(self.told("run", "slope.json")["proximal_newton_attempts"], 0)

    def test_hulls_fall_apart_from_each_other(self):
        document = hull_pile(2, 2, 0.05)
        self.moves(document, 8, [f"box{i}" for i in range(8)])

    def test_piles_with_steep_friction_gain_nothing(self):
        for degrees in (75, 80, 85):  # with contacts that yield 8e-6, 2e-6 and 3e-4 of an island's energy
            document = {**pile(2, 3, 0.7), "time_step": 0.005}
            document["joint"]["friction_angle_deg"] = degrees
            with self.subTest(degrees=degrees):
                self.moves(document, 12, [f"box{i}" for i in range(12)], growth=1e-7)
                self.assertEqual(self.summary()["flags"], [])

    def test_a_cube_hits_a_wall(self):
        moved = self.moves(struck_wall(4, 5, 0.02), 23, ["cube"])
        self.assertGreater(moved["brick2_2"][1], 1e-3)


unittest.main(argv=[sys.argv[0]], verbosity=2)
