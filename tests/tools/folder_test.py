"""A test case with a folder of its own, in which it runs the command (the first argument of the test)."""
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
