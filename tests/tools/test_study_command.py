"""`quoin study` as a user meets it: grid, errors, front, files, exit codes."""
import csv
import json
import pathlib
import subprocess
import sys
import time
import unittest

from folder_test import FolderTest

QUOIN, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
SCENES = SOURCE / "tools" / "scenes"


class StudyCommand(FolderTest):
    def setUp(self):
        super().setUp()
        self.out = self.folder / "deep" / "out"

    def study(self, *words, **wanted):
        return self.quoin("study", *words, "--out", self.out, **wanted)

    def points(self):
        return json.loads((self.out / "study.json").read_text())["points"]

    def test_runs_the_grid_against_the_reference(self):
        done = self.study(SCENES / "paper" / "incline.json", "--vary", "dt=0.02,0.01", "--vary",
                          "method=augmented_lagrangian,penalty", "--vary", "phi=0", "--set",
                          "/end_time=0.5", "--set", "/penalty=1e9", "--jobs", "2", code=0)
        rows = list(csv.DictReader(done.stdout.splitlines()))
        self.assertEqual(len(rows), 4)
        self.assertEqual({r["dt"] for r in rows}, {"0.02", "0.01"})
        for p in self.points():
            self.assertLess(p["error"], 1e-9)
            self.assertEqual(p["failure"], "")
            self.assertGreater(p["cpu_seconds"], 0)
        self.assertEqual((self.out / "study.csv").read_text(), done.stdout)

    def test_front_has_no_point_that_another_beats(self):
        self.study(SCENES / "study" / "rocking.json", "--vary", "dt=0.02,0.01,0.005")
        points = self.points()
        for p in points:
            beaten = any(q["error"] <= p["error"] and q["cpu_seconds"] <= p["cpu_seconds"] and
                         (q["error"] < p["error"] or q["cpu_seconds"] < p["cpu_seconds"])
                         for q in points)
            self.assertEqual(p["pareto"], not beaten)

    def test_without_a_reference_against_the_finest_run(self):
        self.study(SCENES / "study" / "dominoes.json", "--set", "/end_time=0.1", "--vary", "dt=0.01,0.0025")
        errors = [p["error"] for p in self.points()]
        self.assertIsNone(errors[1])
        self.assertLess(errors[0], 0.05)

    def test_without_a_reference_each_scene_has_its_own_finest_run(self):
        self.study(SCENES / "study" / "dominoes.json", "--set", "/end_time=0.1", "--vary",
                   "dt=0.01,0.0025", "--vary", "/joint/friction_angle_deg=10,35")
        errors = {tuple(p["settings"].values()): p["error"] for p in self.points()}
        self.assertEqual(len(errors), 4)
        for (step, _), error in errors.items():
            if step == "0.0025":
                self.assertIsNone(error)
            else:
                self.assertLess(error, 0.05)

    def test_a_setting_that_fails_is_told_and_the_others_run(self):
        self.study(SCENES / "paper" / "two_forces.json", "--set", "/end_time=0.05", "--vary", "dt=0.01,-1", code=0)
        self.assertEqual([bool(p["failure"]) for p in self.points()], [False, True])
        self.assertIn("/time_step", self.points()[1]["failure"])

    def test_json_and_a_time_limit(self):
        told = self.told("study", SCENES / "paper" / "two_forces.json", "--vary", "dt=0.01,0.02", "--set", "/end_time=1000",
                         "--max-seconds", "0.2", "--jobs", "1", code=1, err="the study was ended early")
        failures = [p["failure"] for p in told["points"]]
        self.assertEqual(failures, ["the time limit is over", "not run: the study was ended early"])

    def test_replaces_what_quoin_wrote_and_nothing_else(self):
        grid = [SCENES / "paper" / "incline.json", "--set", "/end_time=0.1", "--vary", "dt=0.01"]
        for _ in range(2):
            self.study(*grid, code=0)
        self.assertEqual({p.name for p in self.out.iterdir()},
                         {"study.csv", "study.json", "manifest.json"})
        notes = self.out / "notes.txt"
        notes.write_text("mine")
        self.assertEqual(self.study(*grid, code=1, err="notes.txt").stdout, "")  # told before anything runs
        notes.unlink()
        (self.out / "study.csv").write_text("changed by hand")
        self.study(*grid, code=1)
        self.assertEqual((self.out / "study.csv").read_text(), "changed by hand")

    def test_killed_it_leaves_the_earlier_results(self):
        grid = [SCENES / "paper" / "two_forces.json", "--vary", "dt=0.01,0.02"]
        self.study(*grid, "--set", "/end_time=0.05", code=0)
        before = {p.name: p.read_bytes() for p in self.out.iterdir()}
        process = subprocess.Popen([QUOIN, "study", *map(str, grid), "--set", "/end_time=1000", "--out", self.out],
                                   stdout=subprocess.DEVNULL)
        deadline = time.monotonic() + 60
        while not list(self.out.parent.glob("out.part-*")) and time.monotonic() < deadline:
            time.sleep(0.01)
        process.kill()
        process.wait()
        self.assertEqual({p.name: p.read_bytes() for p in self.out.iterdir()}, before)
        (self.out.parent / "out.part-abcdef").mkdir()  # killed right after it was made
        self.study(*grid, "--set", "/end_time=0.05", code=0)
        self.assertEqual([p.name for p in self.out.parent.iterdir()], ["out"])  # swept


unittest.main(argv=[sys.argv[0]], verbosity=2)
