"""What is seen of joints: open ones with their gap, sums by joint, moments, centres of pressure, relative motion."""
import json
import math
import pathlib
import sys
import unittest

from folder_test import FolderTest, block, box

SCENES = pathlib.Path(__file__).parents[2] / "tools/scenes/cases"
FAR = [3e4, -2e4, 1e3]


def cube_on_floor(stages, kind="rigid", **more):
    """1000 kg in g = 10 m/s2, far from the origin."""
    pose = {"translation": FAR}
    return {"materials": {"stone": {"density": 1000, "young": 1e10}}, "joint": {"friction_angle_deg": 45},
            "gravity": [0, 0, -10], "time_step": 0.01, "stages": stages,
            "blocks": [block("floor", [-5, -5, -1], [5, 5, 0], "fixed", pose=pose),
                       block("cube", [0, 0, 0], [1, 1, 1], kind, pose=pose)], **more}


class Joints(FolderTest):
    def test_a_joint_that_has_parted_is_listed_with_its_gap(self):
        for kind in ("rigid", "deformable"):
            stages = [{"analysis": "static"}, {"analysis": "dynamic", "duration": 0.5, "gravity": [0, 0, 5]}]
            self.run_scene(cube_on_floor(stages, kind))
            gap = 0.5 * 5 * 0.5 ** 2
            points = [row for row in self.rows("contacts.csv") if row["stage"] == "1"]
            self.assertEqual(len(points), 4)
            for row in points:
                self.assertEqual((row["name_a"], row["name_b"], row["state"]), ("floor", "cube", "open"))
                self.assertAlmostEqual(float(row["gap"]), gap, places=5)
                self.assertEqual(float(row["normal_force"]), 0)
            joints = self.rows("joints.csv")
            self.assertEqual([(row["stage"], row["state"]) for row in joints], [("0", "closed"), ("1", "open")])
            self.assertAlmostEqual(float(joints[1]["gap"]), gap, places=5)
            self.assertEqual(joints[1]["edge_stress"], "")

    def test_a_joint_on_springs_that_leans_tells_its_area(self):
        joint = {"friction_angle_deg": 45, "normal_stiffness": 1e9, "shear_stiffness": 5e8}
        load = {"type": "point", "block": "cube", "point": [x + y for x, y in zip(FAR, (0.6, 0.5, 1))],
                "force": [0, 0, -2000]}
        self.run_scene(cube_on_floor([{"analysis": "static"}], joint=joint, loads=[load]))
        row, = self.rows("joints.csv")
        self.assertAlmostEqual(float(row["area"]), 1, places=6)
        self.assertAlmostEqual(float(row["normal_stress"]), 12000, places=1)
        self.assertGreater(float(row["edge_stress"]), 12000)
        self.assertAlmostEqual(sum(float(point["area"]) for point in self.rows("contacts.csv")), 1, places=6)

    def test_a_head_joint_without_force_that_opens_is_listed(self):
        rounding, crack = 1e-8, 0.017
        table = [[0, 0, 0, 0], [0.5, -crack, 0, 0]]
        scene = cube_on_floor([{"analysis": "static"}, {"analysis": "dynamic", "end_time": 0.5}])
        scene["blocks"].append(block("pier", [-1, 0, 0], [-rounding, 1, 1], "prescribed", pose={"translation": FAR},
                                     motion={"displacement": {"table": table}}))
        self.run_scene(scene)
        gaps = [float(row["gap"]) for row in self.rows("joints.csv") if (row["stage"], row["name_b"]) == ("1", "pier")]
        self.assertEqual(len(gaps), 1)
        self.assertAlmostEqual(gaps[0], crack + rounding, places=10)

    def test_the_normal_of_a_joint_that_rocks_is_that_of_what_bears(self):
        scene = json.loads((SCENES / "shaken_wall_rocks.json").read_text())
        self.run_scene({key: value for key, value in scene.items() if key not in ("references", "cases")})
        contacts = self.rows("contacts.csv")
        pressed = [row for row in self.rows("joints.csv") if float(row["normal_force"]) > 0]
        self.assertGreater(len(pressed), 10)
        for row in pressed:
            points = [c for c in contacts if (c["a"], c["b"]) == (row["a"], row["b"])]
            bears = [sum(float(c["normal_force"]) * float(c["n" + axis]) for c in points) for axis in "xyz"]
            for axis, along in zip("xyz", bears):
                self.assertAlmostEqual(float(row["n" + axis]), along / math.hypot(*bears), delta=1e-9)

    def test_pairs_that_never_touched_or_are_gone_are_not_listed(self):
        scene = cube_on_floor([{"analysis": "static"}, {"analysis": "static", "remove": "cube"}])
        scene["blocks"].append(block("other", [90, 0, 0], [91, 1, 1], "fixed"))
        self.run_scene(scene)
        self.assertEqual([(row["stage"], row["name_a"], row["name_b"]) for row in self.rows("joints.csv")],
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
            self.run_scene(scene)
            row = self.rows("joints.csv")[0]
            for key, exact in {"normal_force": 1e4, "shear_force": push, "fx": -push, "fz": 1e4, "my": -push, "area": 1,
                               "normal_stress": 1e4, "edge_stress": edge, "nz": 1}.items():
                self.assertAlmostEqual(float(row[key]) / exact, 1, places=5, msg=key)
            self.assertAlmostEqual(float(row["x"]), middle[0] + e, places=5)
            self.assertEqual((row["points"], row["state"]), ("4", "closed"))

    def test_a_stiff_bond_bends_to_its_first_crack(self):
        """1 m square, strength T: cracks at T / 12 c, c from its axis to the farthest corner, and bears no more than
        1.12 times that once cracked, about any axis."""
        joint = {"friction_angle_deg": 30, "tension": 1e5, "cohesion": 1e8, "normal_stiffness": 1e9, "shear_stiffness": 1e9}
        blocks = [block("ground", [-2, -2, -1], [2, 2, 0], "fixed"), block("slab", [-0.5, -0.5, 0], [0.5, 0.5, 0.5])]
        for degrees in (0, 20, 45):
            x, y = 0.4 * math.cos(math.radians(degrees)), 0.4 * math.sin(math.radians(degrees))
            crack = 1e5 / 12 / (0.5 * (x + y) / 0.4) / 0.8
            for share, code in ((0.97, 0), (1.12, 1)):
                loads = [{"type": "point", "block": "slab", "point": [side * x, side * y, 0.5],
                          "force": [0, 0, side * share * crack]} for side in (1, -1)]
                self.run_scene({"materials": {"stone": {"density": 1000}}, "joint": joint, "blocks": blocks, "loads": loads,
                                "gravity": [0, 0, 0], "stages": [{"analysis": "static"}]}, code=code)

    def test_motion_relative_to_the_ground_and_spin(self):
        motion = {"velocity": {"formula": ["t", "0", "0"]}}
        scene = cube_on_floor([{"analysis": "dynamic", "duration": 0.5}])
        scene["blocks"][0].update(kind="prescribed", motion=motion)
        scene["blocks"].append(block("spun", [50, 0, 90], [51, 1, 91], angular_velocity=[0, 0, 2]))
        scene["monitors"] = [{"name": "absolute", "block": "cube"},
                             {"name": "relative", "block": "cube", "relative_to": "floor"},
                             {"name": "spun", "block": "spun"}]
        summary = self.run_scene(scene)
        self.assertAlmostEqual(summary["monitors"]["absolute"]["displacement"][0], 0.125, places=4)
        for key in ("displacement", "velocity"):
            self.assertLess(max(map(abs, summary["monitors"]["relative"][key])), 1e-6, key)
        self.assertAlmostEqual(float(self.rows("history.csv")[-1]["spun.wz"]), 2, places=9)
        self.quoin("check", "scene.json", "--set", "/monitors/1/relative_to=moon", code=2,
                   err="/monitors/1/relative_to: there is no block")

    def drums(self, **more):
        """A column of four drums, cut at z = 1, 2 and 3 m, on a floor that is tilted by 20 degrees."""
        tilt = math.radians(20)
        planes = [{"type": "plane", "name": name, "dip_deg": 0, "point": [0, 0, z]}
                  for z, name in enumerate(("low", "middle", "high"), 1)]
        return {"materials": {"stone": {"density": 1000}}, "joint": {"friction_angle_deg": 40}, "time_step": 0.01,
                "gravity": [10 * math.sin(tilt), 0, -10 * math.cos(tilt)], "end_time": 0.1,
                "blocks": [block("floor", [-5, -5, -1], [5, 5, 0], "fixed")],
                "cut": {"name": "drum", "block": {"kind": "rigid", "material": "stone"}, "cuts": planes,
                        "body": box([0, 0, 0], [3, 1, 4])}, **more}

    def test_joints_by_plane_pair_and_place(self):
        slid = 0.5 * 10 * (math.sin(math.radians(20)) - math.cos(math.radians(20)) * math.tan(math.radians(10))) * 0.1 ** 2
        lower = {"friction_angle_deg": 10}
        for name, joints in {
                "plane": [{"planes": "middle"}], "planes": [{"planes": ["middle"], "between": ["stone", "stone"]}],
                "pair": [{"blocks": ["drum1", "drum[2-9]"]}], "depth": [{"where": "z > 1.5 && z < 2.5"}],
                "the last wins": [{"where": "z > 0.5"}, {"planes": ["low", "high"], "friction_angle_deg": 40}],
                "before groups": [{"between": ["stone", "stone"], "friction_angle_deg": 39}, {"planes": "middle"}]}.items():
            scene = self.drums(joints=[{**lower, **joint} for joint in joints])
            for of in ("scene", "written", "joined", "stage"):
                tried = json.loads(json.dumps(scene))
                if of == "joined":
                    tried["join"] = [{"blocks": ["drum2", "drum3"]}]
                if of == "stage":
                    tried["stages"] = [{"analysis": "static"}, {"analysis": "dynamic", "steps": 10,
                                                                "joints": tried.pop("joints")}]
                    del tried["end_time"]
                if of == "written":
                    (self.folder / "uncut.json").write_text(json.dumps(tried))
                    (self.folder / "cut.json").unlink(missing_ok=True)
                    self.quoin("cut", "uncut.json", "--out", "cut.json", code=0)
                    tried = json.loads((self.folder / "cut.json").read_text())
                self.run_scene(tried)
                for row in self.rows("blocks.csv"):
                    if of == "stage" and row["stage"] == "0":
                        continue
                    far = slid if row["kind"] == "rigid" and float(row["z"]) > 2 else 0.0
                    self.assertAlmostEqual(float(row["ux"]), far, delta=1e-8, msg=(name, of, row["name"]))

    def test_water_on_a_plane(self):
        scene = self.drums(water=[{"pressure": 5000, "on": "joints", "planes": "middle"}],
                           monitors=[{"name": f"joint{k}", "contact": [f"drum{k}", f"drum{k + 1}"]} for k in range(3)])
        summary = self.run_scene(scene)
        for k, above in enumerate((3, 2, 1)):
            wanted = 3e4 * above * math.cos(math.radians(20)) - 5000 * 3 * (k == 1)
            self.assertAlmostEqual(summary["monitors"][f"joint{k}"]["force"][2], wanted, delta=1e-3)


unittest.main(argv=[sys.argv[0]], verbosity=2)
