"""`quoin run` as a user meets it: files, exit codes, interruption."""
import csv
import json
import math
import pathlib
import resource
import signal
import subprocess
import sys
import time
import unittest
import xml.etree.ElementTree as xml

from folder_test import FolderTest, block, box, flags_of, read_by_vtk

QUOIN, SOURCE = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
INCLINE = SOURCE / "tools" / "scenes" / "paper" / "incline.json"
ARCH = SOURCE / "tools" / "scenes" / "study" / "arch.json"
TWO_FORCES = SOURCE / "tools" / "scenes" / "paper" / "two_forces.json"
sys.path.insert(0, str(SOURCE / "tools"))
import vtk_file  # noqa: E402

HALF = ("--set", "/end_time=0.5")  # s
FLOOR = block("floor", [-5, -5, -1], [5, 5, 0], "fixed")
TOP = block("top", [0, 0, 0], [1, 1, 1])


def scene(blocks, **more):
    return {"materials": {"stone": {"density": 2000}}, "joint": {"friction_angle_deg": 30},
            "time_step": 0.01, "end_time": 0.1, "blocks": blocks, **more}


class RunCommand(FolderTest):
    def test_writes_what_it_promises(self):
        out = self.folder / "deep" / "out"
        summary = self.told("run", INCLINE, "--out", out, *HALF, says="")  # no progress line when piped
        self.assertEqual(summary, self.summary(out))
        self.assertEqual(summary["status"], "completed")
        self.assertEqual(summary["steps"], 50)
        self.assertAlmostEqual(summary["time"], 0.5, places=12)
        self.assertEqual(summary["references"][0]["steps_compared"], 50)
        self.assertEqual([p.name for p in (self.folder / "deep").iterdir()], ["out"])
        self.check_history(out / "history.csv")
        self.check_vtk(out)

    def test_paraview_files_can_be_left_out(self):
        self.quoin("run", INCLINE, "--out", "out", *HALF, "--set", "/paraview=false", code=0)
        self.assertEqual({p.name for p in (self.folder / "out").iterdir()} - {".quoin-journal"},
                         {"history.csv", "blocks.csv", "contacts.csv", "joints.csv", "manifest.json", "summary.json"})
        self.assertIn('ParaView files: "paraview" is false', self.summary()["left_out"])

    def check_history(self, path):
        rows = self.rows(path)
        self.assertEqual(len(rows), 51)
        self.assertEqual(float(rows[0]["block.ux"]), 0)
        self.assertGreater(float(rows[-1]["block.ux"]), 0.1)
        self.assertAlmostEqual(float(rows[-1]["time"]), 0.5, places=12)

    def check_vtk(self, out):
        for kind, count in (("blocks", "NumberOfCells"), ("contacts", "NumberOfVerts")):
            listed = list(xml.parse(out / f"{kind}.pvd").getroot().iter("DataSet"))
            self.assertEqual(len(listed), 11)
            for entry in listed:
                self.assertTrue((out / entry.get("file")).exists())
            piece, arrays = vtk_file.read(out / listed[-1].get("file"))
            self.assertEqual(len(arrays["Points"]), int(piece["NumberOfPoints"]))
            wanted = ({"displacement", "velocity", "stress", "principal_stress", "block", "kind",
                       "material", "name", "material_name"} if kind == "blocks" else
                      {"type", "gap", "normal_force", "shear_force", "force_on_b", "state", "slip"})
            self.assertLessEqual(wanted, set(arrays))
            for name, values in arrays.items():
                if kind == "contacts" or name in ("kind", "stress", "name", "types", "faceoffsets"):
                    self.assertEqual(len(values), int(piece[count]), name)
        self.assertEqual(arrays["block_a"], [0] * int(piece["NumberOfPoints"]))
        self.check_with_vtk(out)

    def check_with_vtk(self, out):
        said = read_by_vtk(out / "blocks_000010.vtu", out / "contacts_000010.vtp")
        if said is None:
            return
        _, arrays = vtk_file.read(out / "blocks_000010.vtu")
        self.assertEqual(said["points"], len(arrays["Points"]))
        self.assertEqual(said["name"], arrays["name"])
        self.assertEqual([tuple(s) for s in said["stress"]], arrays["stress"])
        self.assertEqual(said["contacts"], len(vtk_file.read(out / "contacts_000010.vtp")[1]["gap"]))

    def test_the_end_of_every_stage_is_written(self):
        scene = json.loads(ARCH.read_text())
        for key in ("monitors", "references", "end_time"):
            scene.pop(key, None)
        scene["blocks"][1]["name"] = hostile = '+1,"x"'
        scene |= {"title": "arch", "stages": [{"analysis": "settle", "steps": 5}, {"analysis": "static", "steps": 5}]}
        reaction = self.run_scene(scene)["base_reaction"]
        blocks, contacts = self.rows("blocks.csv"), self.rows("contacts.csv")
        count = len(scene["blocks"])
        self.assertEqual([row["stage"] for row in blocks], ["0"] * count + ["1"] * count)
        self.assertEqual(blocks[1]["name"], "'" + hostile)
        self.assertEqual({row["stage"] for row in contacts}, {"0", "1"})
        self.assertEqual(len(list((self.folder / "out").glob("blocks_*.vtu"))), 3)  # the start, and each stage's end
        held = {row["block"] for row in blocks if row["kind"] == "fixed"}
        for axis, total in zip("xyz", reaction):
            summed = sum(float(row["f" + axis]) * ((row["b"] in held) - (row["a"] in held))
                         for row in contacts if row["stage"] == "1")
            self.assertAlmostEqual(summed, total, delta=1e-9 * max(map(abs, reaction)))
        for row in contacts:
            if row["normal_stress"]:
                self.assertAlmostEqual(float(row["normal_stress"]) * float(row["area"]),
                                       float(row["normal_force"]), delta=1e-6)

    def test_forces_of_contacts_hold_each_block(self):
        self.quoin("make", "dome", "--rings", "3", "--segments", "7", "--young", "1e9", "--out", "dome.json", code=0)
        self.quoin("run", "dome.json", "--out", "out", code=0)
        contacts = self.rows("contacts.csv")
        for row in self.rows("blocks.csv"):
            if row["kind"] == "fixed":
                continue
            force, moment, pressed = [0, 0, -9.81 * float(row["mass"])], [0, 0, 0], 0
            for of in (c for c in contacts if row["block"] in (c["a"], c["b"])):
                sign = 1 if of["b"] == row["block"] else -1
                f = [sign * float(of["f" + axis]) for axis in "xyz"]
                arm = [float(of[axis]) - float(row[axis]) for axis in "xyz"]
                force = [was + one for was, one in zip(force, f)]
                moment = [was + arm[k - 2] * f[k - 1] - arm[k - 1] * f[k - 2] for k, was in enumerate(moment)]
                pressed += math.hypot(*f)
            self.assertLess(math.hypot(*force), 1e-7 * pressed)
            self.assertLess(math.hypot(*moment), 1e-6 * pressed)  # times 1 m

    def test_takes_the_place_of_earlier_results_only(self):
        out = self.folder / "out"
        self.quoin("run", INCLINE, "--out", out, *HALF, code=0)
        link = self.folder / "link"
        link.symlink_to(out)
        self.quoin("run", INCLINE, "--out", f"{link}/", "--set", "/end_time=1.0", code=0)
        self.assertTrue(link.is_symlink())
        self.assertEqual(self.summary()["steps"], 100)
        for name, spoil in (("letter.txt", lambda p: p.write_text("dear")),
                            ("history.csv", lambda p: p.write_text(p.read_text() + "my note")),
                            ("blocks.pvd", lambda p: (p.unlink(), p.symlink_to(INCLINE))),
                            ("pictures", lambda p: p.mkdir())):
            spoil(out / name)
            before = sorted(p.name for p in out.iterdir())
            self.quoin("run", INCLINE, "--out", out, *HALF, code=1, err=(f"out/{name}: ", "is not replaced"))
            self.assertEqual(sorted(p.name for p in out.iterdir()), before)
            (out / name).rmdir() if name == "pictures" else (out / name).unlink()
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["link", "out"])

    def test_a_note_that_appears_while_the_run_goes_on(self):
        out = self.folder / "out"
        self.quoin("run", INCLINE, "--out", out, *HALF)
        process = self.endless()
        self.wait_for("out.part-*/history.csv")
        (out / "note").write_text("dear")
        said = self.interrupted(process)
        self.assertIn("out/note: quoin did not write it", said)
        part = next(self.folder.glob("out.part-*"))
        self.assertIn(f"the results are in {part}", said)
        self.assertTrue((part / "summary.json").exists())
        self.assertTrue((out / "note").exists())

    def test_what_killed_runs_left_is_swept_and_nothing_else(self):
        out = self.folder / "out"
        for name in ("out.part-1", "out.part-notes"):  # of somebody
            (self.folder / name).mkdir()
            (self.folder / name / "letter.txt").write_text("dear")
        parts = []
        for _ in range(2):
            process = self.endless()
            parts.append(self.wait_for("out.part-??????/history.csv", parts).parent)
            if len(parts) == 2:
                break
            process.kill()
            process.wait()
            (parts[0] / "note").write_text("dear")
        self.quoin("run", INCLINE, "--out", out, *HALF, code=0)  # while the second goes on
        self.assertEqual([p.name for p in parts[0].iterdir()], ["note"])
        self.assertTrue((parts[1] / "history.csv").exists())
        self.interrupted(process, signal.SIGTERM)
        self.assertEqual({p.name for p in self.folder.iterdir()},
                         {"out", "out.part-1", "out.part-notes", parts[0].name})

    def endless(self, *words):
        """A run that goes on."""
        return subprocess.Popen([QUOIN, "run", TWO_FORCES, "--out", self.folder / "out", "--set", "/end_time=1000", *words],
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    def interrupted(self, process, number=signal.SIGINT):
        process.send_signal(number)
        said = process.communicate(timeout=60)[1]
        self.assertEqual(process.returncode, 1)
        return said

    def wait_for(self, pattern, but=()):
        for _ in range(600):
            found = [p for p in self.folder.glob(pattern) if p.parent not in but]
            if found:
                return found[0]
            time.sleep(0.05)
        self.fail(f"no {pattern}")

    def test_dump_steps(self):
        out = self.folder / "dumped"
        self.quoin("run", INCLINE, "--out", out, *HALF, "--dump-steps", "4", code=0)
        dumped = sorted(file.name for file in out.glob("contact_problem_*.txt"))
        self.assertEqual(dumped[0], "contact_problem_000000_000001.txt")
        self.assertTrue(all(int(name[16:22]) % 4 == 0 for name in dumped), dumped)
        self.assertTrue((out / dumped[0]).read_text().startswith("quoin contact problem 1\nblocks 1\n"))

    def test_dump_steps_of_several_islands(self):
        boxes = [block(f"b{x}{z}", [x, 0, z], [x + 1, 1, z + 1]) for x, z in ((0, 0), (3, 0), (3, 1))]
        self.run_scene(scene([FLOOR, *boxes], end_time=0.02), "--dump-steps", "2")
        blocks = {file.name: file.read_text().split("\n")[1] for file in self.folder.glob("out/contact_problem_*.txt")}
        self.assertEqual(blocks, {"contact_problem_000000_000001.txt": "blocks 1",
                                  "contact_problem_000000_000002.txt": "blocks 2"})

    def test_a_failure_is_an_exit_code_and_a_verdict(self):
        for arguments, words in ((["--set", "/references/0/exact=0/0"], "its error is not a number"),
                                 (["--set", "/references/0/allowed=1e-15"], "allowed 1e-15"),
                                 (["--set", "/max_iterations=1", "--on-failure",
                                   "accept", "--set", "/smallest_time_step=0.01"],
                                  "steps did not converge")):
            self.quoin("run", INCLINE, "--out", "out", *HALF, *arguments, code=1, err=words)
            summary = self.summary()
            self.assertEqual(summary["verdict"], "failed")
            self.assertTrue(any(words in line for line in summary["failures"]), summary["failures"])

    def crushed(self, **change):
        """A rigid cube under a plate that comes down by 0.075 m more than there is room."""
        blocks = [block("ground", [-5, -5, -1], [5, 5, 0], "fixed"), block("cube", [0, 0, 0], [1, 1, 1]),
                  block("plate", [-5, -5, 1.05], [5, 5, 2], "prescribed", motion={"velocity": [0, 0, -1]})]
        return {**scene(blocks, time_step=1e-3, end_time=0.125), **change}

    def test_a_crushed_block_is_no_result(self):
        for words, flags in (([], ["unconverged"]),
                             (["--on-failure", "accept", "--set", "/smallest_time_step=1e-3"], ["unconverged", "overlap"])):
            done = self.quoin("run", self.written(self.crushed()), "--out", "out", "--json", *words, code=1)
            summary = json.loads(done.stdout)
            self.assertEqual(summary, self.summary())
            self.assertEqual((summary["status"], summary["verdict"]), ("not_converged", "failed"))
            self.assertEqual(flags_of(summary), [(flag, True) for flag in flags])
            self.assertEqual(summary["failures"][0], summary["message"])
            fighting = done.stderr.split("contacts that fight: ")[1].splitlines()[0]  # equally hard: in either order
            self.assertIn('"ground" and "cube" at (', fighting)
            self.assertIn('"cube" and "plate" at (', fighting)
            self.assertEqual(fighting.count(" at ("), 2)
            self.assertEqual("not to be trusted: overlap" in done.stderr, "overlap" in flags, done.stderr)

    def test_a_soft_block_strained_beyond_its_law_is_no_result(self):
        crushed = self.crushed(materials={"stone": {"density": 2000, "young": 1e7, "poisson": 0.2}})
        crushed["blocks"][1]["kind"] = "deformable"
        summary = self.run_scene(crushed, code=1, err=("not to be trusted: strain", 'block "cube"'))
        self.assertEqual((summary["status"], summary["verdict"]), ("not_trusted", "failed"))
        self.assertEqual(flags_of(summary), [("strain", True)])
        self.assertEqual(summary["failures"], [summary["message"]])

    def test_springs_close_by_their_law(self):
        """An overlap that the scene asks for is flagged, and no failure."""
        joint = {"friction_angle_deg": 30, "normal_stiffness": 1e6, "shear_stiffness": 1e6}
        for change in ({"joint": joint}, {"method": "springs", "penalty": 2.5e5}):
            summary = self.run_scene(self.crushed(blocks=self.crushed()["blocks"][:2], **change))
            self.assertEqual(summary["status"], "completed")
            self.assertIn(("overlap", False), flags_of(summary))

    def test_a_spring_that_closes_farther_hides_no_crushed_block(self):
        blocks = self.crushed()["blocks"]
        blocks[2]["shape"] = box([-5, -5, 1.05], [2, 5, 2])
        soft = [block("bed", [6, -5, -1], [9, 5, 0], "fixed", joint_group="soft"),
                block("pressed", [7, 0, 0], [8, 1, 1], joint_group="soft")]
        joint = {"between": ["soft", "soft"], "friction_angle_deg": 30, "normal_stiffness": 1e4, "shear_stiffness": 1e4}
        self.run_scene(self.crushed(blocks=blocks + soft, joints=[joint], end_time=0.105), code=1, err='"cube" and')

    def test_a_step_that_diverged_counts_its_attempts(self):
        for blocks in ([FLOOR, TOP], [TOP]):  # slides, is free: without a solve
            done = self.quoin("run", self.written(scene(blocks, gravity={"formula": ["1e200", "0", "-1e200"]})),
                              err=("diverged", "residual inf"))  # its equations balance, 1e30 m away
            self.assertEqual(" 0 open-close iterations, 0 solves" in done.stderr, len(blocks) == 1, done.stderr)

    def test_a_function_of_time_that_leaves_the_numbers(self):
        """Said by name, and what was reached is kept."""
        gone = ["sqrt(0.025-t)", "0", "0"]
        table = block("table", [0, 0, -1], [1, 1, 0], "prescribed", motion={"displacement": {"formula": gone}})
        for change, words in (
                ({"gravity": {"formula": gone}}, "gravity at 0.03 s"),
                ({"loads": [{"type": "body", "block": "top", "force": {"formula": gone}}]},
                 'a body load on "top" at 0.0'),
                ({"blocks": [TOP, table]}, 'motion of "table" at 0.02')):
            summary = self.run_scene({**scene([TOP]), **change}, code=1, err=(words, "is not finite"))
            self.assertEqual(summary, self.summary())
            self.assertEqual(summary["status"], "not_converged")
            self.assertGreaterEqual(summary["steps"], 3)

    def test_a_motion_that_is_infinite_at_the_end_of_a_step(self):
        """There alone, and also where nothing is awake or nothing is written."""
        belt = block("belt", [-6, -2, -1], [6, 2, 0], "prescribed", motion={"velocity": {"formula": ["1/(0.05-t)", "0", "0"]}})
        for blocks in ([belt], [belt, TOP], [belt, {**TOP, "pose": {"translation": [0, 0, 50]}}]):
            for out in ((), ("--out", "out")):
                self.quoin("run", self.written(scene(blocks)), *out, code=1, err='motion of "belt" at 0.05 s is not finite')
            self.assertEqual(self.summary()["steps"], 5)  # with the one that failed

    def test_a_run_shorter_than_rounding_of_its_step(self):
        """Has a step all the same, so long as the run."""
        for time_step, end_time in ((0.01, 5e-9), (1e6, 0.1)):
            summary = self.run_scene(scene([TOP], time_step=time_step, end_time=end_time))
            self.assertEqual((summary["steps"], summary["time"]), (1, end_time))

    def test_peak_memory_is_its_own(self):
        """Not that of the process which started it."""
        held = bytearray(200 * 2**20)
        self.assertLess(self.told("run", INCLINE)["peak_memory_mb"], 100)
        del held

    def test_output_that_nobody_can_read(self):
        for words in (["run", INCLINE], ["run", INCLINE, "--json"], ["--help"], ["validate", "--list"],
                      ["contact", "--pairs", "-"]):
            with open("/dev/full", "w") as full:
                self.quoin(*words, code=1, err="can't", capture_output=False, stdout=full, stderr=subprocess.PIPE,
                           input='{"a": [], "b": []}\n')

    def test_list_of_cases(self):
        cases, lines = self.told("validate", "--list"), self.quoin("validate", "--list").stdout.splitlines()
        self.assertEqual([f"{case['case']:4} {case['title']}" for case in cases], lines)
        self.assertGreater(len(cases), 20)
        self.assertEqual(self.told("validate", "--list", "V05"), [case for case in cases if case["case"] == "V05"])

    def test_limit_of_file_size(self):
        self.quoin("run", INCLINE, "--out", "out", code=1, err="can't be written: File too large",
                   preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096)))

    def test_help(self):
        self.quoin("run", "--help", code=0)

    def test_an_interrupted_run_leaves_whole_files(self):
        out = self.folder / "out"
        process = self.endless("--set", "/output_interval=0.01")
        self.wait_for("out.part-*/blocks_000001.vtu")
        self.assertIn("interrupted", self.interrupted(process))
        summary = self.summary()
        self.assertEqual(summary["status"], "interrupted")
        rows = list(csv.reader((out / "history.csv").read_text().splitlines()))
        self.assertEqual(len(rows), summary["steps"] + 2)
        self.assertEqual({len(row) for row in rows}, {len(rows[0])})
        self.assertEqual([p.name for p in self.folder.iterdir()], ["out"])


unittest.main(argv=[sys.argv[0]], verbosity=2)
