"""Static stages that go on after a mechanism, give forces of removed blocks back, or let loads grow.

usage: test_staged_work.py QUOIN SOURCE_DIR
"""
import sys
import unittest

from folder_test import FolderTest, block


def scene(blocks, stages, **more):
    return {"materials": {"stone": {"density": 1000, "young": 1e9}}, "joint": {"friction_angle_deg": 30},
            "gravity": [0, 0, -10], "time_step": 0.01, "blocks": blocks, "stages": stages, "paraview": False, **more}


GROUND = block("ground", [-9, -9, -1], [9, 9, 0], "fixed")


class StagedWork(FolderTest):
    def roof(self, on_mechanism, *more):
        """A stone between a wall and nothing, on a prop that is removed; another one on the ground."""
        blocks = [GROUND, block("prop", [0, 0, 0], [1, 1, 1]), block("roof", [0, 0, 1], [1, 1, 2]),
                  block("top", [0, 0, 2], [1, 1, 3]), block("firm", [3, 0, 0], [4, 1, 1])]
        return scene(blocks, [{"analysis": "static"}, {"analysis": "static", "name": "round", "remove": "prop",
                                                       **({"on_mechanism": on_mechanism} if on_mechanism else {})}, *more],
                     monitors=[{"name": "ground", "contact": ["*", "ground"]}, {"name": "roof", "block": "roof"}])

    def test_a_mechanism_ends_the_run_unless_told_else(self):
        told = self.run_scene(self.roof(None), code=1)
        self.assertEqual(told["status"], "mechanism")

    def test_what_has_come_loose_is_taken_away(self):
        told = self.run_scene(self.roof("remove", {"analysis": "static", "name": "after"}))
        self.assertEqual(sorted(told["stages"][1]["removed"]), ["roof", "top"])
        self.assertEqual([s["verdict"] for s in told["stages"]], ["rest"] * 3)
        self.assertAlmostEqual(told["monitors"]["ground"]["force"][2], -10000, delta=1e-3)
        self.assertEqual((told["blocks"]["rigid"], told["blocks"]["absent"]), (1, 3))
        self.assertAlmostEqual(told["blocks"]["weight"][2], -10000, delta=1e-3)

    def test_what_wets_and_ties_what_is_gone_goes_with_it(self):
        bears = {"water": [{"pressure": 100, "on": "joints", "blocks": ["roof", "top"]}, {"level": 9, "blocks": "top"}],
                 "ties": [{"from": {"block": "top", "point": [1, 0.5, 2.5]}, "stiffness": 1,
                           "to": {"block": "firm", "point": [3, 0.5, 0.5]}}]}
        told = self.run_scene({**self.roof("remove", {"analysis": "dynamic", "duration": 0.1}), **bears})
        self.assertEqual(sorted(told["stages"][1]["removed"]), ["roof", "top"])
        self.assertAlmostEqual(told["monitors"]["ground"]["force"][2], -10000, delta=1e-3)

    def test_the_water_of_a_joint_goes_with_the_block_behind_it(self):
        blocks = [GROUND, block("a", [0, 0, 0], [1, 1, 1]), block("b", [1, 0, 0], [2, 1, 1])]
        for water, top in (({"on": "joints", "between": ["a", "b"]}, 0), ({"on": "free", "blocks": "a"}, 2000)):
            told = self.run_scene(scene(blocks, [{"analysis": "static"}, {"analysis": "static", "remove": "b"}],
                                      water=[{"pressure": 2000, **water}], monitors=[{"name": "ground", "contact": ["*", "ground"]}]))
            for found, right in zip(told["monitors"]["ground"]["force"], (0, 0, -10000 - top)):
                self.assertAlmostEqual(found, right, delta=1e-3)

    def test_what_has_come_loose_goes_on_falling(self):
        told = self.run_scene(self.roof("continue", {"analysis": "dynamic", "duration": 0.2}))
        self.assertEqual(sorted(told["stages"][1]["loose"]), ["roof", "top"])
        self.assertEqual(told["stages"][1]["verdict"], "mechanism")
        self.assertEqual(told["status"], "completed")
        self.assertAlmostEqual(told["monitors"]["roof"]["velocity"][2], -2, delta=1e-6)

    def test_forces_are_given_back_in_parts(self):
        blocks = [GROUND, *(block(f"prop{x}", [x, 0, 0], [x + 1, 1, 1]) for x in (0, 2, 4)),
                  block("beam", [0, 0, 1], [5, 1, 2])]
        monitors = [{"name": "ends", "contact": [["prop0", "prop4"], "beam"]}]
        told = self.run_scene(scene(blocks, [{"analysis": "static"},
                                           {"analysis": "static", "remove": "prop2", "relax": 4}], monitors=monitors))
        self.assertGreaterEqual(told["stages"][1]["steps"], 4)
        self.assertAlmostEqual(told["monitors"]["ends"]["force"][2], 50000, delta=1e-3)
        ends = [float(row["ends.fz"]) for row in self.rows("history.csv")]
        ends = ends[-told["stages"][1]["steps"] - 1:]  # from the end of the first stage on
        given, middle = [f - ends[0] for f in ends], 50000 - ends[0]
        for part in (0.25, 0.5, 0.75, 1.0):
            self.assertTrue(any(abs(g - part * middle) < 1e-3 for g in given), (part, given))

    def test_loads_grow_until_a_block_slides(self):
        load = {"type": "point", "block": "cube", "point": [0.5, 0.5, 0.001], "force": [1000, 0, 0]}
        told = self.run_scene(scene([GROUND, block("cube", [0, 0, 0], [1, 1, 1])],
                                  [{"analysis": "static"}, {"analysis": "static", "loads": [load],
                                                            "ramp": {"by": 0.7, "to": 20}}]))
        self.assertAlmostEqual(told["stages"][1]["load_factor"], 5.6, delta=1e-9)  # 10 kN tan 30 = 5.77 kN
        self.assertEqual(told["stages"][1]["verdict"], "mechanism")

    def test_the_last_factor_is_the_one_that_was_asked_for(self):
        load = {"type": "point", "block": "cube", "point": [0.5, 0.5, 0.001], "force": [1000, 0, 0]}
        for by in (5, 2):
            told = self.run_scene(scene([GROUND, block("cube", [0, 0, 0], [1, 1, 1])],
                                      [{"analysis": "static", "loads": [load], "ramp": {"by": by, "to": 3}}]))
            self.assertEqual((told["stages"][0]["load_factor"], told["stages"][0]["verdict"]), (3, "rest"))


unittest.main(argv=[sys.argv[0]], verbosity=2)
