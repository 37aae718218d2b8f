"""`quoin view` in a browser (Debian: chromium): what is drawn and said is what the run's files hold."""
import json
import math
import pathlib
import shutil
import subprocess
import sys
import time
import unittest

from browser import PROGRAM, Browser
from folder_test import FolderTest, block, box

SOURCE = pathlib.Path(sys.argv[2]).resolve()
sys.path.insert(0, str(SOURCE / "tools"))
import vtk_file  # noqa: E402

SHAKEN = {"overrides": [{"blocks": "ground", "kind": "prescribed",
                         "motion": {"displacement": {"formula": ["0", "0.05*(1-cos(4*pi*t))", "0"]}}}],
          "stages": [{"name": "rest", "analysis": "static"},
                     {"name": "shaking", "analysis": "dynamic", "end_time": 0.2}],
          "contact_iteration": "open_close", "output_interval": 0.02}


PICK_ONE = """(() => { for (let b = quoin.blocks.count - 1; b >= 0; --b) {
    const p = quoin.onPage(quoin.blocks.moved(b, 0, 0, 0));
    if (quoin.blocks.kind(b, quoin.state.frame) < 2 && quoin.pick(...p) === b) return [b, ...p]; } })()"""
UNITS = {"N": 1, "kN": 1e3, "MN": 1e6}


def set_to(name, chosen, event="change"):
    """A control of the page."""
    return f"(s => {{ s.value = '{chosen}'; s.dispatchEvent(new Event('{event}')); }})(document.getElementById('{name}'))"


def place_of(which):
    """On the page: left, top, width, height."""
    return f"(r => [r.left, r.top, r.width, r.height])(document.{which}.getBoundingClientRect())"


class View(FolderTest):
    @classmethod
    def setUpClass(cls):
        cls.browser = Browser()
        cls.addClassCleanup(cls.browser.close)

    def setUp(self):
        super().setUp()
        self.browser.events.clear()
        self.browser.size(1280, 800)

    def made(self, *words):
        self.quoin("make", *words, "--out", "made.json", code=0)
        return self.folder / "made.json"

    def shaken_wall(self):
        scene, run = self.made("wall", "--length", "0.9", "--height", "0.6", "--young", "1e7"), self.folder / "wall"
        changes = [word for key, value in SHAKEN.items() for word in ("--set", f"/{key}={json.dumps(value)}")]
        self.quoin("run", scene, "--out", run, *changes, code=0)
        return run

    def opened(self, *words):
        page = self.folder / "page.html"
        self.quoin("view", *words, "--out", page, code=0)
        self.browser.open(page)
        return self.browser.value

    def table(self, path):
        rows = self.rows(path)
        return [row for row in rows if row["stage"] == rows[-1]["stage"]]

    def said(self):
        """The rows of what is picked."""
        return dict(self.browser.value("[...document.querySelectorAll('#picked tr')].map("
                                       "row => [...row.children].map(cell => cell.textContent))"))

    def clean(self):
        self.assertEqual(self.browser.trouble(), [])

    def drag_slider_to_end(self):
        left, top, width, height = self.browser.value(place_of("getElementById('time')"))
        self.browser.drag(left + 8, top + height / 2, left + width - 3, top + height / 2)

    def test_a_run(self):
        """On a screen and on a telephone; the page has the same bytes each time."""
        run, pages = self.shaken_wall(), []
        for size in ((1280, 800), (390, 844, 2, True)):
            self.browser.size(*size)
            self.look_at_a_run(run, self.opened(run))
            pages.append((self.folder / "page.html").read_bytes())
        self.assertEqual(*pages)

    def look_at_a_run(self, run, value):
        frames = value("quoin.frames")
        self.assertEqual(frames, 12)  # start, end of the static stage, ten of the motion
        before = value("document.getElementById('time-value').textContent")
        self.drag_slider_to_end()
        self.assertEqual(value("quoin.state.frame"), frames - 1)
        self.assertNotEqual(before, value("document.getElementById('time-value').textContent"))
        self.assertEqual(value("document.getElementById('stage').textContent"), "end of shaking")
        block, *place = value(PICK_ONE)
        self.browser.click(*place)
        row = self.table(run / "blocks.csv")[block]
        self.assertEqual(value("document.getElementById('picked-title').textContent"), row["name"])
        moved = math.hypot(*(float(row[f"u{c}"]) for c in "xyz"))
        self.assertAlmostEqual(float(self.said()["displacement"].split()[0]) / moved, 1, delta=1e-3)
        speed = math.hypot(*(float(row[f"v{c}"]) for c in "xyz"))
        self.assertAlmostEqual(float(self.said()["speed"].split()[0]) / speed, 1, delta=2e-3)
        self.clean()

    def test_corners_are_those_of_the_vtk_files(self):
        run = self.shaken_wall()
        value = self.opened(run)
        for frame in (1, 7, 11):
            value(f"quoin.show({frame})")
            _, arrays = vtk_file.read(run / f"blocks_{frame:06}.vtu")
            corners = value("""quoin.blocks.shapes.length && [...quoin.blocks.shapeOf].map((s, b) => {
                const p = quoin.head.shapes[s].p, all = [];
                for (let k = 0; k < p.length; k += 3) all.push(quoin.blocks.moved(b, p[k], p[k + 1], p[k + 2]).map((x, i) => x + quoin.head.offset[i]));
                return all; })""")
            found = [corner for block in corners for corner in block]
            off = max(math.dist(p, q) for p, q in zip(found, arrays["Points"], strict=True))
            self.assertLess(off, 1e-5)  # 16 bits of 0.1 m, and 32 bits of places within 10 m
        self.clean()

    def test_joints(self):
        """Of a wall, and of a hook that bears on two planes."""
        hook = self.folder / "hook"
        self.quoin("run", SOURCE / "tools" / "scenes" / "field" / "hook_hangs.json", "--out", hook, code=0)
        for run in (hook, self.shaken_wall()):
            self.compare_joints(run, self.opened(run))

    def compare_joints(self, run, value):
        value("quoin.show(quoin.frames - 1)")
        value(set_to("forces", "joints"))
        rows = [row for row in self.table(run / "joints.csv") if float(row["normal_force"]) > 0]
        largest = max(float(row["normal_force"]) for row in rows)
        rows = [row for row in rows if float(row["normal_force"]) > 1e-6 * largest]
        found = value(f"quoin.joints.list.filter(j => j.normalForce > {1e-6 * largest}).map(j => [j.a, j.b, ...j.force, ...j.centre.map((x, k) => "
                      "x + quoin.head.offset[k]), j.area, j.normalForce, j.shear])")
        columns = ("a", "b", "fx", "fy", "fz", "x", "y", "z", "area", "normal_force", "shear_force")
        for one, row in zip(sorted(found), sorted(rows, key=lambda row: (int(row["a"]), int(row["b"]))), strict=True):
            for number, column in zip(one, columns, strict=True):
                self.assertAlmostEqual(number, float(row[column]), delta=1e-5 * (1 if column in "xyzarea" else largest), msg=column)
        a, b, *place = value("""(() => { let best = quoin.joints.list[0];
            for (const j of quoin.joints.list) if (Math.hypot(...j.force) > Math.hypot(...best.force)) best = j;
            return [best.a, best.b, ...quoin.onPage(best.centre)]; })()""")
        self.browser.click(*place)
        points = [row for row in self.table(run / "contacts.csv") if (row["a"], row["b"]) == (str(a), str(b))]
        self.assertEqual(self.said()["joint"], f"{points[0]['name_a']} – {points[0]['name_b']}")
        self.assertEqual(self.said()["points"], str(len(points)))
        force = math.hypot(*(sum(float(row[f"f{c}"]) for row in points) for c in "xyz"))
        number, unit = self.said()["resultant on the second"].split()
        self.assertAlmostEqual(float(number) * UNITS[unit] / force, 1, delta=1e-3)
        self.clean()

    def test_blocks_by_the_pressure_of_their_joints(self):
        run = self.shaken_wall()
        value = self.opened(run)
        value("quoin.show(quoin.frames - 1)")
        value(set_to("colour", "pressure"))
        rows = self.table(run / "joints.csv")
        exact = [max([float(row["normal_stress"] or math.inf) for row in rows if row["state"] != "open" and str(block) in (row["a"], row["b"])], default=0)
                 for block in range(value("quoin.blocks.count"))]
        found = value("[...quoin.pressures]")
        for one, other in zip(found, exact, strict=True):
            if math.isfinite(other):
                self.assertAlmostEqual(one / other, 1, delta=1e-4)
            else:
                self.assertIsNone(one)  # an edge bears: JSON knows no infinity
        high, tints = value("quoin.joints.high"), value("[...quoin.blocks.values.image.data]")
        least = min(range(1, len(exact)), key=exact.__getitem__)
        self.assertLess(exact[least], 0.5 * high)
        self.assertLess(tints[4 * least + 1], tints[4 * exact.index(max(exact)) + 1])  # viridis: green grows
        block, *place = value(PICK_ONE)
        self.browser.click(*place)
        self.assertAlmostEqual(float(self.said()["largest joint pressure"].split()[0]) / exact[block], 1, delta=1e-3)
        self.clean()

    def test_a_contact_point_and_the_history(self):
        run = self.shaken_wall()
        value = self.opened(run)
        value("quoin.show(quoin.frames - 1), document.getElementById('points').click(), quoin.draw()")
        a, b, index, *place = value("""(() => { let best = null;
            for (const j of quoin.joints.list) j.points.forEach((p, i) => { if (!best || Math.hypot(...p.force) > Math.hypot(...best.p.force)) best = {j, i, p}; });
            return [best.j.a, best.j.b, best.i, ...quoin.onPage(best.p.at)]; })()""")
        self.browser.click(*place)
        rows = [row for row in self.table(run / "contacts.csv") if (row["a"], row["b"]) == (str(a), str(b))]
        force = math.hypot(*(float(rows[index][f"f{c}"]) for c in "xyz"))
        number, unit = self.said()["force"].split()
        self.assertAlmostEqual(float(number) * UNITS[unit] / force, 1, delta=1e-3)
        value("document.getElementById('history').scrollIntoView()")
        left, top, width, height = value(place_of("querySelector('#history .u-over')"))
        self.browser.mouse("mouseMoved", left + width / 2, top + height / 2)
        self.browser.click(left + width / 2, top + height / 2)
        self.assertAlmostEqual(value("quoin.head.times[quoin.state.frame]"), 0.1, delta=0.011)  # the middle of 0.2 s
        self.clean()

    def test_every_control_and_a_phone(self):
        value = self.opened(self.shaken_wall())
        for colour in value("[...document.getElementById('colour').options].map(o => o.value)"):
            value(set_to("colour", colour))
        for tick in ("polygons", "cracks", "points", "edges", "glass"):
            value(f"document.getElementById('{tick}').click()")
        for name, chosen in (("axis", "y"), ("cut", "300"), ("scale", "1")):
            value(set_to(name, chosen, "input"))
        eye = value("quoin.camera.position.toArray()")
        for key in ("ArrowRight", "2", " ", "f"):
            value(f"document.body.dispatchEvent(new KeyboardEvent('keydown', {{key: '{key}', bubbles: true}})), 1")
        self.assertNotEqual(eye, value("quoin.camera.position.toArray()"))
        end = time.monotonic() + 30
        while value("quoin.state.frame") <= 1:  # it plays
            self.assertLess(time.monotonic(), end)
        self.browser.size(390, 844, 2, True)
        self.browser.open(self.folder / "page.html")
        self.assertTrue(value("document.documentElement.scrollWidth <= innerWidth"))
        self.assertEqual(value("document.getElementById('view').clientWidth"), 390)  # the panel stands below
        self.clean()

    def test_fingers(self):
        """One turns, two zoom, a tap picks, and none of the others does."""
        self.browser.size(390, 844, 2, True)
        value = self.opened(self.made("tower", "--blocks", "3"))
        left, top, width, height = value(place_of("getElementById('canvas')"))
        x, y = left + width / 2, top + height / 2
        towards, far = "quoin.camera.position.clone().sub(quoin.controls.target)", "quoin.camera.position.distanceTo(quoin.controls.target)"
        before, away = value(f"{towards}.normalize().toArray()"), value(far)
        self.browser.swipe((x, y, x + 80, y))
        after = value(f"{towards}.normalize().toArray()")
        self.assertLess(sum(a * b for a, b in zip(before, after)), 0.9)
        self.assertAlmostEqual(value(far) / away, 1, delta=1e-6)
        self.browser.swipe((x - 20, y, x - 80, y), (x + 20, y, x + 80, y))
        self.assertLess(value(far) / away, 0.7)
        self.assertGreater(value(f"quoin.pick({x + 4}, {y})"), -1)
        self.browser.swipe((x - 4, y, x - 4, y), (x + 4, y, x + 4, y), steps=1)  # a tap of two is none
        self.assertEqual(value("quoin.state.picked"), -1)
        value("quoin.home(), quoin.draw()")
        block, *place = value("[3, ...quoin.onPage(quoin.blocks.moved(3, 0, 0, 0))]")
        self.browser.swipe((*place, *place), steps=1)
        self.assertEqual(value("quoin.state.picked"), block)
        self.assertEqual(value("document.getElementById('picked-title').textContent"), value(f"quoin.head.names[{block}]"))
        self.clean()

    def test_cracks_are_as_wide_as_blocks_are_apart(self):
        scene, run = self.made("tower", "--blocks", "2"), self.folder / "tower"
        stages = [{"analysis": "static"}, {"analysis": "dynamic", "duration": 0.05, "overrides": [
            {"blocks": "drum1", "velocity": [0, 0, 1.0], "angular_velocity": [0.5, 0, 0]}]}]
        self.quoin("run", scene, "--out", run, "--set", f"/stages={json.dumps(stages)}", code=0)
        value = self.opened(run)
        value("quoin.show(quoin.frames - 1), document.getElementById('cracks').click()")
        widths = value("(c => c.list.map(crack => c.widths(crack, quoin.blocks.mapsAt(quoin.state.frame, 1))))(quoin.joints.opened())")
        _, arrays = vtk_file.read(sorted(run.glob("blocks_*.vtu"))[-1])
        upper = [(z - up, up) for (_, _, z), (_, _, up) in zip(arrays["Points"], arrays["displacement"], strict=True)][-8:]
        self.assertEqual([len(joint) for joint in widths], [4, 4])
        for found, exact in zip(sorted(widths[1]), sorted(up for z, up in upper if z < 0.75), strict=True):
            self.assertAlmostEqual(found, exact, delta=1e-5)
        said = value("document.getElementById('widest').textContent")
        self.assertAlmostEqual(float(said.split()[2]), max(widths[1]), delta=1e-4)
        self.assertIn("drum0 – drum1", said)
        self.clean()

    def test_ties(self):
        """Of two ties one breaks; the other is drawn from end to end, and picked in its middle."""
        on = {"block": "ground", "point": [-1, 0.5, 0]}
        scene, run = self.scene_of_boxes(end_time=0.02, ties=[
            {"name": "weak", "from": on, "to": {"block": "box0", "point": [0, 0.5, 1]}, "stiffness": 1e5, "pretension": 100, "break_force": 101},
            {"name": "stay", "from": on, "to": {"block": "box0", "point": [1, 0.5, 1]}, "stiffness": 1e5, "pretension": 1500}],
            loads=[{"type": "point", "block": "box0", "point": [1, 0.5, 0.1], "force": [15000, 0, 0]}]), self.folder / "run"
        self.quoin("run", scene, "--out", run, code=0)
        value = self.opened(run)
        self.assertEqual(value("quoin.ties.list.length"), 2)
        value("quoin.show(quoin.frames - 1), quoin.draw()")
        weak, stay = self.rows("ties.csv", run)[-2:]
        self.assertEqual((weak["state"], value("quoin.ties.list.map(tie => tie.name)")), ("broken", ["stay"]))
        self.browser.click(*value("quoin.onPage(quoin.ties.list[0].place)"))
        self.assertEqual(self.said(), {"force": f"{float(stay['force']) / 1e3:.4g} kN", "length": f"{float(stay['length']):.4g} m"})
        self.clean()

    def test_a_section_shows_the_faces_that_it_makes(self):
        value = self.opened(self.made("tower", "--blocks", "3"))
        for name, chosen in (("axis", "x"), ("cut", "500")):
            value(set_to(name, chosen, "input"))
        value("quoin.draw()")
        size = value("quoin.head.shapes[quoin.blocks.shapeOf[1]].p")
        sides = [max(size[k::3]) - min(size[k::3]) for k in (1, 2)]
        area = value("""(() => { const c = quoin.blocks.uniforms.cut.value, [o] = quoin.section.outlines(1, [c.x, c.y, c.z], c.w);
            let a = 0; o.forEach((p, i) => { const q = o[(i + 1) % o.length]; a += (p[1] * q[2] - p[2] * q[1]) / 2; }); return Math.abs(a); })()""")
        self.assertAlmostEqual(area / (sides[0] * sides[1]), 1, delta=1e-6)
        off = value("""(c => quoin.section.outlines(1, [c.x, c.y, c.z], c.w).flat().map(p => c.x * p[0] + c.y * p[1] + c.z * p[2] - c.w))
            (quoin.blocks.uniforms.cut.value)""")
        self.assertLess(max(map(abs, off)), 1e-6)  # in the plane
        self.assertTrue(value("quoin.section.faces.object.visible"))
        self.clean()

    def test_a_block_of_two_convex_parts(self):
        """An L of two bars: each is picked, a ray through its corner of air meets nothing, and a section has two outlines."""
        bars = [box([0, 0, 0], [2, 1, 0.5]), box([0, 0, 0.5], [0.5, 1, 1.5])]
        scene = self.scene_of_boxes(blocks=[{"name": "L", "kind": "rigid", "material": "stone", "parts": bars}], end_time=0.01)
        value = self.opened(scene)
        hit = value("""[[1.5, 0.25], [0.25, 1], [1.5, 1]].map(([x, z]) => { const o = quoin.head.offset;
            return [quoin.blocks.pick([x - o[0], -5 - o[1], z - o[2]], [0, 10, 0], 0), quoin.blocks.part]; }).map(([b, part]) => b < 0 ? -1 : part)""")
        self.assertEqual(hit, [0, 1, -1])
        self.browser.click(*value("quoin.onPage([0.25, 0, 1].map((x, k) => x - quoin.head.offset[k]))"))
        self.assertEqual(self.said()["convex part"], "2 of 2")
        areas = value("""quoin.section.outlines(0, [0, 1, 0], 0.1).map(o => {
            let a = 0; o.forEach((p, i) => { const q = o[(i + 1) % o.length]; a += (p[0] * q[2] - p[2] * q[0]) / 2; }); return Math.abs(a); })""")
        for found, exact in zip(sorted(areas), (0.5, 1.0), strict=True):
            self.assertAlmostEqual(found, exact, places=5)
        self.clean()

    def scene_of_boxes(self, *more_places, **more):
        """A box on the ground, and others of its size, by their lowest corners."""
        blocks = [block("ground", [-2, -2, -1], [4, 4, 0], "fixed")]
        blocks += [block(f"box{i}", [0, 0, 0], [1, 1, 1], pose={"translation": place})
                   for i, place in enumerate(([0, 0, 0], *more_places))]
        return self.written({"materials": {"stone": {"density": 2000}}, "joint": {"friction_angle_deg": 30}, "time_step": 0.01,
                             "blocks": blocks, **({} if "stages" in more else {"end_time": 1}), **more})

    def test_a_scene_with_loads_and_what_check_complains_of(self):
        force = {"formula": ["400*t", "0", "0"]}
        value = self.opened(self.scene_of_boxes([2, 0, 0.5], loads=[
            {"type": "point", "block": "box0", "point": [0, 0.5, 0.5], "force": force}]))
        self.browser.click(*value("quoin.onPage(quoin.marks.list[0].place)"))
        self.assertEqual(self.said()["largest"], "400 N")
        self.assertEqual(self.said()["block"], "box0")
        value("document.querySelector('#notes li').click()")
        self.assertEqual(value("document.getElementById('picked-title').textContent"), "box1")
        self.assertEqual(value("[...quoin.complained]"), [2])
        self.clean()

    def test_water_and_a_block_that_is_removed(self):
        """Pressure grows with the depth and ends at the table; what is removed is neither drawn nor picked from then on, others keep their colours."""
        stages = [{"analysis": "static", "on_mechanism": "remove"}, {"analysis": "dynamic", "duration": 0.02}]
        scene = self.scene_of_boxes([0, 1, 0.5], [2, 0, 0], stages=stages, water=[{"level": 0.75, "blocks": ["box0"], "towards": [-1, 0, 0]}])
        value = self.opened(scene)
        rims = value("quoin.marks.list.filter(mark => mark.kind === 'water').map(mark => mark.rim)")
        self.assertEqual(len(rims), 1)
        for _, _, z, pressure in rims[0]:
            self.assertAlmostEqual(pressure, 9810 * max(0, 0.75 - z), places=6)
        run = self.folder / "run"
        self.quoin("run", scene, "--out", run, code=0)
        value = self.opened(run)
        there = "[1, 2, 3].map(b => quoin.blocks.shown(b, quoin.state.frame))"
        tints = "[1, 3].map(b => [...quoin.blocks.values.image.data.slice(4 * b, 4 * b + 3)])"
        self.assertEqual(value(there), [True, True, True])
        before = value(tints)
        value("quoin.show(1)")
        self.assertEqual((value(there), value(tints)), ([True, False, True], before))
        self.assertEqual(value("[quoin.head.times[1], quoin.head.labels[1]]"), [0, "end of stage 1 (static)"])
        self.assertEqual(value("quoin.blocks.pick([0.5, 1.5, 9].map((x, k) => x - quoin.head.offset[k]), [0, 0, -20], 1)"), 0)
        self.clean()

    def test_a_scene_that_is_refused(self):
        value = self.opened(self.scene_of_boxes([0, 0, 0.95]))
        notes = value("document.getElementById('notes').textContent")
        self.assertIn("quoin run refuses this scene", notes)
        self.assertIn("overlap of 0.05 m between box0 and box1", notes)
        self.clean()

    def test_a_scene(self):
        value = self.opened(self.made("tower", "--blocks", "3"))
        self.assertEqual(value("quoin.blocks.count"), 4)
        self.assertEqual(value("quoin.joints.list.length"), 3)
        self.assertIn("3 touching pairs", value("document.getElementById('facts').textContent"))
        far = value("quoin.blocks.distance([4, 0.5, 1].map((x, k) => x - quoin.head.offset[k]), 0)")
        self.assertAlmostEqual(far, 5 ** 0.5, places=5)  # to the edge of the ground: what is nearer than half of it is not drawn
        through = "quoin.blocks.pick([0, 0, {}].map((x, k) => x - quoin.head.offset[k]), [0, 0, {}], 0)"
        self.assertEqual([value(through.format(9, -20)), value(through.format(-9, 20))], [3, 0])  # the first on the ray
        self.clean()

    def test_a_long_wall_stays_whole_when_the_window_narrows(self):
        beyond = """(() => Math.max(...[0, 1, 2, 3, 4, 5, 6, 7].map((i) => {
            const ends = [quoin.low, quoin.high], corner = quoin.middle.clone();
            corner.set(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2].z).project(quoin.camera);
            return Math.max(Math.abs(corner.x), Math.abs(corner.y)); })))()"""
        self.browser.size(1280, 730)
        value = self.opened(self.made("wall", "--length", "20", "--height", "2"))
        self.assertLess(value(beyond), 1)
        self.browser.size(1280, 800)
        self.browser.value("new Promise((done) => requestAnimationFrame(() => setTimeout(done, 100)))")
        self.assertLess(value(beyond), 1)
        self.clean()

    def test_pairs(self):
        pairs = self.folder / "pairs.jsonl"
        box = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
        upper = [[x + 0.5, y, z + 1] for x, y, z in box]
        apart = [[x, y, z + 1.5] for x, y, z in box]
        pairs.write_text("".join(json.dumps({"id": name, "a": box, "b": b}) + "\n"
                                 for name, b in (("on it", upper), ("above", apart))))
        value = self.opened("--pairs", pairs)
        self.assertEqual(value("quoin.frames"), 2)
        self.assertEqual(self.said()["type"], "face-face")
        self.assertEqual(self.said()["area"], "0.5 m²")
        value("quoin.show(1)")
        self.assertEqual(self.said()["gap"], "0.5 m")
        self.clean()

    def test_what_can_not_be_shown_is_told_in_a_line(self):
        for words in ((), ("none",), ("--pairs", "none"), (self.folder,)):
            done = self.quoin("view", *words)
            self.assertNotEqual(done.returncode, 0)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)


class Template(FolderTest):
    @unittest.skipIf(shutil.which("npm") is None, "no npm")
    def test_is_what_its_sources_make(self):
        copy = self.folder / "viewer"
        shutil.copytree(SOURCE / "tools" / "viewer", copy, ignore=shutil.ignore_patterns("node_modules", "dist"))
        installed = subprocess.run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"], cwd=copy, capture_output=True)
        if installed.returncode:
            self.skipTest("npm can't fetch its packages")
        subprocess.run(["sh", "build.sh", self.folder / "page.html"], cwd=copy, check=True)
        self.assertEqual((self.folder / "page.html").read_bytes(),
                         (SOURCE / "tools" / "viewer" / "dist" / "page.html").read_bytes())


if PROGRAM is None or subprocess.run(["/usr/bin/python3", "-c", "import numpy"], capture_output=True).returncode:
    print("skipped: no chromium, or no numpy")
else:
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
