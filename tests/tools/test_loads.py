"""Ties, water, quiet faces and turning supports of scene files, against closed forms."""
import csv
import json
import math
import sys
import unittest


from folder_test import FolderTest

G, STONE = 9.81, {"stone": {"density": 2400, "young": 1e10, "poisson": 0.2}}
STATIC = [{"analysis": "static"}]


def box(low, high):
    return {"type": "box", "min": low, "max": high}


def scene(blocks, stages=STATIC, friction=30, **more):
    return {"materials": STONE, "joint": {"friction_angle_deg": friction}, "time_step": 0.01, "stages": stages,
            "blocks": blocks, **more}


def cube(kind, name="cube", low=(0, 0, 0), high=(1, 1, 1)):
    return {"name": name, "kind": kind, "material": "stone", "shape": box(list(low), list(high))}


FLOOR = {"name": "floor", "kind": "fixed", "shape": box([-20, -20, -1], [20, 20, 0])}


class Loads(FolderTest):
    def command(self, name, document, *options):
        return self.quoin(name, self.written(document), "--json", *options)

    def run_scene(self, document):
        return self.told("run", self.written(document), "--out", "out")

    def refused(self, document, *words):
        done = self.command("run", document)
        self.assertEqual(done.returncode, 2, done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)

    def near(self, value, exact, relative):
        self.assertLessEqual(abs(value - exact), relative * abs(exact), (value, exact))

    # Ties

    def test_a_mass_hangs_and_its_tie_is_in_all_files(self):
        for kind in ("rigid", "deformable"):
            tie = {"name": "rod", "from": {"point": [0.5, 0.5, 5]}, "to": {"block": "cube", "point": [0.5, 0.5, 0.5]},
                   "young": 2e11, "area": 1e-3}
            summary = self.run_scene(scene([cube(kind)], ties=[tie]))
            self.near(summary["ties"][0]["force"], 2400 * G, 1e-6)
            self.near(summary["ties"][0]["length"] - 4.5, 2400 * G * 4.5 / 2e8, 1e-4)
            rows = list(csv.DictReader((self.folder / "out" / "ties.csv").read_text().splitlines()))
            self.assertEqual((rows[0]["state"], rows[-1]["name"], rows[-1]["state"]), ("slack", "rod", "elastic"))
            self.assertEqual(float(rows[-1]["force"]), summary["ties"][0]["force"])
            self.assertTrue((self.folder / "out" / "ties_000000.vtp").exists())

    def test_a_bolt_holds_a_sliding_block_grouted_or_not(self):
        slope, friction = math.radians(40), 25
        gravity = [G * math.sin(slope), 0, -G * math.cos(slope)]
        wanted = 2400 * G * (math.sin(slope) - math.cos(slope) * math.tan(math.radians(friction)))
        for more in ({"stiffness": 1e7}, {"young": 2e11, "area": 1.9e-4, "points": 13}):
            for kind in ("rigid", "deformable"):
                tie = {"from": {"block": "floor", "point": [-2.9, 0.5, -0.06]},
                       "to": {"block": "cube", "point": [0.9, 0.5, 0.016]}, **more}
                summary = self.run_scene(scene([FLOOR, cube(kind)], friction=friction, gravity=gravity, ties=[tie]))
                forces = [tie["force"] for tie in summary["ties"]]
                self.assertEqual(len(forces), 1)
                self.near(forces[0], wanted, 2e-2)  # the bolt rises by 1 in 50, and lifts by that

    def test_a_bolt_with_a_point_on_the_joint_is_grouted_however_the_scene_is_turned(self):
        slope, lean, mu = math.radians(40), math.radians(45), math.tan(math.radians(30))
        wanted = (2400 * G * (math.sin(slope) - mu * math.cos(slope)) / (math.cos(lean) + mu * math.sin(lean)))
        axis = [n / math.sqrt(14) for n in (1, 2, 3)]
        for turn in range(0, 360, 17):
            c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))

            def turned(*v, c=c, s=s):  # [Rodrigues 1840]
                along = sum(n * x for n, x in zip(axis, v))
                return [c * v[i] + s * (axis[i - 2] * v[i - 1] - axis[i - 1] * v[i - 2]) + (1 - c) * along * axis[i]
                        for i in range(3)]

            def hull(name, kind, low, high, turned=turned):
                points = [turned(x, y, z) for x in (low, high) for y in (0, 1) for z in ((0, 1) if kind == "rigid" else (-1, 0))]
                return {"name": name, "kind": kind, "material": "stone", "shape": {"type": "hull", "points": points}}

            tie = {"from": {"block": "block", "point": turned(0.9, 0.5, 0.4)}, "points": 13,
                   "to": {"block": "base", "point": turned(0.1, 0.5, -0.4)}, "young": 2e11, "area": 1e-4}
            summary = self.run_scene(scene([hull("base", "fixed", -2, 3), hull("block", "rigid", 0, 1)], ties=[tie],
                                           gravity=turned(G * math.sin(slope), 0, -G * math.cos(slope))))
            self.assertEqual(len(summary["ties"]), 1)
            self.near(summary["ties"][0]["force"], wanted, 2e-3)

    def test_a_tie_rod_takes_the_thrust_of_two_leaning_halves(self):
        # Half arches of one block each: hinges at the crown's top and at the feet's outer edges are not known,
        # but the thrust balances the feet, which slide without friction.
        half = [[0, 0, 0], [1, 0, 0], [2, 0, 2], [2, 0, 3]]
        mirrored = [[4 - x, y, z] for x, y, z in half[::-1]]
        blocks = [FLOOR] + [{"name": name, "kind": "rigid", "material": "stone",
                             "shape": {"type": "prism", "polygon": polygon, "sweep": [0, 1, 0]}}
                            for name, polygon in (("left", half), ("right", mirrored))]
        tie = {"from": {"block": "left", "point": [0.5, 0.5, 0.2]}, "to": {"block": "right", "point": [3.5, 0.5, 0.2]},
               "stiffness": 1e8}
        document = scene(blocks, friction=0, ties=[tie], joint={"friction_angle_deg": 0},
                         monitors=[{"name": "crown", "contact": ["left", "right"]}])
        summary = self.run_scene(document)
        thrust = summary["monitors"]["crown"]["force"][0]
        self.assertGreater(thrust, 1000)
        self.near(summary["ties"][0]["force"], thrust, 1e-5)

    def test_ties_of_a_stage_and_their_mistakes(self):
        tie = {"from": {"point": [0.5, 0.5, 5]}, "to": {"block": "cube", "point": [0.5, 0.5, 0.5]}, "stiffness": 1e6}
        stages = STATIC + [{"analysis": "static", "ties": [{**tie, "pretension": 1000}]}]
        summary = self.run_scene(scene([FLOOR, cube("rigid")], stages))
        self.near(summary["ties"][0]["force"], 1000, 1e-3)
        self.near(summary["base_reaction"][2], -(2400 * G - 1000), 1e-3)
        for change, words in (({"stiffness": 0}, ["/ties/0/stiffness"]), ({"points": 5}, ["/ties/0/stiffness", "young"]),
                              ({"pretension": 1, "rest_length": 4}, ["/ties/0/rest_length", "pretension"]),
                              ({"young": 1}, ["either"]), ({"pretension": -1}, ["tie", "tension only"]),
                              ({"from": {"point": [0.5, 0.5, 0.5]}}, ["tie", "length"])):
            self.refused(scene([FLOOR, cube("rigid")], ties=[{**tie, **change}]), *words)
        self.refused(scene([FLOOR, cube("rigid")], ties=[{**tie, "name": "rod"}] * 2), "/ties/1/name", '"rod"')
        self.refused(scene([FLOOR, cube("rigid")], ties=[{**tie, "from": {"block": "cube", "point": [0, 0, 0]}}]),
                     "both ends are in block 1 (cube)")
        grouted = {"from": {"block": "cube", "point": [0.1, 0.5, 0.5]}, "to": {"block": "cube", "point": [0.9, 0.5, 0.5]},
                   "young": 2e11, "area": 1e-4, "points": 5}
        self.refused(scene([FLOOR, cube("rigid")], ties=[grouted]), "/ties/0/points", "5 points", "one block")
        grouted["from"] = {"point": [0.5, 0.5, 3]}
        self.refused(scene([FLOOR, cube("rigid")], ties=[grouted]), "/ties/0/points", "no block")

    def test_what_acts_on_nothing_is_refused_or_told(self):
        load = {"type": "point", "block": "b", "point": [0, 0, 1], "force": [1, 0, 0]}
        blocks = [FLOOR, cube("rigid"), cube("rigid", "b", (0, 0, 1), (1, 1, 2))]
        for more, word in (({"loads": [load]}, "/stages/1/loads/0/block"),
                           ({"ties": [{"from": {"point": [0, 0, 9]}, "to": {"block": "b", "point": [0, 0, 2]},
                                       "stiffness": 1e6}]}, "/stages/1/ties/0/to/block")):
            stages = [*STATIC, {"analysis": "static", "remove": "b", **more}]
            self.refused(scene(blocks, stages), word, "not there")
        self.refused(scene(blocks, [{"analysis": "static", "ramp": {"by": 1, "to": 2}}]), "/stages/0/ramp", "no loads")
        self.run_scene(scene(blocks, [{"analysis": "static", "ramp": {"by": 1, "to": 2}}], loads=[load]))
        far = {"type": "plane", "name": "far", "dip_deg": 0, "point": [0, 0, 9]}
        cut = {"block": {"kind": "fixed", "material": "stone"}, "body": box([0, 0, 0], [1, 1, 1]), "cuts": [far]}
        self.refused(scene([FLOOR], cut=cut), "/cut/cuts/0", "cuts no block")
        far.update(type="disc", centre=far.pop("point"), radius=1)
        missed = scene([FLOOR, cube("rigid", low=(2, 0, 0), high=(3, 1, 1))], cut=cut)  # of many, one may miss
        self.assertIn('/cut/cuts/0: "far" cuts no block', self.command("run", missed).stderr)
        far["only_in"] = [{"min": [5, 5, 5], "max": [6, 6, 6]}]
        self.refused(scene([FLOOR], cut=cut), "/cut/cuts/0", "only_in leaves no block")
        over = [FLOOR, cube("rigid"), cube("rigid", "b", (0.6, 0, 1), (2.6, 1, 2))]
        done = self.command("run", scene(over, [{"analysis": "static", "on_mechanism": "remove"},
                                                {"analysis": "static", "loads": [load]}]))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("b: its loads act on nothing: it came loose in stage 0", done.stderr)

    def test_slips_of_units_are_told(self):
        tie = {"from": {"point": [0.5, 0.5, 5]}, "to": {"block": "cube", "point": [0.5, 0.5, 0.5]}, "stiffness": 1}
        blocks, light = [FLOOR, cube("rigid")], {"stone": {"density": 24}}
        for more, line in (({"materials": light}, "/materials/stone/density: 24 kg/m3: stone has 2000 to 3000"),
                           ({"water": [{"level": 1, "unit_weight": 9.81}]}, "/water/0/unit_weight: 9.81 N/m3: water has 9810"),
                           ({"water": [{"pressure": "9810*(0.5-z)"}]}, "/water/0/pressure: down to -4905 Pa at the start"),
                           ({"water": [{"pressure": "9810*max(0,0.5-z)"}]}, ""),
                           ({"ties": [{**tie, "break_strain": 5}]}, "/ties/0/break_strain: 5 by rest length: 0.05 is 5 %"),
                           ({"monitors": [{"name": "m", "block": "cube", "point": [3, 0, 0]}]},
                            'block "cube": monitor at (3, 0, 0) m is 2 m or more outside it')):
            done = self.command("run", scene(blocks, **more))
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1 if line else 0, done.stderr)
            self.assertIn(line, done.stderr)
        self.refused({**scene(blocks), "joint": {"mu": 0.6}}, "/joint/mu", "friction_angle_deg")

    def test_what_hangs_comes_to_rest_beyond_a_tenth_of_its_size(self):
        for kind in ("rigid", "deformable"):
            tie = {"from": {"point": [0.5, 0.5, 4]}, "to": {"block": "cube", "point": [0.5, 0.5, 1]}, "stiffness": 1e7,
                   "rest_length": 3.4}
            stage = {"analysis": "static", "until_moved": 1}
            summary = self.run_scene(scene([cube(kind)], [stage], ties=[tie]))
            self.assertEqual(summary["stages"][0]["ended_by"], "rest")
            self.near(summary["ties"][0]["length"], 3.4 + 2400 * G / 1e7, 1e-6)
            stage["until_moved"] = 0.3
            self.assertEqual(self.run_scene(scene([cube(kind)], [stage], ties=[tie]))["stages"][0]["ended_by"], "moved")
            done = self.command("run", scene([cube(kind)], ties=[tie]))
            self.assertIn("mechanism", done.stderr)

    # Water

    def test_a_block_under_uplift(self):
        for kind in ("rigid", "deformable"):
            water = {"pressure": "5000 + 3000*x", "on": "joints"}
            summary = self.run_scene(scene([FLOOR, cube(kind)], water=[water]))
            self.near(-summary["base_reaction"][2], 2400 * G - 6500, 1e-6)
            row = list(csv.DictReader((self.folder / "out" / "joints.csv").read_text().splitlines()))[-1]
            centre = (2400 * G * 0.5 - (5000 / 2 + 3000 / 3)) / (2400 * G - 6500)
            self.near(float(row["x"]), centre, 1e-5)
            # Below the water table on all sides: Archimedes.
            summary = self.run_scene(scene([FLOOR, cube(kind)], water=[{"level": 3}]))
            self.near(-summary["base_reaction"][2], 2400 * G - 9810, 1e-5)  # by the areas of the start
            # Free faces alone: no uplift, and the weight of 2 m of water.
            summary = self.run_scene(scene([FLOOR, cube(kind)], water=[{"level": 3, "on": "free"}]))
            self.near(-summary["base_reaction"][2], 2400 * G + 2 * 9810, 1e-5)

    def test_uplift_beyond_the_weight_lifts_the_block_and_its_work_is_booked(self):
        stages = [{"analysis": "dynamic", "duration": 0.2}]
        summary = self.run_scene(scene([FLOOR, cube("rigid")], stages, water=[{"pressure": 30000, "on": "joints"}],
                                       monitors=[{"name": "m", "block": "cube"}]))
        net = 30000 - 2400 * G
        self.near(summary["monitors"]["m"]["displacement"][2], 0.5 * net / 2400 * 0.2 ** 2, 1e-9)
        self.near(summary["energy"]["work"], 30000 * 0.5 * net / 2400 * 0.2 ** 2, 1e-9)
        self.assertLess(abs(summary["energy"]["closure"]), 1e-6)

    def dam(self, width, height, water=True):
        polygon = [[0, 0, 0], [width, 0, 0], [0, 0, height]]
        dam = {"name": "dam", "kind": "rigid", "material": "stone",
               "shape": {"type": "prism", "polygon": polygon, "sweep": [0, 1, 0]}}
        uplift = f"9810*{height}*(1 - x/{width})"
        loads = [{"level": height, "on": "free", "towards": [-1, 0, 0]}, {"pressure": uplift, "on": "joints"}]
        return scene([FLOOR, dam], water=loads if water else [])

    def test_a_gravity_dam(self):
        width, height = 8.6, 10.0
        weight, uplift = 2400 * G * width * height / 2, 9810 * height * width / 2
        push = 9810 * height ** 2 / 2
        summary = self.run_scene({**self.dam(width, height), "joint": {"friction_angle_deg": 45}})
        self.near(-summary["base_reaction"][2], weight - uplift, 1e-6)
        self.near(summary["base_reaction"][0], push, 1e-6)
        done = self.command("limit", self.dam(width, height), "--vary", "friction=0:60", "--loading", "0")
        self.assertEqual(done.returncode, 0, done.stderr)
        report = json.loads(done.stdout)
        critical = math.degrees(math.atan(push / (weight - uplift)))
        for side in ("stands", "falls"):
            self.near(report[side]["value"], critical, 2e-4)
        # As a factor of safety at mu 0.6.
        strong = self.dam(width, height)
        strong["joint"]["friction_angle_deg"] = math.degrees(math.atan(0.6))
        done = self.command("limit", strong, "--vary", "strength=0.1:5", "--loading", "0")
        self.near(json.loads(done.stdout)["stands"]["value"], 0.6 * (weight - uplift) / push, 2e-4)

    def test_faces_inside_a_compound_are_not_wet(self):
        """Of the top of the foot of an L-stone what lies below its tower is no surface."""
        ell = {"name": "ell", "kind": "rigid", "material": "stone",
               "parts": [box([0, 0, 0], [2, 1, 1]), box([0, 0, 1], [1, 1, 3])]}
        for on in ("all", "free"):
            water = {"pressure": 5000, "on": on, "towards": [0, 0, 1]}
            summary = self.run_scene(scene([FLOOR, ell], water=[water]))
            self.near(-summary["base_reaction"][2], 4 * 2400 * G + 2 * 5000, 1e-6)

    def test_mistakes_with_water(self):
        for water, words in (({}, ["/water/0", "either"]), ({"pressure": "q*z"}, ["/water/0/pressure"]),
                             ({"pressure": 1, "blocks": "nobody"}, ["/water/0/blocks"]),
                             ({"pressure": 1, "between": ["cube", "floor"]}, ["/water/0/between"]),
                             ({"pressure": 1, "level": 2}, ["/water/0", "either"])):
            self.refused(scene([FLOOR, cube("rigid")], water=[water]), *words)
        self.refused(scene([FLOOR, cube("rigid")], water=[{"level": 1, "towards": [1, 1, 1]}]), "wets no face")
        done = self.command("run", scene([FLOOR, cube("rigid")], water=[{"pressure": "1/(z-z)"}]))
        self.assertEqual(done.returncode, 1)
        self.assertIn("the water pressure on \"cube\" at 0 s is not finite", done.stderr)

    # Supports

    def test_a_quiet_face_bears_what_held_it(self):
        stages = STATIC + [{"analysis": "dynamic", "duration": 0.2}]
        faces = [{"block": "cube", "towards": [0, 0, -1]}]
        summary = self.run_scene(scene([cube("deformable")], stages, quiet_faces=faces,
                                       monitors=[{"name": "m", "block": "cube"}]))
        self.assertLess(abs(summary["monitors"]["m"]["velocity"][2]), 1e-6)

    def test_a_wave_comes_in_at_its_velocity(self):
        """A free top shows twice the incoming wave: it goes by 2 v0 w sqrt(pi) in the end."""
        stone = {"stone": {"density": 2400, "young": 3e10, "poisson": 0}}
        wave = {"formula": ["0", "0", "0.1*exp(-((t-0.015)/0.005)^2)"]}
        faces = [{"block": "cube", "towards": [0, 0, -1], "velocity": wave}]
        summary = self.run_scene({**scene([cube("deformable")], [{"analysis": "dynamic", "end_time": 0.035}],
                                          quiet_faces=faces, gravity=[0, 0, 0],
                                          monitors=[{"name": "m", "block": "cube", "point": [0.5, 0.5, 1]}]),
                                  "materials": stone, "time_step": 5e-5})
        self.near(summary["monitors"]["m"]["displacement"][2], 2 * 0.1 * 0.005 * math.sqrt(math.pi), 1e-3)

    def test_a_wave_leaves_through_a_quiet_face(self):
        """A pulse of 0.05 (1 - cos) m/s for 30 ms: a bonded bar moves on by its integral and is at rest."""
        speed, duration = math.sqrt(2e8 / 2400), 0.03
        wave = {"formula": [f"t < {duration} ? 0.05*(1-cos(2*pi*t/{duration})) : 0", "0", "0"]}
        faces = [{"block": name, "towards": [side, 0, 0], "normal_impedance": 2400 * speed, "shear_impedance": 0,
                  **({"velocity": wave} if side < 0 else {})} for name, side in (("b0", -1), ("b9", 1))]
        bar = [cube("deformable", f"b{i}", (i, 0, 0), (i + 1, 1, 1)) for i in range(10)]
        summary = self.run_scene({**scene(bar, [{"analysis": "dynamic", "end_time": 0.1}], quiet_faces=faces,
                                          gravity=[0, 0, 0], monitors=[{"name": "m", "block": "b5"}]),
                                  "materials": {"stone": {"density": 2400, "young": 2e8, "poisson": 0}},
                                  "joint": {"friction_angle_deg": 30, "tension": 1e9, "cohesion": 1e9}, "time_step": 2e-4})
        self.near(summary["monitors"]["m"]["displacement"][0], 0.05 * duration, 0.01)
        self.assertLess(abs(summary["monitors"]["m"]["velocity"][0]), 0.02 * 0.1)

    def test_a_float_bobs_on_at_its_height_and_rests_where_it_is_in_balance(self):
        """0.02 m below its draught, 2 m wide: omega^2 = g / 0.6 m."""
        def afloat(low, stages):
            wood = {"wood": {"density": 600, "young": 1e9, "poisson": 0.2}}
            block = {**cube("rigid", low=(0, 0, low), high=(2, 2, low + 1)), "material": "wood"}
            return {**scene([block], stages, water=[{"level": 0}], time_step=0.02,
                            monitors=[{"name": "m", "block": "cube"}]), "materials": wood}

        period = 2 * math.pi / math.sqrt(G / 0.6)
        summary = self.run_scene(afloat(-0.62, [{"analysis": "dynamic", "end_time": 10.5 * period}]))
        self.near(summary["monitors"]["m"]["displacement"][2], 0.04, 0.02)
        self.assertEqual(self.run_scene(afloat(-0.6, STATIC))["stages"][0]["verdict"], "rest")
        summary = self.run_scene(afloat(-0.63, STATIC))
        self.near(summary["monitors"]["m"]["displacement"][2], 0.03, 1e-6)

    def test_a_block_whose_loads_cancel_is_no_mechanism(self):
        load = {"type": "point", "block": "cube", "point": [0.7, 0.65, 3.35], "force": [0, 0, 17799.264]}
        free = cube("rigid", low=(0.1, 0.2, 3.0), high=(1.3, 1.1, 3.7))
        self.assertEqual(self.run_scene(scene([FLOOR, free], loads=[load]))["stages"][0]["verdict"], "rest")

    def test_a_support_turns(self):
        """A cube sticks to a slowly tilting table until the angle of friction."""
        table = {**FLOOR, "kind": "prescribed",
                 "motion": {"rotation": {"formula": ["0", "0.4*(1 - cos(t))", "0"]}, "centre": [0, 0, 0]}}
        monitors = [{"name": "cube", "block": "cube", "relative_to": "floor"}, {"name": "table", "block": "floor"}]
        for angle, slides in ((0.27, False), (0.45, True)):
            end = round(math.acos(1 - angle / 0.4), 2)
            summary = self.run_scene(scene([table, cube("rigid")], [{"analysis": "dynamic", "end_time": end}],
                                           friction=20, monitors=monitors))
            self.near(summary["monitors"]["table"]["rotation"][1], 0.4 * (1 - math.cos(end)), 1e-9)
            moved = math.hypot(*summary["monitors"]["cube"]["displacement"])
            (self.assertGreater if slides else self.assertLess)(moved, 1e-3)


unittest.main(argv=sys.argv[:1] + sys.argv[3:])
