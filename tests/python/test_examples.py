"""Each example, small: it runs, and leaves its picture."""
import pathlib
import subprocess
import sys
import tempfile

examples = pathlib.Path(sys.argv[1]) / "tools/python/examples"
SMALL = {"hull_clouds.py": ["--count", "40"], "falling_compounds.py": ["--count", "3", "--steps", "200"],
         "narrow_phase_error.py": ["--count", "50"], "rock_slope.py": ["--count", "40"],
         "tilting_wall.py": ["--courses", "3", "--bricks", "2"]}
if sorted(SMALL) != sorted(path.name for path in examples.glob("*.py")):
    sys.exit("an example has no small size here")
for name, small in SMALL.items():
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, examples / name, *small], cwd=folder, check=True)
        if not list(pathlib.Path(folder).glob("*.png")):
            sys.exit(f"{name} left no picture")
