"""Functions of time from CSV files, jumps in tables, baseline correction: against exact integrals."""
import sys
import unittest

from folder_test import FolderTest, block

# Time (s) and acceleration (g) of a record; no multiple of the time step.
RECORD = [(0.0, 0.0), (0.13, 0.4), (0.21, -0.7), (0.37, 0.2), (0.6, 0.1)]


def integrated(record):
    """Velocity and displacement at the end, from rest, of a piecewise linear acceleration."""
    v = u = 0.0
    for (t0, a0), (t1, a1) in zip(record, record[1:]):
        h = t1 - t0
        u += h * v + h * h / 6 * (2 * a0 + a1)
        v += h / 2 * (a0 + a1)
    return v, u


class Records(FolderTest):
    def setUp(self):
        super().setUp()
        lines = ['"t", ax ,note'] + [f"{t}, {a},x" for t, a in RECORD]
        (self.folder / "quake.csv").write_text("\ufeff" + "\r\n".join(lines) + "\r\n", encoding="utf-8")

    def scene(self, **more):
        return {"time_step": 0.1, "end_time": 0.6, "monitors": [{"name": "table", "block": "table"}],
                "materials": {"stone": {"density": 2000}}, **more}

    def end_of(self, motion, **more):
        table = block("table", [0, 0, 0], [1, 1, 1], "prescribed", motion=motion)
        return self.run_scene(self.scene(blocks=[table], **more))["monitors"]["table"]

    def record(self, **more):
        return {"csv": "quake.csv", "time": "t", "value": "ax", **more}

    def test_a_record_is_integrated_exactly(self):
        end = self.end_of({"acceleration": self.record(scale=9.81, along=[0, 3, 4])})
        v, u = integrated([(t, 9.81 * a) for t, a in RECORD])
        for component, factor in ((0, 0), (1, 0.6), (2, 0.8)):
            self.assertAlmostEqual(end["velocity"][component], factor * v, places=12)
            self.assertAlmostEqual(end["displacement"][component], factor * u, places=12)

    def test_three_columns(self):
        (self.folder / "quake.csv").write_text("t;x;y;z\n0;1;2;3\n1;1;2;3\n")
        end = self.end_of({"velocity": self.record(value=["x", "y", "z"])})
        for found, exact in zip(end["displacement"], (0.6, 1.2, 1.8)):
            self.assertAlmostEqual(found, exact, places=12)

    def test_a_corrected_record_ends_at_rest_where_it_began(self):
        for end_time in (0.6, 1.6):
            end = self.end_of({"acceleration": self.record(scale=9.81, baseline="at_rest")}, end_time=end_time)
            for key in ("velocity", "displacement"):
                self.assertLess(max(map(abs, end[key])), 1e-13, key)
        self.assertGreater(abs(integrated(RECORD)[1]), 1e-3)  # there was something to correct

    def test_a_record_that_says_something_else(self):
        for text, more, said in (
                ("t;x\n0,5;0,2\n1;1\n", {}, "quake.csv: line 2 has 4 fields, the first one 2"),
                ("t;x\n0;1\n", {"baseline": "at_rest"}, "has one line, two or more are needed")):
            (self.folder / "quake.csv").write_text(text)
            motion = {"acceleration": self.record(value="x", **more)}
            blocks = [block("table", [0, 0, 0], [1, 1, 1], "prescribed", motion=motion)]
            self.quoin("run", self.written(self.scene(blocks=blocks)), code=2, err=said)

    def test_a_load_that_skips_values_is_told(self):
        load = {"type": "point", "block": "table", "point": [0.5, 0.5, 0.5], "force": self.record()}
        blocks = [block("table", [0, 0, 0], [1, 1, 1])]
        for time_step, said in ((0.3, "/loads/0/force: a value each 0.15 s, taken once a time step of 0.3 s"), (0.1, "")):
            done = self.quoin("run", self.written(self.scene(blocks=blocks, loads=[load], time_step=time_step)), err=said)
            self.assertEqual(bool(said), bool(done.stderr))

    def test_a_table_may_jump(self):
        table = [[0, 0, 0, 0], [0.25, 0, 0, 0], [0.25, 1, 0, 0], [0.45, 1, 0, 0], [0.45, -2, 0, 0]]
        end = self.end_of({"velocity": {"table": table}})
        self.assertAlmostEqual(end["displacement"][0], 0.2 - 2 * 0.15, places=12)
        self.assertEqual(end["velocity"][0], -2)


unittest.main(argv=[sys.argv[0]], verbosity=2)
