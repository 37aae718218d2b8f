"""`quoin picture` and `quoin plot`: a still, a GIF by pillow, an MP4 where ffmpeg is, a clear line where not."""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import unittest

from folder_test import FolderTest

QUOIN, SOURCE = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
CASES = SOURCE / "tools" / "scenes" / "cases"
SIZE = "from PIL import Image; i = Image.open(sys.argv[1]); print(i.n_frames, *i.size)"
DIFFER = """
import numpy
from PIL import Image
near, far = (numpy.asarray(Image.open(path).convert("L"), dtype=float) for path in sys.argv[1:])
print(numpy.mean(numpy.abs(near - far) > 8))
"""
DRAWN = """
from run_output import Blocks
blocks = Blocks(sys.argv[1])
print([bool(faces) for faces in blocks.faces])
"""
LEGEND = """
import picture
times = [time for time, _ in picture.series(sys.argv[1], "blocks")]
figure = picture.plt.figure()
picture.add_legend(figure, list(picture.frames_of(sys.argv[1], times)))
print(*(entry.get_text() for entry in figure.legends[0].get_texts()))
"""
COMPRESSION = """
import picture
*_, frame = picture.frames_of(sys.argv[1], [9])
print(*picture.QUANTITIES["compression"][1](frame))
"""
SECTIONS = """
import plot_run
joints = plot_run.Contacts(plot_run.series(sys.argv[1], "contacts")[-1][1]).joints
chain = plot_run.chain_of(joints, plot_run.Blocks(plot_run.series(sys.argv[1], "blocks")[-1][1]))
edges = plot_run.edge_stresses(sys.argv[1])
for number, ends in sorted(zip(chain, plot_run.thrust_band(joints, chain, [0, 2])), key=lambda entry: entry[1][0][2]):
    joint = joints[number]
    print(*sorted(ends[:, 0]), *ends[:, 2], joint["centre"][0], edges[joint["a"], joint["b"]])
"""
EXACT = """
import numpy
import picture
drawn, raster = [], picture.raster
picture.raster = lambda *words: drawn.append(raster(*words)) or drawn[-1]
picture.main()
shown = numpy.asarray(picture.plt.imread(sys.argv[2])[..., :3] * 255 + 0.5, dtype="u1")
for number, (image, _) in enumerate(drawn):
    (high, wide), (row, column) = image.shape[:2], divmod(number, 2)
    top, left = picture.TITLE + row * (high + picture.TITLE), 3 + column * (shown.shape[1] // 2)
    print((shown[top:top + high, left:left + wide] == image).all())
"""
JOINTS = """
import csv
import plot_run
run = sys.argv[1]
blocks = plot_run.Blocks(plot_run.series(run, "blocks")[-1][1])
joints = plot_run.Contacts(plot_run.series(run, "contacts")[-1][1]).joints
chain = plot_run.chain_of(joints, blocks)
with open(run + "/joints.csv", encoding="utf-8") as file:
    rows = {(int(row["a"]), int(row["b"])): row for row in csv.DictReader(file)}
for number in chain:
    joint = joints[number]
    row = rows[joint["a"], joint["b"]]
    for one, other in ((joint["normal"], "normal_force"), (joint["shear"], "shear_force"),
                       (joint["normal"] / joint["area"], "normal_stress")):
        print(one, row[other])
"""
LABELS = """
import run_output
print(*run_output.frame_labels(sys.argv[1]), sep="\\n")
"""
DENSE = """
import plot_run
plot_run.MOST_LINES = 5
plot_run.save = lambda figure, path: print(figure._suptitle.get_text()) if path.name == "thrust.png" else None
plot_run.main()
"""


def python(snippet, *words):
    """What a program prints that finds the modules of tools."""
    start = "import sys\nsys.path.insert(0, sys.argv.pop(1))\n"
    return subprocess.run(["/usr/bin/python3", "-c", start + snippet, SOURCE / "tools", *words], check=True, capture_output=True,
                          text=True, env={**os.environ, "QUOIN": str(QUOIN)}).stdout


class Pictures(FolderTest):
    def made(self, *words):
        self.quoin("make", *words, "--out", "made.json", code=0)
        return self.folder / "made.json"

    def run_scene(self, name, *arguments):
        self.quoin("run", CASES / name, "--out", "run", *arguments, code=0)

    def picture(self, name, *arguments, path=None, **wanted):
        environment = {**os.environ, **({"PATH": path} if path else {})}
        return self.quoin("picture", self.folder / "run", self.folder / name, *arguments, env=environment, **wanted)

    def plotted(self):
        self.quoin("plot", "run", "--out", "plots", code=0, says="")

    def one_line(self, done):
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)

    def test_still_and_gif(self):
        self.run_scene("stage_released.json", "--set", "/output_interval=0.3")
        for name, frames in (("p.png", 1), ("p.gif", 7)):  # 0, 0.3, 0.5 (end of a stage), 0.6, … 1.5 s
            self.picture(name, code=0, says="")
            said = python(SIZE, self.folder / name).split()
            self.assertEqual(int(said[0]), frames)
            self.assertGreaterEqual(int(said[1]), 600)

    def test_mp4_needs_ffmpeg_and_says_so(self):
        self.run_scene("stage_released.json", "--set", "/output_interval=0.3")
        if shutil.which("ffmpeg"):
            self.picture("p.mp4", code=0, says="")
            self.assertIn(b"ftyp", (self.folder / "p.mp4").read_bytes()[:12])
        bare = self.folder / "bin"
        bare.mkdir()
        for tool in ("python3", "sh"):
            (bare / tool).symlink_to(f"/usr/bin/{tool}")
        self.one_line(self.picture("q.mp4", path=str(bare), code=1, err="ffmpeg"))
        self.assertFalse((self.folder / "q.mp4").exists())
        self.picture("q.gif", path=str(bare), code=0)

    def test_legend_of_contact_states(self):
        known = {"softening.json": {"open", "slip", "failed"}, "direct_shear.json": {"stick"},
                 "friction_ten_rigid.json": {"open", "stick", "slip"}}  # new contacts, but no strength to lose
        for scene, states in known.items():
            self.run_scene(scene)
            said = python(LEGEND, self.folder / "run")
            self.assertEqual(set(said.split()), states)

    def refused(self, words, name, *arguments, code=2):
        self.one_line(self.picture(name, *arguments, code=code, err=words))

    def test_what_can_not_be_drawn_is_told_in_a_line(self):
        self.run_scene("softening.json", "--set", "/output_interval=0.01")
        self.refused("--times 9: the run goes from 0 to 0.05 s", "p.png", "--times", "0", "9")
        self.refused("--times nan: the run goes from 0", "p.png", "--times", "nan")
        self.refused("--scale", "p.png", "--scale", "nan")
        self.refused("--from", "p.png", "--from", "nan", "0", "1")
        self.refused("must end in .png, .gif or .mp4", "p.jpg")
        for name in ("none/p.png", "none/p.gif"):
            self.refused("No such file or directory", name, code=1)
        out = self.folder / "is_a_file"
        out.touch()
        self.one_line(self.quoin("plot", "run", "--out", out, code=1))
        run = self.folder / "run"
        for name in ("blocks_000001.vtu", "contacts_000002.vtp", "blocks.pvd"):
            os.truncate(run / name, 300)
            self.refused(f"{run / name}: is not as quoin run wrote it", "p.png", "--times", "0.01", "0.02",
                         code=1)
            shutil.copy(run / "blocks_000000.vtu", run / "blocks_000001.vtu")
        (run / "contacts_000002.vtp").unlink()
        os.truncate(run / "history.csv", 0)
        self.one_line(self.quoin("plot", run, "--out", ".", code=1, err=f"{run / 'history.csv'}: is not as quoin run wrote it"))

    def test_absent_blocks_are_not_drawn(self):
        self.run_scene("stage_column.json")
        frames = sorted((self.folder / "run").glob("blocks_*.vtu"))
        said = [python(DRAWN, frame).strip() for frame in frames]
        self.assertEqual(said[0], str([True] * 5))
        self.assertEqual(said[-1], str([True, True, True, False, True]))
        self.picture("p.png", "--forces", "--contacts", code=0)
        self.plotted()

    def test_panels_show_the_pixels_that_were_drawn(self):
        self.run_scene("stage_released.json", "--set", "/output_interval=0.3")
        said = python(EXACT, self.folder / "run", self.folder / "p.png")
        self.assertEqual(said.split(), ["True"] * 4)

    def test_plot_of_a_run(self):
        self.run_scene("group_stress.json")
        self.plotted()

    def test_compression_of_a_tower(self):
        self.run_scene(self.made("tower", "--blocks", "4"))
        said = python(COMPRESSION, self.folder / "run").split()
        for above, found in zip((3, 2, 1, 0), said[1:], strict=True):  # the ground is first
            self.assertAlmostEqual(float(found), 2400 * 9.81 * 0.5 * (above + 0.5), places=3)

    def test_far_from_the_origin_as_near(self):
        """In millions of metres single precision leaves no depth of a block of one."""
        scene, shown = self.made("tower", "--blocks", "2"), []
        tower = json.loads(scene.read_text())
        for far in (0, 4194304):
            for block in tower["blocks"]:
                for end in ("min", "max"):
                    block["shape"][end][0] += far
            scene.write_text(json.dumps(tower))
            self.run_scene(scene)
            shown.append(self.folder / f"{far}.png")
            self.picture(shown[-1], "--times", "0", code=0, says="")
        said = python(DIFFER, *shown)
        self.assertLess(float(said), 1e-3)  # of the pixels, where edges are rounded
        self.refused("--hide: must name some, not all, of the blocks 0 … 2", "p.png", "--hide", "3")

    def test_sections_of_a_pushed_tower(self):
        """Where the thrust line runs, which part of each joint bears, and its edge stress, in closed form."""
        scene = self.made("tower", "--blocks", "4")
        pushed = [{"type": "point", "block": block, "point": [0.5, 0.5, z], "force": [force, 0, 0]}
                  for block, z, force in (("drum3", 2, 1000), ("drum1", 1, 7000))]
        self.run_scene(scene, "--set", f"/loads={json.dumps(pushed)}")
        said = python(SECTIONS, self.folder / "run").splitlines()
        for line, z in zip(said, (0, 0.5, 1, 1.5), strict=True):
            weight = 2400 * 9.81 * (2 - z)  # of a section of 1 m2
            off = (1000 * (2 - z) + 7000 * max(0, 1 - z)) / weight
            bears = min(1, 3 * (0.5 - off))
            edge = weight * (1 + 6 * off) if off < 1 / 6 else 2 * weight / bears
            for found, exact in zip(map(float, line.split()), (1 - bears, 1, z, z, 0.5 + off, edge), strict=True):
                self.assertAlmostEqual(found, exact, delta=1e-9 * max(1, exact))
        self.plotted()
        self.assertTrue((self.folder / "plots" / "diagrams.png").exists())

    def test_joints_of_a_plot_are_those_of_the_run(self):
        self.run_scene(self.made("arch"))
        said = python(JOINTS, self.folder / "run").splitlines()
        self.assertGreater(len(said), 40)
        for line in said:
            found, exact = map(float, line.split())
            self.assertAlmostEqual(found, exact, delta=1e-9 * max(1, abs(exact)))

    def test_stages_are_told(self):
        self.run_scene("stage_released.json", "--set", "/output_interval=0.3")
        said = python(LABELS, self.folder / "run").splitlines()
        self.assertEqual(said[0], "start")
        self.assertTrue(said[-1].startswith("end of"))
        self.assertEqual(len([label for label in said if label.startswith("end of")]), 2)

    def test_plot_of_many_joints(self):
        self.run_scene(self.made("wall", "--length", "2", "--height", "1"))
        self.assertIn("largest compression of each block", python(DENSE, self.folder / "run", "--out", self.folder / "plots"))


if subprocess.run(["/usr/bin/python3", "-c", "import matplotlib, PIL"], capture_output=True).returncode:
    print("skipped: no matplotlib")
else:
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
