"""`mpirun -n 1, 2, 4 quoin run --mpi`: the answer of one process, files in pieces, one end for all ranks."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
import unittest
import xml.etree.ElementTree as xml

QUOIN, SOURCE, MPIRUN = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
INCLINE = SOURCE / "tools" / "scenes" / "paper" / "incline.json"
sys.path += [str(SOURCE / "tools"), str(SOURCE / "tests" / "tools")]
import vtk_file  # noqa: E402
from folder_test import FolderTest, block, read_by_vtk  # noqa: E402

SLIDE = {"materials": {"stone": {"density": 2400}}, "joint": {"friction_angle_deg": 20},
         "time_step": 0.01, "end_time": 0.06, "blocks": [block("ground", [-5, -5, -1], [5, 5, 0], "fixed"),
                                                         block("slider", [0, 0, 0], [1, 1, 1], velocity=[1, 0.5, 0])]}
# A fixed base that stages release, with what a block of another process bears on it.
STONE, BASE = block("stone", [0, 0, 0], [1, 1, 1]), block("base", [-1, 0, -1], [11, 1, 0], "fixed")
GROUND = block("ground", [-20, -10, -2], [40, 10, -1], "fixed")
RELEASED = {"materials": {"stone": {"density": 2500}}, "joint": {"friction_angle_deg": 30}, "time_step": 0.01,
            "blocks": [STONE, BASE, GROUND], "stages": [
                {"name": "held", "analysis": "dynamic", "duration": 0.1},
                {"name": "free", "analysis": "dynamic", "duration": 0.2,
                 "overrides": [{"blocks": "base", "kind": "rigid"}]}]}
PUSH = {"type": "body", "block": "stone"}
SUNK = block("stone", [0, 0, -0.002], [1, 1, 1])
GLUED = {"gravity": [0, 0, 0], "blocks": [STONE, BASE], "loads": [{**PUSH, "force": [0, 0, 2500]}],
         "joint": {"friction_angle_deg": 30, "cohesion": 1e6, "tension": 1e6}}
FILES = ("blocks.csv", "contacts.csv", "history.csv")
PLACES = ("x", "y", "z", "ux", "uy", "uz", "rx", "ry", "rz", "vx", "vy", "vz")
READ_BY_PICTURE = """
import sys
sys.path.insert(0, sys.argv[1])
import numpy, run_output
one = run_output.Blocks(sys.argv[2] + "/blocks_000001.vtu")
parts = run_output.Blocks(sys.argv[3] + "/blocks_000001.pvtu")
corners = lambda blocks: [[blocks.points[f].tolist() for f in faces] for faces in blocks.faces]
assert corners(one) == corners(parts) and list(one.kind) == list(parts.kind)
pairs = [sorted(run_output.Contacts(p).pair.tolist()) for p in (sys.argv[2] + "/contacts_000001.vtp",
                                                                sys.argv[3] + "/contacts_000001.pvtp")]
assert pairs[0] == pairs[1]
"""


def run(ranks, *arguments, wrapper=()):
    """`wrapper`: what stands before the command of the last rank."""
    command = [QUOIN, "run", "--mpi", *map(str, arguments)]
    line = [MPIRUN, "-n", str(ranks), *command]
    if wrapper:
        line = [MPIRUN, "-n", str(ranks - 1), *command, ":", "-n", "1", *wrapper, *command]
    return subprocess.run(line, capture_output=True, text=True, timeout=100)


def own_lines(done):
    """What quoin says; mpirun has its own lines."""
    return [line for line in done.stderr.splitlines() if line.startswith("quoin: ") or ".json: " in line]


def runs(process):
    try:
        return pathlib.Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] not in "ZX"
    except FileNotFoundError:
        return False


class MpiRun(FolderTest):
    def make(self, kind, *arguments):
        scene = self.folder / f"{kind}.json"
        self.quoin("make", kind, "--out", scene, *arguments, code=0)
        return scene

    def alone(self, scene, *arguments, ends=(0,)):
        done = self.quoin("run", scene, "--out", "alone", *arguments)
        self.assertIn(done.returncode, ends, done.stderr)
        return self.folder / "alone"

    def check_bits(self, one, out):
        for file in FILES:
            with self.subTest(out=out.name, file=file):
                self.assertEqual((one / file).read_bytes(), (out / file).read_bytes())

    def check_same(self, scene, solvers, *arguments, least_motion):
        one = self.alone(scene, *arguments)
        for ranks, linear in zip((1, 2, 4), solvers):
            with self.subTest(scene=scene.name, ranks=ranks, linear=linear):
                out = self.folder / f"{linear}_{ranks}"
                done = run(ranks, scene, "--out", out, "--json", "--set", f"/linear_solver={linear}", *arguments)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(own_lines(done), [])
                summary = json.loads(done.stdout)  # of one rank alone
                self.assertEqual(summary["status"], "completed")
                self.assertGreater(summary["linear_solver"]["distributed"], 0)
                self.assertEqual(summary["linear_solver"]["multigrid_iterations"] > 0, linear == "multigrid")
                self.assertLess(self.difference(one, out, least_motion), 1e-9)
                shutil.rmtree(out)

    def difference(self, one, other, least_motion):
        tables = [self.rows("blocks.csv", out) for out in (one, other)]
        self.assertEqual(*(len(table) for table in tables))
        moved = max(abs(float(row[k])) for row in tables[0] for k in ("ux", "uy", "uz"))
        self.assertGreater(moved, least_motion)  # there is something to compare
        return max(abs(float(a[k]) - float(b[k])) for a, b in zip(*tables) for k in PLACES)

    def test_deformable_wall_under_sudden_gravity(self):
        scene = self.make("wall", "--young", "1e8", "--length", "1.6", "--height", "1")
        self.check_same(scene, ("multigrid", "elimination", "multigrid"), least_motion=1e-5)

    def test_sliding_block(self):
        scene = self.folder / "slide.json"
        scene.write_text(json.dumps(SLIDE))
        self.check_same(scene, ("elimination",) * 3, least_motion=0.05)

    def test_shaken_wall(self):
        # Longer, and on one process multigrid comes to another answer than elimination, too.
        scene = self.make("shaken-wall", "--length", "1.6", "--height", "0.75", "--end-time", "0.02")
        self.check_same(scene, ("elimination", "multigrid", "elimination"), least_motion=1e-4)

    def test_small_systems_keep_every_bit(self):
        # Of the vault blocks stand on several fixed ones, of which a process does not know all contacts.
        for scene in (self.make("shaken-wall", "--length", "2", "--height", "1", "--end-time", "0.02"),
                      self.make("vault", "--end-time", "0.01")):
            one, out = self.alone(scene), self.folder / f"{scene.stem}_parts"
            self.assertEqual(run(2, scene, "--out", out).returncode, 0)
            self.check_bits(one, out)

    def test_crowds_keep_every_bit(self):
        # Contacts that attempts find late (rocks in a bin), and velocities of a crowd whose contacts open.
        for scene in (self.make("bin", "--blocks", "40", "--end-time", "0.35"),
                      self.make("struck-wall", "--length", "2.4", "--height", "1", "--end-time", "0.015")):
            one, out = self.alone(scene, ends=(0, 1)), self.folder / f"{scene.stem}_parts"
            run(2, scene, "--out", out)  # cut before it rests
            self.check_bits(one, out)

    def test_blocks_that_are_released_keep_what_they_bore(self):
        for name, change in (("dry", {"loads": [{**PUSH, "force": [5000, 0, 0]}]}), ("glued", GLUED),
                             ("sunk", {"blocks": [SUNK, BASE, GROUND], "initial_overlap": "zero"})):
            scene = self.folder / f"{name}.json"
            scene.write_text(json.dumps({**RELEASED, **change}))
            one = self.alone(scene)
            for ranks in (2, 3):
                out = self.folder / f"{name}_{ranks}"
                self.assertEqual(run(ranks, scene, "--out", out).returncode, 0)
                self.check_bits(one, out)

    def test_pieces(self):
        scene = self.make("shaken-wall", "--length", "2", "--height", "1", "--end-time", "0.02")
        one, out = self.alone(scene), self.folder / "out"
        self.assertEqual(run(4, scene, "--out", out).returncode, 0)
        files = {p.name for p in out.iterdir()}
        self.assertEqual(files - {"manifest.json"}, set(json.loads((out / "manifest.json").read_text())["files"]))
        for kind, key in (("blocks", "block"), ("contacts", "gap")):
            listed = [entry.get("file") for entry in xml.parse(out / f"{kind}.pvd").getroot().iter("DataSet")]
            self.assertEqual(len(listed), sum(name.startswith(kind) and name.endswith(f".p{self.ending(kind)}")
                                              for name in files))
            for frame in listed:
                pieces = [p.get("Source") for p in xml.parse(out / frame).getroot().iter("Piece")]
                self.assertEqual(len(pieces), 4)
                whole = vtk_file.read(one / frame.replace(".p", "."))[1][key]
                parts = [vtk_file.read(out / piece)[1][key] for piece in pieces]
                self.assertEqual(sorted(sum(parts, [])), sorted(whole))
                if kind == "blocks":
                    self.assertLessEqual(max(map(len, parts)), 2 + min(map(len, parts)))
        self.check_by_vtk(one, out)
        done = subprocess.run(["/usr/bin/python3", "-c", READ_BY_PICTURE, SOURCE / "tools", one, out],
                              capture_output=True, text=True)
        self.assertTrue(done.returncode == 0 or "No module named 'numpy'" in done.stderr, done.stderr)

    def ending(self, kind):
        return "vtu" if kind == "blocks" else "vtp"

    def check_by_vtk(self, one, out):
        said = read_by_vtk(out / "blocks_000001.pvtu", out / "contacts_000001.pvtp")
        if said is None:
            return
        arrays = vtk_file.read(one / "blocks_000001.vtu")[1]
        self.assertEqual(sorted(said["name"]), sorted(arrays["name"]))
        self.assertEqual(said["points"], len(arrays["Points"]))
        self.assertEqual(said["contacts"], len(vtk_file.read(one / "contacts_000001.vtp")[1]["gap"]))

    def test_time_limit_ends_all_at_one_step(self):
        scene = self.make("shaken-wall", "--length", "2", "--height", "1", "--end-time", "1000")
        done = run(4, scene, "--max-seconds", "0.2", "--json")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(own_lines(done), ["quoin: the time limit is over"])
        self.assertEqual(json.loads(done.stdout)["status"], "time_limit")

    def test_killed_rank_ends_all(self):
        mpirun = subprocess.Popen([MPIRUN, "-n", "4", QUOIN, "run", "--mpi", INCLINE, "--set", "/end_time=1000"],
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        ranks = []
        while len(ranks) < 4:
            self.assertIsNone(mpirun.poll())
            time.sleep(0.05)
            children = pathlib.Path(f"/proc/{mpirun.pid}/task/{mpirun.pid}/children").read_text().split()
            ranks = [int(c) for c in children if pathlib.Path(f"/proc/{c}/comm").read_text().strip() == "quoin-mpi"]
        time.sleep(0.5)  # they are in their steps
        os.kill(ranks[2], signal.SIGKILL)
        said = mpirun.communicate(timeout=60)[1]
        self.assertNotEqual(mpirun.returncode, 0)
        self.assertEqual(said.count("noticed that process rank 2"), 1, said)
        self.assertIn("signal 9", said)
        latest = time.monotonic() + 10  # mpirun does not wait for those that it has killed
        while any(map(runs, ranks)) and time.monotonic() < latest:
            time.sleep(0.05)
        self.assertFalse(any(map(runs, ranks)))

    def test_rank_that_cannot_write_ends_all(self):
        done = run(2, INCLINE, "--out", self.folder / "out", "--set", "/end_time=1",
                   wrapper=("sh", "-c", 'trap "" XFSZ; ulimit -f 1; exec "$0" "$@"'))
        self.assertEqual(done.returncode, 1, done.stderr)
        lines = own_lines(done)
        self.assertEqual(len(lines), 1, done.stderr)
        self.assertRegex(lines[0], r"^quoin: rank 1 of 2: .*blocks_000000_1.vtu.part: can't be written: File too large$")
        self.assertFalse((self.folder / "out").exists())

    def test_what_all_ranks_refuse_is_said_once(self):
        for arguments, line in (
                ((INCLINE, "--set", "/method=paper"), 'incline.json: /method: "paper" knows one process alone'),
                ((INCLINE, "--set", "/contact_iteration=proximal_newton"),
                 '/contact_iteration: "proximal_newton" knows one process alone'),
                ((INCLINE, "--out", SOURCE / "tools"), "quoin: ")):
            with self.subTest(arguments=arguments):
                done = run(2, *arguments)
                self.assertIn(done.returncode, (1, 2))
                self.assertEqual(len(own_lines(done)), 1, done.stderr)
                self.assertIn(line, own_lines(done)[0])
                self.assertEqual(done.stdout, "")

    def test_options_that_know_one_process(self):
        for options in (("--resume", "x"), (INCLINE, "--checkpoint", "1"),
                        (INCLINE, "--dump-steps", "1", "--out", self.folder)):
            done = self.quoin("run", "--mpi", *options, code=2)
            self.assertRegex(done.stderr, r"^--(resume|checkpoint|dump-steps) excludes --mpi\n")

    def test_a_command_line_that_says_nothing_is_told_once(self):
        for options, line in (((INCLINE, "--pray"), "not expected: --pray"), ((INCLINE, "--threads", 0), "--threads: "),
                              ((INCLINE, "--checkpoint", 1), "excludes --mpi"), ((), "scene is required")):
            done = run(2, *options)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertEqual(done.stderr.count(line), 1, done.stderr)


unittest.main(argv=[sys.argv[0]], verbosity=2)
