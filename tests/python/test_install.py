"""`pip install .` without a network: the wheel's name, and the module from a virtual environment in an empty folder."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

source, build, version = pathlib.Path(sys.argv.pop(1)), sys.argv.pop(1), sys.argv.pop(1)
PROGRAM = """
import quoin
print(quoin.__version__, quoin.Shape.box([0, 0, 0], [1, 2, 3]).volume, quoin.__file__)
scene = quoin.Scene(blocks=[], end_time=1.0)
scene.add(quoin.Shape.box([0, 0, 0], [1, 1, 1]), kind="fixed")
assert "iframe" in quoin.view(scene)._repr_html_()
"""


class Install(unittest.TestCase):
    def test_wheel_and_module(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            copy = folder / "source"  # pip builds within the tree that it is given
            for part in ("pyproject.toml", "setup.py", "tools/python/README.md", "tools/view.py", "tools/run_output.py",
                         "tools/viewer/dist/page.html"):
                (copy / part).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(source / part, copy / part)
            shutil.copytree(source / "tools/python/src", copy / "tools/python/src")
            environment = {**os.environ, "QUOIN_BUILD_FOLDER": build}
            environment.pop("PYTHONPATH", None)

            def run(*command):
                done = subprocess.run(command, cwd=folder, env=environment, text=True, capture_output=True)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                return done.stdout

            run(sys.executable, "-m", "venv", "--system-site-packages", "venv")
            pip = (folder / "venv/bin/python", "-m", "pip", "--disable-pip-version-check")
            run(*pip, "wheel", "./source", "--no-build-isolation", "--no-deps", "--no-index", "-w", "wheels")
            wheels = [path.name for path in (folder / "wheels").iterdir()]
            python = f"cp{sys.version_info.major}{sys.version_info.minor}"
            self.assertEqual(len(wheels), 1)
            self.assertRegex(wheels[0], rf"^quoin-{version}-{python}-{python}-linux_\w+\.whl$")
            run(*pip, "install", "--no-index", "--no-deps", f"wheels/{wheels[0]}")
            said = run(folder / "venv/bin/python", "-c", PROGRAM)
            self.assertRegex(said, rf"^{version} 6.0 {folder}/venv/")
            for file in ("_quoin.pyi", "py.typed"):
                self.assertTrue(list((folder / "venv/lib").glob(f"python3*/site-packages/quoin/{file}")), file)


if __name__ == "__main__":
    unittest.main()
