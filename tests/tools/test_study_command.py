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


def study(*arguments):
    return subprocess.run([QUOIN, "study", *map(str, arguments)], capture_output=True, text=True,
                          timeout=120)


class StudyCommand(FolderTest):
    def setUp(self):
        super().setUp()
        self.folder = self.folder / "deep" / "out"

    def points(self):
        return json.loads((self.folder / "study.json").read_text())["points"]

    def test_runs_the_grid_against_the_reference(self):
        done = study(SCENES / "paper" / "incline.json", "--vary", "dt=0.02,0.01", "--vary",
                     "method=augmented_lagrangian,penalty", "--vary", "phi=0", "--set",
                     "/end_time=0.5", "--set", "/penalty=1e9", "--out", self.folder, "--jobs", "2")
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = list(csv.DictReader(done.stdout.splitlines()))
        self.assertEqual(len(rows), 4)
        self.assertEqual({r["dt"] for r in rows}, {"0.02", "0.01"})
        for p in self.points():
            self.assertLess(p["error"], 1e-9)
            self.assertEqual(p["failure"], "")
            self.assertGreater(p["cpu_seconds"], 0)
        self.assertEqual((self.folder / "study.csv").read_text(), done.stdout)

    def test_front_has_no_point_that_another_beats(self):
        study(SCENES / "study" / "rocking.json", "--vary", "dt=0.02,0.01,0.005", "--out", self.folder)
        points = self.points()
        for p in points:
            beaten = any(q["error"] <= p["error"] and q["cpu_seconds"] <= p["cpu_seconds"] and
                         (q["error"] < p["error"] or q["cpu_seconds"] < p["cpu_seconds"])
                         for q in points)
            self.assertEqual(p["pareto"], not beaten)

    def test_without_a_reference_against_the_finest_run(self):
        study(SCENES / "study" / "dominoes.json", "--set", "/end_time=0.1", "--vary",
              "dt=0.01,0.0025", "--out", self.folder)
        errors = [p["error"] for p in self.points()]
        self.assertIsNone(errors[1])
        self.assertLess(errors[0], 0.05)

    def test_without_a_reference_each_scene_has_its_own_finest_run(self):
        study(SCENES / "study" / "dominoes.json", "--set", "/end_time=0.1", "--vary",
              "dt=0.01,0.0025", "--vary", "/joint/friction_angle_deg=10,35", "--out", self.folder)
        errors = {tuple(p["settings"].values()): p["error"] for p in self.points()}
        self.assertEqual(len(errors), 4)
        for (step, _), error in errors.items():
            if step == "0.0025":
                self.assertIsNone(error)
            else:
                self.assertLess(error, 0.05)

    def test_a_setting_that_fails_is_told_and_the_others_run(self):
        done = study(SCENES / "paper" / "two_forces.json", "--set", "/end_time=0.05", "--vary",
                     "dt=0.01,-1", "--out", self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([bool(p["failure"]) for p in self.points()], [False, True])
        self.assertIn("/time_step", self.points()[1]["failure"])

    def test_json_and_a_time_limit(self):
        done = study(SCENES / "paper" / "two_forces.json", "--vary", "dt=0.01,0.02", "--set",
                     "/end_time=1000", "--max-seconds", "0.2", "--jobs", "1", "--json")
        self.assertEqual(done.returncode, 1)
        self.assertIn("the study was ended early", done.stderr)
        failures = [p["failure"] for p in json.loads(done.stdout)["points"]]
        self.assertEqual(failures, ["the time limit is over", "not run: the study was ended early"])

    def test_replaces_what_quoin_wrote_and_nothing_else(self):
        grid = [SCENES / "paper" / "incline.json", "--set", "/end_time=0.1", "--vary", "dt=0.01", "--out"]
        for _ in range(2):
            self.assertEqual(study(*grid, self.folder).returncode, 0)
        self.assertEqual({p.name for p in self.folder.iterdir()},
                         {"study.csv", "study.json", "manifest.json"})
        notes = self.folder / "notes.txt"
        notes.write_text("mine")
        done = study(*grid, self.folder)
        self.assertEqual(done.returncode, 1)
        self.assertIn("notes.txt", done.stderr)
        self.assertEqual(done.stdout, "")  # told before anything runs
        notes.unlink()
        (self.folder / "study.csv").write_text("changed by hand")
        self.assertEqual(study(*grid, self.folder).returncode, 1)
        self.assertEqual((self.folder / "study.csv").read_text(), "changed by hand")

    def test_killed_it_leaves_the_earlier_results(self):
        grid = [SCENES / "paper" / "two_forces.json", "--vary", "dt=0.01,0.02", "--out", self.folder]
        self.assertEqual(study(*grid, "--set", "/end_time=0.05").returncode, 0)
        before = {p.name: p.read_bytes() for p in self.folder.iterdir()}
        process = subprocess.Popen([QUOIN, "study", *map(str, grid), "--set", "/end_time=1000"],
                                   stdout=subprocess.DEVNULL)
        deadline = time.monotonic() + 60
        while not list(self.folder.parent.glob("out.part-*")) and time.monotonic() < deadline:
            time.sleep(0.01)
        process.kill()
        process.wait()
        self.assertEqual({p.name: p.read_bytes() for p in self.folder.iterdir()}, before)
        (self.folder.parent / "out.part-abcdef").mkdir()  # killed right after it was made
        self.assertEqual(study(*grid, "--set", "/end_time=0.05").returncode, 0)
        self.assertEqual([p.name for p in self.folder.parent.iterdir()], ["out"])  # swept


unittest.main(argv=[sys.argv[0]], verbosity=2)
