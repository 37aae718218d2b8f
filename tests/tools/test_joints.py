"""What is seen of joints: open ones with their gap, sums by joint, moments, centres of pressure, relative motion."""
import csv
import json
import pathlib
import subprocess
import sys
import unittest

QUOIN, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])

from folder_test import FolderTest

FAR = [3e4, -2e4, 1e3]


def box(low, high):
    return {"type": "box", "min": low, "max": high}


def cube_on_floor(stages, kind="rigid", **more):
    """1000 kg in g = 10 m/s2, far from the origin."""
    pose = {"translation": FAR}
    return {"materials": {"stone": {"density": 1000, "young": 1e10}}, "joint": {"friction_angle_deg": 45},
            "gravity": [0, 0, -10], "time_step": 0.01, "stages": stages,
            "blocks": [{"name": "floor", "kind": "fixed", "pose": pose, "shape": box([-5, -5, -1], [5, 5, 0])},
                       {"name": "cube", "kind": kind, "material": "stone", "pose": pose,
                        "shape": box([0, 0, 0], [1, 1, 1])}], **more}


class Joints(FolderTest):
    def run_scene(self, scene):
        (self.folder / "scene.json").write_text(json.dumps(scene))
        out = self.folder / "out"
        done = subprocess.run([QUOIN, "run", self.folder / "scene.json", "--json", "--out", out], capture_output=True,
                              text=True, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout), out

    @staticmethod
    def rows(out, name):
        return list(csv.DictReader((out / name).read_text().splitlines()))

    def test_a_joint_that_has_parted_is_listed_with_its_gap(self):
        for kind in ("rigid", "deformable"):
            stages = [{"analysis": "static"}, {"analysis": "dynamic", "duration": 0.5, "gravity": [0, 0, 5]}]
            _, out = self.run_scene(cube_on_floor(stages, kind))
            gap = 0.5 * 5 * 0.5 ** 2
            points = [row for row in self.rows(out, "contacts.csv") if row["stage"] == "1"]
            self.assertEqual(len(points), 4)
            for row in points:
                self.assertEqual((row["name_a"], row["name_b"], row["state"]), ("floor", "cube", "open"))
                self.assertAlmostEqual(float(row["gap"]), gap, places=5)
                self.assertEqual(float(row["normal_force"]), 0)
            joints = self.rows(out, "joints.csv")
            self.assertEqual([(row["stage"], row["state"]) for row in joints], [("0", "closed"), ("1", "open")])
            self.assertAlmostEqual(float(joints[1]["gap"]), gap, places=5)
            self.assertEqual(joints[1]["edge_stress"], "")

    def test_pairs_that_never_touched_or_are_gone_are_not_listed(self):
        stages = [{"analysis": "static"}, {"analysis": "static", "remove": "cube"}]
        scene = cube_on_floor(stages)
        scene["blocks"].append({"name": "other", "kind": "fixed", "shape": box([90, 0, 0], [91, 1, 1])})
        _, out = self.run_scene(scene)
        self.assertEqual([(row["stage"], row["name_a"], row["name_b"]) for row in self.rows(out, "joints.csv")],
                         [("0", "floor", "cube")])

    def test_resultant_moment_centre_and_edge_stress(self):
        """Pushed at its top by H: e = H h / N = 0.2 m, edge stress 2 N / (3 a b) with a = 0.3 m; within the middle
        third N/A (1 + 6 e / h)."""
        for push, edge in ((2000, 2e4 / (3 * 0.3)), (1000, 1e4 * 1.6)):
            load = {"type": "point", "block": "cube", "point": [x + y for x, y in zip(FAR, (0.5, 0.5, 1))],
                    "force": [push, 0, 0]}
            middle = [x + y for x, y in zip(FAR, (0.5, 0.5, 0))]
            e = push / 1e4
            monitor = {"name": "base", "contact": ["floor", "cube"], "about": middle}
            scene = cube_on_floor([{"analysis": "static"}, {"analysis": "dynamic", "steps": 1}], loads=[load],
                                  monitors=[monitor])
            scene["references"] = [
                {"monitor": "base", "quantity": "moment", "exact": ["0", str(-push), "0"], "allowed": 1e-6},
                {"monitor": "base", "quantity": "centre_of_pressure", "component": "x",
                 "exact": str(middle[0] + e), "allowed": 1e-9}]
            _, out = self.run_scene(scene)
            row = self.rows(out, "joints.csv")[0]
            for key, exact in {"normal_force": 1e4, "shear_force": push, "fx": -push, "fz": 1e4, "my": -push, "area": 1,
                               "normal_stress": 1e4, "edge_stress": edge, "nz": 1}.items():
                self.assertAlmostEqual(float(row[key]) / exact, 1, places=5, msg=key)
            self.assertAlmostEqual(float(row["x"]), middle[0] + e, places=5)
            self.assertEqual((row["points"], row["state"]), ("4", "closed"))

    def test_motion_relative_to_the_ground_and_spin(self):
        motion = {"velocity": {"formula": ["t", "0", "0"]}}
        scene = cube_on_floor([{"analysis": "dynamic", "duration": 0.5}])
        scene["blocks"][0].update(kind="prescribed", motion=motion)
        scene["blocks"].append({"name": "spun", "kind": "rigid", "material": "stone", "angular_velocity": [0, 0, 2],
                                "shape": box([50, 0, 90], [51, 1, 91])})
        scene["monitors"] = [{"name": "absolute", "block": "cube"},
                             {"name": "relative", "block": "cube", "relative_to": "floor"},
                             {"name": "spun", "block": "spun"}]
        summary, out = self.run_scene(scene)
        self.assertAlmostEqual(summary["monitors"]["absolute"]["displacement"][0], 0.125, places=4)
        for key in ("displacement", "velocity"):
            self.assertLess(max(map(abs, summary["monitors"]["relative"][key])), 1e-6, key)
        self.assertAlmostEqual(float(self.rows(out, "history.csv")[-1]["spun.wz"]), 2, places=9)
        done = subprocess.run([QUOIN, "check", self.folder / "scene.json", "--set", "/monitors/1/relative_to=moon"],
                              capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2)
        self.assertIn("/monitors/1/relative_to: there is no block", done.stderr)


unittest.main(argv=[sys.argv[0]], verbosity=2)
