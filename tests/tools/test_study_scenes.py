"""The scenes of tools/scenes/study are what their generator writes, and meet their references."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

QUOIN, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
SCENES = SOURCE / "tools" / "scenes" / "study"


class StudyScenes(unittest.TestCase):
    def test_are_what_the_generator_writes(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([sys.executable, SOURCE / "tools" / "make_study_scenes.py", folder],
                           check=True)
            made = {p.name: json.loads("\n".join(p.read_text().splitlines()[1:]))
                    for p in pathlib.Path(folder).iterdir()}
        kept = {p.name: json.loads("\n".join(p.read_text().splitlines()[1:]))
                for p in SCENES.iterdir()}
        self.assertEqual(made.keys(), kept.keys())
        for name, scene in kept.items():
            self.assert_same(scene, made[name], name)

    def assert_same(self, a, b, where):
        """Numbers within rounding: libm differs in the last digit."""
        if isinstance(a, dict):
            self.assertEqual(a.keys(), b.keys(), where)
            for key in a:
                self.assert_same(a[key], b[key], f"{where}/{key}")
        elif isinstance(a, list):
            self.assertEqual(len(a), len(b), where)
            for i, (x, y) in enumerate(zip(a, b)):
                self.assert_same(x, y, f"{where}/{i}")
        elif isinstance(a, float):
            self.assertAlmostEqual(a, b, delta=1e-12, msg=where)
        elif not (isinstance(a, str) and a.startswith("=")):  # an expression holds such digits too
            self.assertEqual(a, b, where)

    def test_meet_their_references(self):
        for scene in sorted(SCENES.iterdir()):
            done = subprocess.run([QUOIN, "run", scene, "--json"], capture_output=True, text=True,
                                  timeout=120)
            self.assertEqual(done.returncode, 0, done.stderr)
            summary = json.loads(done.stdout)
            self.assertEqual(summary["status"], "completed", scene.name)
            for reference in summary["references"]:
                self.assertTrue(reference["ok"], f"{scene.name}: {reference}")
            self.assertLess(summary["largest_overlap"], 1e-12, scene.name)


unittest.main(argv=[sys.argv[0]], verbosity=2)
