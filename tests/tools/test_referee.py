#!/usr/bin/env python3
"""quoin referee: libraries that misbehave are named and survived, failing pairs can be rebuilt.

test_referee.py QUOIN SOURCE_DIR PLUGIN_DIR NARROW_PHASE_LIBRARY CXX EIGEN_INCLUDE"""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
import unittest

from folder_test import FolderTest

QUOIN, SOURCE, PLUGINS, LIBRARY, CXX, EIGEN = (pathlib.Path(word) for word in sys.argv[1:7])
BOXES = {"id": "boxes", "a": [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)],
         "b": {"points": [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)],
               "placement": [0.25, 0.5, 2.5, 1, 0, 0, 0, 1, 0, 0, 0, 1]}}


def alive(process):
    """A zombie is not."""
    status = pathlib.Path("/proc", process, "status")
    try:
        return "State:\tZ" not in status.read_text()
    except OSError:
        return False


def children_of(process):
    """As soon as there are some."""
    found = ""
    while not found and process.poll() is None:
        found = subprocess.run(["pgrep", "-P", str(process.pid)], capture_output=True, text=True, check=False).stdout
        time.sleep(0.05)
    return found.split()


class Referee(FolderTest):
    def pairs(self, *lines):
        (self.folder / "pairs.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
        return self.folder / "pairs.jsonl"

    def judge(self, *words, code=0):
        report = self.folder / "report.json"
        done = self.quoin("referee", "--json", report, *words, code=code)
        return json.loads(report.read_text()) if report.exists() else done.stderr

    def kinds_of(self, behaviour, *words):
        report = self.judge("--plugin", PLUGINS / f"{behaviour}.so", "--family", "on_the_grid", *words)
        (library,) = report["libraries"]
        return library["families"]["all"], report

    def test_a_command_without_its_referee(self):
        alone = shutil.copy(QUOIN, self.folder)
        done = subprocess.run([alone, "referee", "--count", "3"], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (1, "quoin: quoin-referee is not there: it is built where GMP is\n"))

    def test_a_library_that_lies(self):
        tally, report = self.kinds_of("lies", "--count", 50)
        self.assertEqual(tally["asked"], 50)
        self.assertGreater(tally["kinds"].get("sign", 0) + tally["kinds"].get("gap", 0), 40)
        self.assertTrue(report["failures"])

    def test_libraries_that_answer_nothing(self):
        for behaviour, kind, *words in (("crashes", "crash"), ("hangs", "hang", "--limit", 0.2), ("nan_gap", "not finite"),
                                        ("refuses", "refused"), ("exits", "crash"), ("eats", "crash")):
            tally, _ = self.kinds_of(behaviour, "--count", 3, *words)
            self.assertEqual((tally["asked"], tally["kinds"]), (3, {kind: 3}), behaviour)

    def test_a_library_that_aborts_when_it_is_unloaded_or_talks(self):
        """Neither changes the verdict, and what a library prints is not seen."""
        lies, _ = self.kinds_of("lies", "--count", 5)
        for behaviour in ("aborts_unloading", "talks"):
            tally, _ = self.kinds_of(behaviour, "--count", 5)
            self.assertEqual((tally["asked"], tally["kinds"]), (5, lies["kinds"]))
        said = self.quoin("referee", "--plugin", PLUGINS / "talks.so", "--count", "5", code=0)
        self.assertNotIn("bla", said.stdout + said.stderr)

    def test_a_library_with_more_points_than_room(self):
        tally, _ = self.kinds_of("endless_points", "--count", 20)
        self.assertGreater(tally["asked"], 0)
        self.assertEqual(tally["kinds"], {"failed": tally["asked"]})

    def test_a_library_of_points_alone(self):
        flush = {"id": "flush", "a": BOXES["a"], "b": [[x, y, z + 1] for x, y, z in BOXES["a"]]}
        report = self.judge("--plugin", PLUGINS / "points_only.so", "--pairs", self.pairs(BOXES, flush))
        (library,) = report["libraries"]
        self.assertEqual(list(library["families"]), ["flush", "all"])
        tally = library["families"]["all"]
        self.assertEqual((tally["asked"], tally["gaps"], tally["kinds"], tally["timed"]), (1, 0, {"missing corner": 1}, 1))

    def test_libccd_and_fcl_beside_quoin(self):
        """On pairs of all families: where they differ exact arithmetic finds quoin right, and mostly they agree."""
        tally = {library["name"]: library["families"]["all"] for library in self.judge("--count", 3000)["libraries"]}
        for name in ("quoin", "quoin C"):
            self.assertEqual((tally[name]["asked"], tally[name]["faulty"]), (3000, 0))
        for name, kind in (("libccd GJK", "sign"), ("libccd EPA 1e-9", "gap"), ("FCL libccd", "gap")):
            self.assertGreater(tally[name]["answered"], 1000, name)
            self.assertLess(tally[name]["kinds"].get(kind, 0), 0.2 * tally[name]["answered"], name)

    def test_plugins_that_can_not_be_asked(self):
        for behaviour, reason in (("old_interface", "interface 2, must be 1"), ("endless_libraries", "null")):
            text = self.judge("--plugin", PLUGINS / f"{behaviour}.so", code=1)
            self.assertEqual(len(text.strip().splitlines()), 1)
            self.assertIn(reason, text)

    def test_a_plugin_in_the_folder_at_hand(self):
        self.quoin("referee", "--plugin", "lies.so", "--count", "1", cwd=PLUGINS, code=0)

    def test_two_plugins_of_one_name(self):
        lies = PLUGINS / "lies.so"
        report = self.judge("--plugin", lies, "--plugin", lies, "--count", 3)
        self.assertEqual([library["name"] for library in report["libraries"]], ["bad", "bad (2)"])
        self.assertEqual([library["families"]["all"]["asked"] for library in report["libraries"]], [3, 3])

    def test_seconds_are_filled(self):
        report = self.judge("--plugin", PLUGINS / "overlaps_only.so", "--family", "^tetrahedra$", "--seconds", 1)
        self.assertGreater(report["seconds"], 0.9)
        self.assertLess(report["seconds"], 10)

    def test_ctrl_c(self):
        """What was judged is written, and nothing goes on: also where the library hangs."""
        report = self.folder / "report.json"
        run = subprocess.Popen([QUOIN, "referee", "--plugin", PLUGINS / "lies.so", "--plugin", PLUGINS / "hangs.so", "--limit",
                                "0.3", "--json", report], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               text=True, start_new_session=True)
        children_of(run)
        time.sleep(1)
        children = children_of(run)
        self.assertTrue(children)
        os.killpg(run.pid, signal.SIGINT)
        said = run.communicate(timeout=60)
        self.assertEqual(run.returncode, 1, said)
        self.assertIn("ended early", said[1])
        tallies = [library["families"]["all"] for library in json.loads(report.read_text())["libraries"]]
        self.assertGreater(tallies[0]["asked"], 0)
        self.assertNotIn("crash", tallies[0]["kinds"])
        self.assertFalse([child for child in children if pathlib.Path("/proc", child).exists()])

    def test_killed(self):
        """Its children end with it, also one that hangs."""
        run = subprocess.Popen([QUOIN, "referee", "--plugin", PLUGINS / "hangs.so", "--limit", "3000"],
                               stdout=subprocess.DEVNULL)
        children_of(run)
        time.sleep(1)
        children = children_of(run)
        self.assertTrue(children)
        run.kill()
        run.wait()
        for _ in range(100):
            left = [child for child in children if alive(child)]
            if not left:
                break
            time.sleep(0.1)
        self.assertFalse(left)

    def test_bad_words(self):
        (self.folder / "mine").mkdir()
        (self.folder / "mine/file").write_text("not ours")
        huge = self.folder / "huge.jsonl"
        huge.write_text(json.dumps({"a": [[1.7e308, 0, 0], [-1.7e308, 0, 0], [0, 1.7e308, 0], [0, 0, 1.7e308]], "b": BOXES["a"]}))
        empty = self.folder / "empty.jsonl"
        empty.write_text(json.dumps({"a": [], "b": BOXES["a"]}))
        for words, reason, code in ((["--family", "zzz"], "no family", 2), (["--family", "(["], "regular", 2),
                                    (["--limit", "nan"], "--limit", 2), (["--limit", "0"], "--limit", 2),
                                    (["--json", "/nowhere/x"], "can't be written", 1), (["--json", ""], "must not be empty", 2),
                                    (["--report", self.folder / "mine"], "did not write it", 1),
                                    (["--pairs", "/nowhere/x"], "can't be read", 1),
                                    (["--pairs", huge], "1e100", 2), (["--pairs", empty], "no points", 2)):
            done = self.quoin("referee", "--plugin", PLUGINS / "lies.so", "--count", "1000000", *words, code=code, err=reason,
                              timeout=60)
            self.assertEqual(done.stdout, "")

    def test_names_are_escaped(self):
        """Of pairs: in JSON, and in the comments of C++ and C."""
        name, out = 'a "name" \\ */\n', self.folder / "out"
        pairs = self.pairs(BOXES | {"id": name})
        self.judge("--plugin", PLUGINS / "lies.so", "--pairs", pairs, "--report", out)
        (failure,) = (out / "failures.jsonl").read_text().splitlines()
        json.loads(failure)
        for text in ((out / "failure_1.cpp").read_text(), (out / "failure_1.c").read_text()):
            self.assertNotIn("*/\n\n", text.splitlines()[0])
            self.assertTrue(text.splitlines()[1].startswith("#include"))
        self.quoin("referee", "--pairs", pairs, "--write-pairs", "proved.jsonl", code=0)
        self.assertEqual(json.loads((self.folder / "proved.jsonl").read_text())["id"], name)

    def test_a_library_that_tells_signs_alone(self):
        tally, _ = self.kinds_of("apart", "--count", 50)
        overlapping, _ = self.kinds_of("overlaps_only", "--count", 50)
        self.assertEqual(list(tally["kinds"]), ["sign"])
        self.assertEqual(tally["gaps"], 0)
        self.assertGreater(tally["kinds"]["sign"], 5)
        self.assertLess(tally["kinds"]["sign"], tally["asked"])
        self.assertLessEqual(tally["kinds"]["sign"], overlapping["asked"])

    def test_what_is_not_offered_is_not_asked(self):
        report = self.judge("--plugin", PLUGINS / "overlaps_only.so", "--pairs", self.pairs(BOXES))
        self.assertEqual(report["libraries"][0]["families"], {})

    def test_quoin_is_right_on_boxes(self):
        report = self.judge("--plugin", PLUGINS.parent / "referee_quoin.so", "--pairs", self.pairs(BOXES), "--steps", 20)
        tally = report["libraries"][0]["families"]["all"]
        self.assertEqual((tally["asked"], tally["answered"], tally["faulty"]), (20, 20, 0))
        self.assertLess(tally["gap_error_largest"], 1e-15)

    def test_a_file_that_is_no_plugin(self):
        text = self.judge("--plugin", SOURCE / "README.md", code=1)
        self.assertEqual(len(text.strip().splitlines()), 1)

    def test_a_failing_pair_is_small_and_can_be_rebuilt(self):
        out = self.folder / "out"
        self.judge("--plugin", PLUGINS / "lies.so", "--family", "^slivers$|^on_the_grid$", "--count", 20, "--report", out)
        self.assertIn("Referee of contact libraries", (out / "index.html").read_text())
        failures = (out / "failures.jsonl").read_text().splitlines()
        failure = json.loads(failures[0])
        (self.folder / "failure.jsonl").write_text(failures[0])
        self.assertEqual(len(failure["a"] if isinstance(failure["a"], list) else failure["a"]["points"]), 4)
        answer = self.quoin("contact", "--pairs", "failure.jsonl", code=0)
        gap = json.loads(answer.stdout)["gap"]
        include = ["-I", SOURCE / "geometry/include", "-isystem", EIGEN]
        for language in ("cpp", "c"):
            program = self.folder / f"pair_{language}"
            standard = ["-std=c++20", "-x", "c++"] if language == "cpp" else ["-x", "c"]
            subprocess.run([CXX, *standard, out / f"failure_1.{language}", "-x", "none", LIBRARY, *include,
                            "-lm", "-lpthread", "-o", program], check=True)
            told = subprocess.run([program], capture_output=True, text=True, check=True).stdout
            self.assertEqual(float(told.split()[1]), gap)

    def test_pairs_with_their_exact_answers(self):
        """Of pairs given, as tests/pairs is written; a gap that looks like rounding as a fraction."""
        near = {"id": "near", "a": BOXES["a"], "b": [[x + 1 + 2**-40, y, z] for x, y, z in BOXES["a"]]}
        pairs, proved = self.pairs(BOXES, near), self.folder / "proved.jsonl"
        self.quoin("referee", "--pairs", pairs, "--write-pairs", proved, code=0)
        first, second = map(json.loads, proved.read_text().splitlines())
        self.assertEqual((first["id"], first["exact"]["gap"], first["exact"]["normal"]), ("boxes", 1.5, [0, 0, 1]))
        self.assertNotIn("gap_squared", first["exact"])
        self.assertEqual(second["exact"]["gap_squared"], f"1/{2**80}")
        self.assertEqual((second["exact"]["type"], second["exact"]["area"]), ("face-face", 1))

    def test_a_library_in_steps(self):
        """Warm answers of solids that move: as many as steps, timed, and right."""
        report = self.judge("--plugin", PLUGINS.parent / "referee_quoin.so", "--family", "^boxes$",
                            "--count", 2, "--steps", 80)
        tally = report["libraries"][0]["families"]["all"]
        self.assertEqual((tally["asked"], tally["answered"], tally["faulty"]), (160, 160, 0))
        self.assertEqual(tally["timed"], 160)
        self.assertGreater(tally["seconds_median"], 0)

    def test_the_plain_judge(self):
        python = next(name for name in ("python3", "/usr/bin/python3")
                      if subprocess.run([name, "-c", "import numpy"], capture_output=True, check=False).returncode == 0)
        pairs = self.folder / "pairs.jsonl"
        lines = (SOURCE / "tests/pairs/families.jsonl").read_text().splitlines()
        pairs.write_text("\n".join([line for line in lines if '"what":"tetrahedra"' in line][:20]))
        done = self.quoin("contact", "--pairs", pairs, code=0)
        answers = [json.loads(line) for line in done.stdout.splitlines()]

        def judged():
            (self.folder / "answers.jsonl").write_text("\n".join(map(json.dumps, answers)))
            return subprocess.run([python, SOURCE / "tools/judge_pairs.py", pairs, self.folder / "answers.jsonl"],
                                  capture_output=True, text=True, check=False)
        right = judged()
        self.assertEqual(right.returncode, 0, right.stdout + right.stderr)
        answers[0]["gap"] *= 1 + 1e-9
        answers[1]["normal"] = answers[1]["normal"][1:] + answers[1]["normal"][:1]
        answers[2]["point_a"][0] += 1e6
        del answers[3]
        wrong = judged()
        self.assertEqual(wrong.returncode, 1)
        for kind in ("1 gap", "1 normal", "1 witness", "1 no answer"):
            self.assertIn(kind, wrong.stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
