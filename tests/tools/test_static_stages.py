"""Static stages end with a verdict; stages have their own clock; every frame has its own time."""
import csv
import json
import math
import re
import subprocess
import sys
import unittest

from folder_test import FolderTest

QUOIN = sys.argv[1]


def slope(friction, stages, **more):
    a = math.radians(20)
    return {"materials": {"rock": {"density": 2500, "young": 5e9, "poisson": 0.2}},
            "joint": {"friction_angle_deg": friction}, "time_step": 0.01, "stages": stages,
            "gravity": [9.81 * math.sin(a), 0, -9.81 * math.cos(a)],
            "monitors": [{"name": "block", "block": "block"}],
            "blocks": [{"name": "plane", "kind": "fixed",
                        "shape": {"type": "box", "min": [-5, -5, -1], "max": [5, 5, 0]}},
                       {"name": "block", "kind": "rigid", "material": "rock",
                        "shape": {"type": "box", "min": [0, 0, 0], "max": [1, 1, 1]}}], **more}


class StaticStages(FolderTest):
    def run_scene(self, scene, *arguments):
        path = self.folder / "scene.json"
        path.write_text(json.dumps(scene))
        return subprocess.run([QUOIN, "run", path, *map(str, arguments)], capture_output=True, text=True,
                              timeout=120)

    def test_mechanism(self):
        seen = []
        for time_step in (1e-4, 1.0):
            done = self.run_scene(slope(19, [{"analysis": "static"}]), "--json", "--set", f"/time_step={time_step}")
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, 'mechanism: block "block" has moved by 0\\.1')
            summary = json.loads(done.stdout)
            self.assertEqual(summary["status"], "mechanism")
            stage = summary["stages"][0]
            self.assertEqual((stage["verdict"], stage["travel_block"]), ("mechanism", "block"))
            unbalance = math.sin(math.radians(20)) - math.tan(math.radians(19)) * math.cos(math.radians(20))
            self.assertAlmostEqual(stage["unbalance"], unbalance, delta=1e-6)
            seen.append(stage)
        self.assertEqual(*seen)

    def test_rest(self):
        done = self.run_scene(slope(21, [{"analysis": "static"}]))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, "stage 0: rest, unbalance [0-9.e-]+ in [0-9]+ steps")
        self.assertIn("stage 0: mechanism", self.run_scene(slope(19, [{"analysis": "static"}])).stdout)

    def test_settle_then_shake(self):
        """The same shaking by t and, in a later stage, by stage_time."""
        def shaken(clock, *before):
            scene = slope(21, [{"analysis": "settle"}, *before, {"analysis": "dynamic", "end_time": 0.5 + 0.2 * len(before)}])
            push = {"type": "point", "block": "block", "point": [0.5, 0.5, 0.5],
                    "force": {"formula": [f"2e4*sin(20*{clock})", "0", "0"]}}
            out = self.folder / "out"
            done = self.run_scene({**scene, "loads": [push]}, "--json", "--out", out)
            self.assertEqual(done.returncode, 0, done.stderr)
            return json.loads(done.stdout)["monitors"]["block"]["displacement"][0]
        by_t = shaken("t")
        self.assertGreater(by_t, 1e-3)
        self.assertAlmostEqual(shaken("stage_time"), by_t, delta=1e-12)
        still = slope(21, [{"analysis": "dynamic", "end_time": 0.2}])
        self.assertEqual(self.run_scene(still).returncode, 0)
        twice = shaken("stage_time", {"analysis": "dynamic", "end_time": 0.2})
        self.assertNotAlmostEqual(twice, by_t, delta=1e-4)  # shaken for 0.2 s before

    def test_every_frame_has_its_own_time(self):
        out = self.folder / "out"
        stages = [{"analysis": "settle"}, {"analysis": "static"}, {"analysis": "dynamic", "end_time": 0.1},
                  {"analysis": "static"}]
        done = self.run_scene(slope(21, stages, output_interval=0.05), "--out", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        times = [float(t) for t in re.findall('timestep="([^"]+)"', (out / "blocks.pvd").read_text())]
        self.assertEqual(len(set(times)), 6)
        for time, wanted in zip(times, (0, 5e-5, 1e-4, 0.05, 0.1, 0.10005)):
            self.assertAlmostEqual(time, wanted, delta=1e-12)
        rows = csv.DictReader((out / "blocks.csv").read_text().splitlines())
        stages_of_rows = {row["stage"]: float(row["time"]) for row in rows}
        for stage, wanted in zip("0123", (0, 0, 0.1, 0.1)):
            self.assertAlmostEqual(stages_of_rows[stage], wanted, delta=1e-12)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
