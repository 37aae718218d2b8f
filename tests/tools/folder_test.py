"""A test case with a folder of its own, in which it runs the command (the first argument of the test)."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest


class FolderTest(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)

    def quoin(self, *words):
        return subprocess.run([pathlib.Path(sys.argv[1]).resolve(), *map(str, words)], capture_output=True, text=True,
                              timeout=300, cwd=self.folder)

    def written(self, scene):
        path = self.folder / "scene.json"
        path.write_text(json.dumps(scene))
        return path

    def told(self, *words, code=0):
        """What the command tells with --json."""
        done = self.quoin(*words, "--json")
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return json.loads(done.stdout)
