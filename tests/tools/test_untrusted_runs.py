"""What a run must not be silent about: energy, overlaps without contacts, static stages that still seek."""
import math
import sys
import unittest

from folder_test import FolderTest, block, flags_of


def scene(blocks, joint, **more):
    return {"materials": {"stone": {"density": 2000}}, "joint": joint, "blocks": blocks, "time_step": 1e-3, **more}


class UntrustedRuns(FolderTest):
    def test_bars_that_jam_make_no_energy(self):
        """One bar swings against another; hinges half a bar apart from their faces hold both when they are flush."""
        for restitution in (0, 0.6):
            turned = {"rotation": {"axis": [0, 1, 0], "angle_deg": 55}, "about": [-0.06, 0, 0]}
            blocks = [block("a", [-0.12, -0.2, -1.4], [0, 0.2, 0], pose=turned), block("b", [0, -0.2, -1.1], [0.12, 0.2, 0])]
            points = [{"block": name, "point": [x, y, 0]} for name, x in (("a", -0.06), ("b", 0.06)) for y in (-0.2, 0.2)]
            energy = self.run_scene(scene(blocks, {"friction_angle_deg": 0, "restitution": restitution},
                                          fixed_points=points, end_time=0.8))["energy"]
            self.assertEqual(energy["work"], 0)
            self.assertLessEqual(energy["kinetic"] + energy["potential"], 1e-6 * energy["scale"])
            self.assertLessEqual(energy["growth"], 1e-6 * energy["scale"])

    def test_a_plate_driven_through_a_fixed_block(self):
        plate = block("plate", [-1, -1, 0.05], [1, 1, 0.5], "prescribed", motion={"velocity": [0, 0, -2]})
        ground = block("ground", [-2, -2, -1], [2, 2, 0], "fixed")
        still = block("still", [-1, -1, -0.5], [1, 1, 0.5], "prescribed", motion={"velocity": [1, 0, 0]})
        summary = self.run_scene(scene([ground, plate], {"friction_angle_deg": 30}, end_time=0.2), code=1)
        self.assertEqual(summary["status"], "not_trusted")
        self.assertEqual([(f["flag"], f["blocks"]) for f in summary["flags"]], [("overlap", ["ground", "plate"])])
        self.assertEqual(self.run_scene(scene([ground, still], {"friction_angle_deg": 30}, end_time=0.2))["flags"], [])

    def test_a_sheet_driven_through_another(self):
        sheet = block("sheet", [-1, -1, 0.005], [1, 1, 0.007], "prescribed", motion={"velocity": [0, 0, -0.2]})
        ground = block("ground", [-2, -2, -0.002], [2, 2, 0], "fixed")
        summary = self.run_scene(scene([ground, sheet], {"friction_angle_deg": 30}, end_time=0.1), code=1)
        self.assertEqual([f["flag"] for f in summary["flags"]], ["overlap"])

    def test_a_plate_that_jumps_a_fixed_block(self):
        """In one step of 2 m; and a neighbour beside which another slides."""
        plate = block("plate", [-1, -1, 0.5], [1, 1, 0.6], "prescribed", motion={"velocity": [0, 0, -2]})
        ground = block("ground", [-2, -2, -1], [2, 2, 0], "fixed")
        beside = block("beside", [2, -2, -1], [4, 2, 0], "prescribed", motion={"velocity": [0, 2, 0]})
        summary = self.run_scene({**scene([ground, plate, beside], {"friction_angle_deg": 30}, end_time=2), "time_step": 1},
                                 code=1)
        self.assertEqual([(f["flag"], f["blocks"], f["steps"]) for f in summary["flags"]],
                         [("overlap", ["ground", "plate"], 1)])

    def test_a_bar_turned_into_a_fixed_block(self):
        bar = block("bar", [-1, -0.2, 0.4], [1, 0.2, 0.6], "prescribed",
                    motion={"centre": [0, 0, 0.5], "rotation": {"formula": ["0", "3*t", "0"]}})
        ground = block("ground", [-3, -3, -1], [3, 3, 0], "fixed")
        for end_time, code in ((0.1, 0), (0.2, 1)):
            self.run_scene(scene([ground, bar], {"friction_angle_deg": 30}, end_time=end_time), code=code)

    def test_an_impact_that_leaves_no_energy(self):
        """What its ledger leaves open is measured by what was lost."""
        plate = block("plate", [-1, -1, -0.5], [1, 1, 0], "fixed")
        shot = block("shot", [-0.037, -0.029, 0.2], [0.063, 0.071, 0.3], velocity=[0, 0, -100])
        summary = self.run_scene({**scene([plate, shot], {"friction_angle_deg": 30}, gravity=[0, 0, 0], end_time=0.008),
                                  "time_step": 0.002})
        self.assertEqual(summary["flags"], [])

    def test_turns_too_large_for_a_step(self):
        """2.5 rad each, where sub-steps are not allowed (cases/flags_of_motion.json: where they are)."""
        spun = block("b", [0, 0, 0], [1, 1, 1], angular_velocity=[0, 0, 50])
        summary = self.run_scene({**scene([spun], {"friction_angle_deg": 0}, gravity=[0, 0, 0], end_time=1),
                                  "time_step": 0.05, "smallest_time_step": 0.05}, code=1)
        self.assertEqual((summary["status"], flags_of(summary)), ("not_trusted", [("turn", True)]))

    def test_a_static_stage_that_still_seeks(self):
        tilted = [9.81 * math.sin(math.radians(20)), 0, -9.81 * math.cos(math.radians(20))]
        blocks = [block("ground", [-5, -5, -1], [5, 5, 0], "fixed"), block("b", [0, 0, 0], [1, 1, 1])]
        stop = block("stop", [1.05, -5, 0], [2, 5, 1], "fixed")  # so near that it could hold the block
        for more, status in (([], "mechanism"), ([stop], "not_at_rest")):
            summary = self.run_scene(scene(blocks + more, {"friction_angle_deg": 15}, gravity=tilted,
                                           stages=[{"analysis": "static", "steps": 3}]), code=1)
            self.assertEqual(summary["status"], status)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
