"""`quoin info`, `quoin check` and `quoin make` as a user meets them."""
import json
import pathlib
import sys
import unittest

from folder_test import FolderTest, block

SOURCE = pathlib.Path(sys.argv[2])
MESHES = SOURCE / "tests" / "unit" / "meshes"
SHAPES = {"wall": 45, "arch": 23, "dome": 97, "tower": 9, "stair": 9, "slope": 3, "pile": 61,
          "shaken-wall": 45, "struck-wall": 46, "bin": 205, "jointed-slope": 102, "vault": 75}


class SceneCommands(FolderTest):
    def test_info_lists_blocks_and_changes_nothing(self):
        first, second = self.told("info", MESHES / "meshio.off", "--units", "cm", "--supports",
                     "lowest_course")["blocks"]
        self.assertAlmostEqual(first["volume"], 1e-6, places=18)
        self.assertTrue(first["support"])
        self.assertEqual(second["nearest_support"]["id"], "block0")
        self.assertAlmostEqual(second["nearest_support"]["gap"], 0, places=12)
        self.assertEqual((second["faces"], second["mesh_faces"]), (6, 12))
        self.quoin("info", MESHES / "vtk.obj", out="2 blocks, 2 convex, 0 supports, 1.5 m3")

    def test_info_says_why_a_block_is_not_convex(self):
        path = self.folder / "open.off"
        path.write_text("OFF 4 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n")
        self.quoin("info", path, code=2, out="is not closed: its faces enclose")

    def test_check_tells_what_would_run(self):
        report = self.told("check", SOURCE / "tools" / "scenes" / "paper" / "incline.json")
        self.assertEqual(report["contacts"]["types"], {"face-face": 1})
        self.assertEqual(report["without_support"], [])
        self.assertTrue(report["trial_step"]["converged"])
        self.assertGreater(report["time_step"]["elastic_omega_dt"], 0)
        self.assertEqual(list(self.folder.iterdir()), [])

    def boxes(self, *heights):
        blocks = [block("ground", [-2, -2, -1], [2, 2, 0], "fixed"),
                  *(block(f"b{i}", [0, 0, z], [1, 1, z + 1]) for i, z in enumerate(heights))]
        return {"materials": {"stone": {"density": 2000}}, "joint": {"friction_angle_deg": 30},
                "end_time": 1, "blocks": blocks}

    def test_check_names_overlaps_gaps_and_loose_blocks(self):
        scene = self.boxes(-0.01, 1.005)
        report = self.told("check", self.written(scene), code=2,
                           err='/blocks: "ground" and "b0" overlap by 0.01 m, more than 1e-3')
        self.assertAlmostEqual(report["contacts"]["overlaps"][0]["gap"], -0.01, places=12)
        self.assertEqual(report["contacts"]["gaps"][0]["a"], "b0")
        self.assertEqual(report["without_support"], ["b1"])
        scene["initial_overlap"] = "zero"
        self.quoin("check", self.written(scene), code=0, out=("overlap 0.01 m: ground, b0", "without support: b1"))

    def test_check_leaves_out_blocks_that_a_stage_adds(self):
        scene = self.boxes(0, 0)
        del scene["end_time"]
        scene["stages"] = [{"analysis": "static"}, {"analysis": "static", "remove": "b0", "add": "b1"}]
        report = self.told("check", self.written(scene))
        self.assertEqual(report["contacts"]["pairs"], 1)
        self.assertEqual((report["blocks"]["rigid"], report["blocks"]["absent"], report["blocks"]["mass"]), (1, 1, 2000))
        self.quoin("check", self.written(scene), out="1 absent")

    def test_check_tries_the_first_step_of_the_first_stage(self):
        """As a run has it: with what that stage changes."""
        scene = self.boxes(0)
        del scene["end_time"]
        scene["blocks"].append(block("plate", [-2, -2, 1], [2, 2, 2], "prescribed", motion={"velocity": [0, 0, 0]}))
        stage = {"analysis": "dynamic", "duration": 1}
        scene["stages"] = [stage]
        self.quoin("check", self.written(scene), code=0)
        stage["overrides"] = [{"blocks": "plate", "motion": {"velocity": [0, 0, -0.1]}}]
        stage["loads"] = [{"type": "point", "block": "b0", "point": [0.5, 0.5, 0.5], "force": [1, 0, 0]}]
        done = self.quoin("check", self.written(scene), code=1,
                          out=("did not converge", 'contacts that fight: "b0" and "plate"'))
        for words in ("coordinate_rounding", "load terms", "left out: prescribed motion"):  # it is the plate that comes on
            self.assertNotIn(words, done.stdout)
        stage.pop("overrides")
        stage["remove"] = "ground"
        report = json.loads(self.quoin("check", self.written(scene), "--json").stdout)
        self.assertEqual((report["blocks"]["absent"], report["contacts"]["pairs"]), (1, 1))

    def test_check_names_points_outside_their_block(self):
        scene = self.boxes(0)
        scene["loads"] = [{"type": "point", "block": "b0", "point": [x, 0.5, 1], "force": [0, 0, -1]} for x in (1, 3)]
        scene["fixed_points"] = [{"block": "b0", "point": [0.5, 0.5, -1e-3]}, {"block": "b0", "point": [0.5, 0.5, 0.5]}]
        later = {"type": "point", "block": "b0", "point": [0.5, 7, 1], "force": [1, 0, 0]}
        scene["stages"] = [{"analysis": "dynamic", "end_time": scene.pop("end_time")},
                           {"analysis": "dynamic", "duration": 0.1, "loads": [*scene["loads"], later]}]
        self.assertEqual(self.told("check", self.written(scene))["points_outside"],
                         [{"what": "load", "block": "b0", "point": [3, 0.5, 1]},
                          {"what": "fixed point", "block": "b0", "point": [0.5, 0.5, -1e-3]},
                          {"what": "load", "block": "b0", "point": [0.5, 7, 1]}])
        self.quoin("check", self.written(scene), out='outside its block "b0": load at (3, 0.5, 1) m')
        done = self.quoin("run", self.written(scene))
        self.assertEqual(done.stderr.splitlines()[:2],
                         ['quoin: block "b0": load at (3, 0.5, 1) m is 2 m or more outside it, and moves along as the '
                          'end of a lever',
                          'quoin: block "b0": fixed point at (0.5, 0.5, -0.001) m is 0.001 m or more outside it, and '
                          'moves along as the end of a lever'])

    def test_check_ends_a_step_that_lasts(self):
        path = self.folder / "dust.json"
        self.quoin("make", "bin", "--size", "1e-5", "--out", path)
        done = self.quoin("check", path, "--max-seconds", "0.3", code=1, out="one step tried: the time limit is over")
        self.assertNotIn("to expect", done.stdout)

    def test_overlap_taken_as_touching_stays_where_it_is(self):
        scene = self.boxes(-0.01)
        scene |= {"initial_overlap": "zero", "monitors": [{"name": "m", "block": "b0"}]}
        summary = self.told("run", self.written(scene))
        self.assertLess(abs(summary["monitors"]["m"]["displacement"][2]), 1e-9)
        self.assertAlmostEqual(summary["base_reaction"][2], -2000 * 9.81, places=3)

    def test_every_made_scene_is_checked_and_runs(self):
        for shape, blocks in SHAPES.items():
            with self.subTest(shape):
                path = self.folder / f"{shape}.json"
                self.quoin("make", shape, "--out", path, code=0)
                self.assertEqual(self.quoin("make", shape).stdout, path.read_text())
                self.assertEqual(len(json.loads(path.read_text())["blocks"]), blocks)
                report = self.told("check", path)
                self.assertEqual(report["contacts"]["overlaps"], [])
                if shape not in ("pile", "bin"):
                    self.assertEqual([name for name in report["without_support"] if name != "hammer"], [])
                steps = ["--set", "/stages=[{\"analysis\":\"static\",\"steps\":3}]"]
                if shape in ("slope", "pile"):
                    steps = ["--set", "/stages/0/end_time=0.05"]
                elif shape == "bin":
                    steps = ["--set", "/stages=[{\"analysis\":\"dynamic\",\"steps\":3}]"]
                elif len(json.loads(path.read_text())["stages"]) == 2:
                    steps = ["--set", "/stages/1/duration=0.02"]
                self.quoin("run", path, *steps, "--json", code=0)

    def test_a_made_wedge_slides_as_the_closed_form_says(self):
        from math import cos, radians, sin, tan
        self.quoin("make", "slope", "--friction-deg", 20, "--end-time", 0.5, "--out", "slope.json", code=0)
        summary = self.told("run", "slope.json")
        psi, half, phi = radians(35), radians(45), radians(20)
        fall = 9.81 * (sin(psi) - cos(psi) * tan(phi) / sin(half))
        moved = summary["monitors"]["wedge"]["displacement"]
        self.assertAlmostEqual(moved[0] / (0.5 * fall * 0.5**2 * cos(psi)), 1, places=6)

    def test_make_keeps_what_it_did_not_make(self):
        kept = self.written({"title": "a scene that was made and changed"})
        self.quoin("make", "wall", "--out", kept, code=1)
        self.assertIn("changed", kept.read_text())

    def test_out_of_memory_is_told(self):
        for words in ("wall --length 1000 --height 160", "pile --blocks 1000000"):
            self.quoin("make", *words.split(), code=1, says="quoin: out of memory\n", limits="ulimit -v 230000")

    def test_a_shaken_wall_has_steps_that_see_its_wave(self):
        for hz, step in ((2, 5e-3), (10, 5e-3), (200, 2.5e-4)):
            made = json.loads(self.quoin("make", "shaken-wall", "--hz", hz).stdout)
            self.assertAlmostEqual(made["time_step"], step, places=12)


unittest.main(argv=[sys.argv[0]], verbosity=2)
