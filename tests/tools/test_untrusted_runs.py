"""What a run must not be silent about: energy, overlaps without contacts, static stages that still seek."""
import json
import math
import sys
import unittest

from folder_test import FolderTest



def box(name, low, high, kind="rigid", **more):
    return {"name": name, "kind": kind, "material": "m", "shape": {"type": "box", "min": low, "max": high}, **more}


def scene(blocks, joint, **more):
    return {"materials": {"m": {"density": 2000}}, "joint": joint, "blocks": blocks, "time_step": 1e-3,
            "monitors": [{"name": blocks[-1]["name"], "block": blocks[-1]["name"]}], **more}


class UntrustedRuns(FolderTest):
    def run_scene(self, content):
        done = self.quoin("run", self.written(content), "--json")
        return done.returncode, json.loads(done.stdout)

    def test_bars_that_jam_make_no_energy(self):
        """One bar swings against another; hinges half a bar apart from their faces hold both when they are flush."""
        for restitution in (0, 0.6):
            turned = {"rotation": {"axis": [0, 1, 0], "angle_deg": 55}, "about": [-0.06, 0, 0]}
            blocks = [box("a", [-0.12, -0.2, -1.4], [0, 0.2, 0], pose=turned), box("b", [0, -0.2, -1.1], [0.12, 0.2, 0])]
            points = [{"block": name, "point": [x, y, 0]} for name, x in (("a", -0.06), ("b", 0.06)) for y in (-0.2, 0.2)]
            code, summary = self.run_scene(scene(blocks, {"friction_angle_deg": 0, "restitution": restitution},
                                                 fixed_points=points, end_time=0.8))
            energy = summary["energy"]
            self.assertEqual(code, 0, summary["message"])
            self.assertEqual(energy["work"], 0)
            self.assertLessEqual(energy["kinetic"] + energy["potential"], 1e-6 * energy["scale"])
            self.assertLessEqual(energy["growth"], 1e-6 * energy["scale"])

    def test_a_plate_driven_through_a_fixed_block(self):
        plate = box("plate", [-1, -1, 0.05], [1, 1, 0.5], "prescribed", motion={"velocity": [0, 0, -2]})
        ground = box("ground", [-2, -2, -1], [2, 2, 0], "fixed")
        still = box("still", [-1, -1, -0.5], [1, 1, 0.5], "prescribed", motion={"velocity": [1, 0, 0]})
        code, summary = self.run_scene(scene([ground, plate], {"friction_angle_deg": 30}, end_time=0.2))
        self.assertEqual((code, summary["status"]), (1, "not_trusted"))
        self.assertEqual([(f["flag"], f["blocks"]) for f in summary["flags"]], [("overlap", ["ground", "plate"])])
        code, summary = self.run_scene(scene([ground, still], {"friction_angle_deg": 30}, end_time=0.2))
        self.assertEqual((code, summary["flags"]), (0, []))

    def test_turns_too_large_for_a_step(self):
        """2.5 rad each, where sub-steps are not allowed (cases/flags_of_motion.json: where they are)."""
        block = box("b", [0, 0, 0], [1, 1, 1], angular_velocity=[0, 0, 50])
        code, summary = self.run_scene({**scene([block], {"friction_angle_deg": 0}, gravity=[0, 0, 0], end_time=1),
                                        "time_step": 0.05, "smallest_time_step": 0.05})
        self.assertEqual((code, summary["status"]), (1, "not_trusted"))
        self.assertEqual([f["flag"] for f in summary["flags"]], ["turn"])

    def test_a_static_stage_that_still_seeks(self):
        tilted = [9.81 * math.sin(math.radians(20)), 0, -9.81 * math.cos(math.radians(20))]
        blocks = [box("ground", [-5, -5, -1], [5, 5, 0], "fixed"), box("b", [0, 0, 0], [1, 1, 1])]
        stop = box("stop", [1.05, -5, 0], [2, 5, 1], "fixed")  # so near that it could hold the block
        for more, status in (([], "mechanism"), ([stop], "not_at_rest")):
            code, summary = self.run_scene(scene(blocks + more, {"friction_angle_deg": 15}, gravity=tilted,
                                                 stages=[{"analysis": "static", "steps": 3}]))
            self.assertEqual((code, summary["status"]), (1, status))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
