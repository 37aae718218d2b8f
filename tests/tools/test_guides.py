"""Every command of the guides runs, and makes the pictures that they show and the numbers they state."""
import csv
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

QUOIN, SOURCE = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
GUIDES = SOURCE / "tools" / "guides"
KEEP = os.environ.get("QUOIN_GUIDES_OUT")  # a folder that keeps what the guides made


class Guides(unittest.TestCase):
    def follow(self, name):
        """The folder after all commands of the guide."""
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        folder = pathlib.Path(holder.name) / "guides"
        shutil.copytree(GUIDES, folder)
        text = (GUIDES / f"{name}.md").read_text(encoding="utf-8")
        blocks = re.findall(r"```sh\n(.*?)```", text, re.S)
        self.assertTrue(blocks)
        path = os.pathsep.join([str(QUOIN.parent), os.environ["PATH"]])
        self.said = ""
        for commands in blocks:
            done = subprocess.run(["bash", "-euo", "pipefail", "-c", commands], cwd=folder, text=True,
                                  capture_output=True, timeout=120, env={**os.environ, "PATH": path})
            self.assertEqual(done.returncode, 0, f"{commands}\n{done.stdout}\n{done.stderr}")
            self.said += done.stdout
        for picture in re.findall(r"\]\(pictures/(\S+)\)", text):
            made = list(folder.glob(f"**/{picture}"))
            fresh = [p for p in made if p.parent.name != "pictures"]
            self.assertEqual(len(fresh), 1, picture)
            self.assertGreater(fresh[0].stat().st_size, 5000)
            if KEEP:
                shutil.copy(fresh[0], KEEP)
        return folder

    def summary(self, folder, run):
        return json.loads((folder / run / "summary.json").read_text(encoding="utf-8"))

    def test_minimal_scene(self):
        summary = self.summary(self.follow("minimal_scene"), "minimal")
        self.assertAlmostEqual(summary["monitors"]["block"]["displacement"][0], 0.560, delta=5e-3)

    def test_arch(self):
        summary = self.summary(self.follow("arch"), "arch")
        self.assertIn("23 blocks, 23 convex", self.said)
        self.assertIn("touching pairs: 22,", self.said)
        self.assertNotIn("without support", self.said)
        self.assertAlmostEqual(summary["base_reaction"][2] / summary["blocks"]["weight"][2], 1, places=6)

    def test_limit(self):
        folder = self.follow("limit")
        stated = {name: value for name, value in re.findall(
            r"`(\w+)` \| ([0-9.]+)", (GUIDES / "limit.md").read_text(encoding="utf-8"))}
        self.assertEqual(sorted(stated), ["arch", "wall", "wedge"])
        for name, value in stated.items():
            report = json.loads((folder / name / "limit.json").read_text(encoding="utf-8"))
            for side in ("stands", "falls"):
                self.assertAlmostEqual(report[side]["value"] / float(value), 1, delta=3e-4)

    def test_shaking_wall(self):
        summary = self.summary(self.follow("shaking_wall"), "wall")
        self.assertEqual(summary["blocks"]["prescribed"], 1)
        self.assertEqual(summary["flags"], [])

    def test_slope_wedge(self):
        summary = self.summary(self.follow("slope_wedge"), "slope")
        moved = summary["monitors"]["wedge"]["displacement"]
        self.assertAlmostEqual(sum(u * u for u in moved) ** 0.5, 0.745, places=3)

    def test_rock_slope(self):
        folder = self.follow("rock_slope")
        dry, wet = (json.loads((folder / name / "limit.json").read_text(encoding="utf-8")) for name in ("dry", "wet"))
        self.assertAlmostEqual(dry["stands"]["value"], math.tan(math.radians(40)) / math.tan(math.radians(35)), delta=2e-4)
        self.assertAlmostEqual(wet["falls"]["value"], 0.943, delta=1e-3)
        stages = self.summary(folder, "rock_slope")["stages"]
        self.assertEqual([stage.get("verdict") for stage in stages], ["rest", "rest", "mechanism", None])
        self.assertGreater(len(stages[2]["loose"]), 2)
        self.assertIn("28 rigid, 1 fixed", self.said)

    def test_tunnel(self):
        folder = self.follow("tunnel")
        summary = self.summary(folder, "tunnel")
        self.assertEqual([stage.get("verdict") for stage in summary["stages"]], ["rest"] * 4 + ["mechanism", None])
        gone = [summary["stages"][1]["removed"], summary["stages"][2]["removed"], summary["stages"][4]["loose"]]
        self.assertEqual([len(names) for names in gone], [1, 1, 1])
        with open(folder / "tunnel" / "blocks.csv", encoding="utf-8") as file:
            weight = next(float(row["mass"]) * 9.81 for row in csv.DictReader(file) if row["name"] == gone[2][0])
        up = sum(tie["force"] for tie in summary["ties"]) * 3.9 / math.hypot(3.9, 1)
        self.assertAlmostEqual(up / weight, 1, delta=1e-3)
        self.assertAlmostEqual(weight, 425060, delta=10)

    def test_bridge(self):
        folder = self.follow("bridge")
        self.assertRegex(self.said, r"least thrust: not admissible at 784")
        alone, tied = (self.summary(folder, name) for name in ("alone", "tied"))
        self.assertEqual(alone["flags"] + tied["flags"], [])
        for summary, stated in ((alone, 83), (tied, 36)):
            self.assertAlmostEqual(summary["monitors"]["thrust"]["force"][0] / 1e3, stated, delta=6)
        self.assertAlmostEqual(tied["ties"][0]["force"] / 1e3, 52.9, delta=0.5)
        self.assertAlmostEqual(alone["monitors"]["crown"]["displacement"][2], -0.018, delta=5e-4)


if subprocess.run(["/usr/bin/python3", "-c", "import matplotlib"], capture_output=True).returncode:
    print("skipped: no matplotlib")
else:
    unittest.main(argv=[sys.argv[0]], verbosity=2)
