"""`quoin run --checkpoint`, killed with -9 at random moments and resumed: all files are, to the byte, those
of the run without a stop. The same after Ctrl-C and --max-seconds.

usage: test_resume.py QUOIN SOURCE_DIR [KILLS]   (by default a handful)
"""
import hashlib
import json
import os
import pathlib
import random
import signal
import subprocess
import sys
import time
import unittest

from folder_test import FolderTest

QUOIN, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
KILLS = int(sys.argv[3]) if len(sys.argv) > 3 else 6
SCENES = SOURCE / "tools" / "scenes"
FIVE_BLOCKS = [SCENES / "paper" / "five_blocks.json", "--set", "/output_interval=0.5"]
SLOW = [*FIVE_BLOCKS, "--set", "/time_step=0.0002"]  # long enough to be interrupted three times
DOMINOES = [SCENES / "study" / "dominoes.json", "--set", "/end_time=1"]


def digest(folder):
    """Of every file; in the summary without wall time, and without what the finder remembered."""
    files = {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in folder.iterdir()}
    files.pop("manifest.json")
    summary = json.loads((folder / "summary.json").read_text())
    for key in ("wall_seconds", "seconds", "peak_memory_mb"):
        summary.pop(key)
    summary["pairs"].pop("searched")
    files["summary.json"] = json.dumps(summary)
    return files


class Resume(FolderTest):
    def setUp(self):
        super().setUp()
        self.out = self.folder / "out"

    def plain(self, scene):
        start = time.monotonic()
        self.quoin("run", *scene, "--out", "plain")
        return digest(self.folder / "plain"), time.monotonic() - start

    def start(self, *arguments):
        return subprocess.Popen([QUOIN, "run", *arguments], stdout=subprocess.DEVNULL,
                                stderr=subprocess.PIPE, text=True)

    def checkpoints(self):
        return list(self.folder.glob("out*/checkpoint.bin"))

    def finish(self, wanted):
        self.quoin("run", "--resume", self.out, code=0)
        self.assertEqual(digest(self.out), wanted)
        self.assertEqual({p.name for p in self.folder.iterdir()}, {"out", "plain"})

    def kill_and_resume(self, scene, kills):
        wanted, seconds = self.plain(scene)
        whole = arguments = [*scene, "--out", self.out, "--checkpoint", "0.01"]
        done = 0
        while done < kills:
            process = self.start(*arguments)
            try:
                said = process.communicate(timeout=random.uniform(0.2, 0.6) * seconds)[1]
                self.assertEqual(process.returncode, 0, said)
                self.assertEqual(digest(self.out), wanted)
                arguments = whole
            except subprocess.TimeoutExpired:
                process.kill()
                process.communicate()
                done += 1
                arguments = ["--resume", self.out] if self.checkpoints() else whole
        if arguments[0] == "--resume":
            self.finish(wanted)

    def test_killed_while_blocks_fall(self):
        self.kill_and_resume(FIVE_BLOCKS, KILLS - KILLS // 2)

    def test_killed_while_dominoes_fall(self):
        self.kill_and_resume(DOMINOES, KILLS // 2)

    def test_interrupted(self):
        wanted, _ = self.plain(SLOW)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            resume = ["--resume", self.out] if self.checkpoints() else [*SLOW, "--out", self.out]
            process = self.start(*resume)
            for _ in range(400):
                if list(self.folder.glob("out.part-*/history.csv")):
                    break
                time.sleep(0.01)
            os.kill(process.pid, number)
            said = process.communicate(timeout=60)[1]
            self.assertEqual((process.returncode, said), (1, "quoin: interrupted\n"))
            summary = self.summary()
            self.assertEqual((summary["status"], summary["verdict"]), ("interrupted", "failed"))
            self.assertFalse(summary["stages"][-1]["done"])
        self.finish(wanted)

    def test_time_limit_before_the_first_step_of_a_static_stage(self):
        scene = [SCENES / "study" / "arch.json"]
        wanted, _ = self.plain(scene)
        self.quoin("run", *scene, "--out", self.out, "--max-seconds", "0", code=1, err="quoin: the time limit is over")
        self.assertEqual(self.summary()["status"], "time_limit")
        self.finish(wanted)

    def test_contact_problems_are_written_on(self):
        scene = [*SLOW, "--dump-steps", "20"]
        wanted, _ = self.plain(scene)
        self.quoin("run", *scene, "--out", self.out, "--max-seconds", "0")
        self.assertFalse(list(self.out.glob("contact_problem_*")))
        self.finish(wanted)

    def test_a_bit_that_was_flipped(self):
        """In the checkpoint of a killed run, wherever it is: nothing else says that it was changed."""
        process = self.start(*SLOW, "--out", self.out, "--checkpoint", "0.01")
        while not self.checkpoints():
            time.sleep(0.01)
        process.kill()
        process.communicate()
        file = self.checkpoints()[0]
        whole = file.read_bytes()
        for place in (100, len(whole) // 3, len(whole) // 2, len(whole) - 1):
            spoilt = bytearray(whole)
            spoilt[place] ^= 1
            file.write_bytes(spoilt)
            self.quoin("run", "--resume", self.out, code=1, err="checkpoint.bin: the checkpoint is damaged")
        file.write_bytes(whole)
        self.quoin("run", "--resume", self.out, "--max-seconds", "0", err="the time limit is over")

    def test_what_can_not_be_resumed(self):
        scene = self.folder / "scene.json"
        scene.write_text((SCENES / "paper" / "five_blocks.json").read_text())
        self.quoin("run", scene, "--out", self.out, "--max-seconds", "0")
        scene.write_text(scene.read_text() + "\n")
        for spoil, words in ((lambda: None, "was changed since the checkpoint"),
                             (lambda: os.truncate(self.out / "checkpoint.bin", 1000),
                              "checkpoint.bin: was changed since quoin wrote it"),
                             (lambda: (self.out / "checkpoint.bin").unlink(), "no checkpoint")):
            spoil()
            self.assertEqual(self.quoin("run", "--resume", self.out, code=1, err=words).stderr.count("\n"), 1)
            self.assertEqual({p.name for p in self.folder.iterdir()}, {"out", "scene.json"})


unittest.main(argv=[sys.argv[0]], verbosity=2)
