"""A test case with a folder of its own, in which it runs the command (the first argument of the test)."""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest


READ_BY_VTK = """
import json, sys
from vtkmodules import vtkIOXML
def read(path):
    kind = {"vtu": "UnstructuredGrid", "vtp": "PolyData"}[path[-3:]] if path[-4] == "." else {
        "pvtu": "PUnstructuredGrid", "pvtp": "PPolyData"}[path[-4:]]
    reader = getattr(vtkIOXML, f"vtkXML{kind}Reader")()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()
grid = read(sys.argv[1])
data = grid.GetCellData()
name, stress = data.GetAbstractArray("name"), data.GetArray("stress")
print(json.dumps({"points": grid.GetNumberOfPoints(),
                  "name": [name.GetValue(i) for i in range(grid.GetNumberOfCells())],
                  "stress": [stress.GetTuple(i) for i in range(grid.GetNumberOfCells())],
                  "contacts": read(sys.argv[2]).GetNumberOfVerts()}))
"""


def read_by_vtk(blocks, contacts):
    """By VTK itself, in the Python of the system; None where python3-vtk9 is not installed."""
    done = subprocess.run(["/usr/bin/python3", "-c", READ_BY_VTK, blocks, contacts], capture_output=True, text=True, timeout=60)
    if "No module named 'vtkmodules'" in done.stderr or "No such file" in done.stderr:
        print("skipped: VTK's own reader, python3-vtk9 is not installed", file=sys.stderr)
        return None
    if done.returncode:
        raise AssertionError(done.stderr)
    return json.loads(done.stdout)


def box(low, high):
    return {"type": "box", "min": list(low), "max": list(high)}


def block(name, low, high, kind="rigid", **more):
    """A box of stone."""
    return {"name": name, "kind": kind, "material": "stone", "shape": box(low, high), **more}


def flags_of(summary):
    return [(flag["flag"], flag["fails"]) for flag in summary["flags"]]


class FolderTest(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)

    def quoin(self, *words, code=None, err=(), out=(), says=None, limits=None, **options):
        """Runs the command in the folder. `code`: how it has to end; `err`, `out`: words that have to
        stand on standard error and output; `says`: all of standard error; `limits`: of bash."""
        shell = ["bash", "-c", limits + '; exec "$@"', "-"] if limits else []
        done = subprocess.run([*shell, pathlib.Path(sys.argv[1]).resolve(), *map(str, words)],
                              **{"capture_output": True, "text": True, "timeout": 300,
                                 "cwd": self.folder, **options})
        if code is not None:
            self.assertEqual(done.returncode, code, f"{done.stdout}{done.stderr}")
        for said, wanted in ((done.stderr, err), (done.stdout, out)):
            for text in [wanted] if isinstance(wanted, str) else wanted:
                self.assertIn(text, said)
        if says is not None:
            self.assertEqual(done.stderr, says)
        return done

    def written(self, scene):
        path = self.folder / "scene.json"
        path.write_text(json.dumps(scene))
        return path

    def told(self, *words, code=0, **wanted):
        """What the command tells with --json."""
        return json.loads(self.quoin(*words, "--json", code=code, **wanted).stdout)

    def run_scene(self, scene, *options, code=0, **wanted):
        """The summary of a run whose results are in the folder `out`."""
        return self.told("run", self.written(scene), "--out", "out", *options, code=code, **wanted)

    def summary(self, out="out"):
        return json.loads((self.folder / out / "summary.json").read_text())

    def rows(self, name, out="out"):
        """Of a CSV file of results."""
        with open(self.folder / out / name, encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))
