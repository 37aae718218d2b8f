"""Each scene in broken/ is refused with one line that says what is wrong and where: the first line of
the file. Exit code 2, no output folder."""
import fnmatch
import pathlib
import subprocess
import sys
import tempfile

quoin = sys.argv[1]
scenes = sorted((pathlib.Path(__file__).parent / "broken").glob("*.json"))
failures = 0
for scene in scenes:
    expected = scene.read_text(encoding="utf-8").splitlines()[0].removeprefix("// expected: ")
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out"
        done = subprocess.run([quoin, "run", str(scene), "--out", str(out)], capture_output=True,
                              text=True, timeout=60)
        left = list(pathlib.Path(folder).iterdir())
    lines = done.stderr.splitlines()
    said = lines[0].removeprefix(f"{scene}: ") if lines else ""
    pattern = expected.replace("[", "[[]")
    right = (done.returncode == 2 and len(lines) == 1 and not done.stdout and not left
             and lines[0].startswith(str(scene)) and fnmatch.fnmatchcase(said, pattern))
    failures += not right
    print(f"{'ok    ' if right else 'WRONG '} {scene.name}: exit {done.returncode}: {done.stderr.strip()}"
          + ("" if right else f"\n       expected: {expected}; left behind: {left}"))
print(f"{len(scenes)} broken scenes, {failures} not refused as they should be")
sys.exit(1 if failures or len(scenes) < 10 else 0)
