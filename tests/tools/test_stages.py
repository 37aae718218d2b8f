"""Stages of a scene file: their stop rules, displacements that are reset, runs that go on
over them. What blocks do is in tools/scenes/cases/stage_*.json, what is refused in bad_inputs."""
import json
import pathlib
import sys
import unittest

SOURCE = pathlib.Path(sys.argv[2])
sys.path.insert(0, str(SOURCE / "tools"))
import vtk_file  # noqa: E402

from folder_test import FolderTest, block, box


def sliding(stages, **more):
    """A cube on a smooth floor that is pulled along x with 1 m/s2."""
    return {"materials": {"stone": {"density": 1000, "young": 1e9}}, "joint": {"friction_angle_deg": 0},
            "gravity": [1, 0, -10], "time_step": 0.01, "stages": stages,
            "blocks": [block("floor", [-5, -5, -1], [50, 5, 0], "fixed"), block("cube", [0, 0, 0], [1, 1, 1]),
                       block("other", [20, 0, 0], [21, 1, 1])],
            "monitors": [{"name": "cube", "block": "cube"}], **more}


class Stages(FolderTest):
    def test_each_stop_rule_ends_its_stage(self):
        dynamic = {"analysis": "dynamic"}
        stages = [{**dynamic, "name": "first", "until_moved": 0.1, "duration": 5},
                  {**dynamic, "duration": 0.2}, {**dynamic, "steps": 7},
                  {**dynamic, "duration": 100, "until_moved": 0.5},
                  {"analysis": "static", "gravity": [0, 0, -10]}]
        found = self.run_scene(sliding(stages))["stages"]
        self.assertEqual([s["ended_by"] for s in found], ["moved", "time", "steps", "moved", "rest"])
        self.assertEqual(found[0]["name"], "first")
        # x = t2 / 2 passes 0.1 m at 0.447 s, v = 0.45 + 0.2 + 0.07 then, and 0.5 m after 0.512 s more
        self.assertEqual([s["steps"] for s in found][:4], [45, 20, 7, 52])

    def test_until_rest_in_a_dynamic_stage(self):
        rough = sliding([{"analysis": "dynamic", "duration": 10, "until": "rest"}], gravity=[0, 0, -10],
                        joint={"friction_angle_deg": 45})
        rough["blocks"][1]["velocity"] = [1, 0, 0]
        found = self.run_scene(rough)
        self.assertEqual(found["stages"][0]["ended_by"], "rest")
        self.assertAlmostEqual(found["monitors"]["cube"]["displacement"][0], 1 / 20, places=3)
        self.assertLess(found["time"], 0.2)
        smooth = sliding([{"analysis": "dynamic", "duration": 0.1, "until": "rest"}])
        found = self.run_scene(smooth, code=1)
        self.assertEqual(found["status"], "not_at_rest")

    def test_displacements_that_are_reset(self):
        stages = [{"analysis": "dynamic", "duration": 1},
                  {"analysis": "dynamic", "duration": 1, "reset_displacements": True}]
        found = self.run_scene(sliding(stages))
        self.assertAlmostEqual(found["monitors"]["cube"]["displacement"][0], 1.5, places=9)
        rows = [r for r in self.rows("blocks.csv") if r["name"] == "cube"]
        self.assertEqual([round(float(r["ux"]), 9) for r in rows], [0.5, 1.5])
        last = sorted(self.folder.glob("out/blocks_*.vtu"))[-1]
        moved = vtk_file.read(last)[1]["displacement"]
        self.assertAlmostEqual(float(moved[8][0]), 1.5, places=9)

    def test_a_block_that_appears_within_another_is_refused_and_results_are_kept(self):
        scene = sliding([{"analysis": "dynamic", "duration": 0.1},
                         {"name": "too full", "analysis": "dynamic", "duration": 0.1, "add": "other"}])
        scene["blocks"][2]["shape"] = box([0.2, 0, 0], [1.2, 1, 1])
        found = self.run_scene(scene, code=1)
        self.assertEqual(found["status"], "stage_refused")
        self.assertIn("stage 1 (too full) can't begin: blocks 1 (cube) and 2 (other) overlap", found["message"])
        self.assertTrue(self.rows("blocks.csv"))

    def test_a_velocity_of_a_stage_counts_as_work_and_leaves_the_spin(self):
        first = {"analysis": "dynamic", "duration": 0.1}
        scene = sliding([first, {**first, "overrides": [{"blocks": "cube", "velocity": [2, 0, 0]}]}], gravity=[0, 0, 0])
        scene["blocks"][1] |= {"velocity": [1, 0, 0], "angular_velocity": [0, 0, 0.5]}
        found = self.run_scene(scene)
        self.assertAlmostEqual(found["monitors"]["cube"]["displacement"][0], 0.3, places=9)
        self.assertAlmostEqual(found["monitors"]["cube"]["angular_velocity"][2], 0.5, places=9)
        self.assertAlmostEqual(found["energy"]["work"], 0.5 * 1000 * (4 - 1), places=6)
        self.assertLess(abs(found["energy"]["growth"]), 1e-6)

    def test_a_displacement_that_a_stage_gives_counts_from_there(self):
        def along(way):
            return {"displacement": {"formula": [way, "0", "0"]}}

        stage = {"analysis": "dynamic", "duration": 0.5}
        for ways, exact in ((("stage_time", "0.2*stage_time"), 0.6), (("stage_time", "stage_time"), 1.0), (("t", "0.2*t"), 0.6)):
            second = {**stage, "overrides": [{"blocks": "cube", "motion": along(ways[1])}]}
            scene = sliding([stage, second], gravity=[0, 0, 0])
            scene["blocks"][1] |= {"kind": "prescribed", "motion": along(ways[0])}
            found = self.run_scene(scene)
            self.assertAlmostEqual(found["monitors"]["cube"]["displacement"][0], exact, places=9)

    def test_a_run_goes_on_over_stages_to_the_bit(self):
        """Ended early in each of its stages, and resumed."""
        stages = [{"analysis": "static", "gravity": [0, 0, -10]},
                  {"analysis": "dynamic", "gravity": [1, 0, -10], "duration": 0.4, "until_moved": 0.06, "remove": "other",
                   "overrides": [{"blocks": "cube", "velocity": [0.01, 0, 0]}]},
                  {"analysis": "dynamic", "duration": 0.4, "add": "other", "reset_displacements": True,
                   "overrides": [{"blocks": "other", "kind": "prescribed", "motion": {"displacement": {"formula": ["-t", "0", "0"]}}}],
                   "fixed_points": [{"block": "cube", "point": [0.5, 0.5, 0.5]}]}]
        scene = sliding(stages, time_step=0.0005)
        scene["monitors"].append({"name": "hold", "fixed_points": "cube"})
        self.run_scene(scene)
        (self.folder / "out").rename(self.folder / "plain")
        self.quoin("run", self.written(scene), "--out", "out", "--max-seconds", "0.02")
        for _ in range(200):
            if self.summary()["status"] != "time_limit":
                break
            self.quoin("run", "--resume", "out", "--max-seconds", "0.05")
        else:
            self.fail("never done")
        wanted, got = ({p.name: p.read_bytes() for p in (self.folder / name).iterdir()} for name in ("plain", "out"))
        self.assertEqual(sorted(got), sorted(wanted))
        for name in wanted:
            if name not in ("manifest.json", "summary.json"):
                self.assertEqual(got[name], wanted[name], name)

    def test_fewer_threads_where_the_system_starts_no_more(self):
        """Room for few stacks: the run says so in one line and gives the same answer."""
        scene = sliding([{"analysis": "dynamic", "duration": 0.1}])
        scene["blocks"] += [block(f"far{k}", [20, 10 * k, 0], [21, 10 * k + 1, 1]) for k in range(1, 100)]
        whole = self.run_scene(scene)
        done = self.quoin("run", "scene.json", "--json", "--threads", "100", code=0,
                          limits="ulimit -s 65536; ulimit -v 2000000")
        found = json.loads(done.stdout)
        self.assertLess(found["options"]["threads"], 100)
        self.assertEqual(done.stderr, f"quoin: {found['options']['threads']} of 100 threads: the system starts no more\n")
        self.assertEqual(found["monitors"], whole["monitors"])

    def test_no_more_threads_than_blocks_that_move(self):
        scene = sliding([{"analysis": "dynamic", "duration": 0.1}])
        self.assertEqual(self.run_scene(scene, "--threads", 8)["options"]["threads"], 2)


unittest.main(argv=[sys.argv[0]], verbosity=2)
