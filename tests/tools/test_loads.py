"""Ties and water: what files and lines tell of them. What blocks do is in tools/scenes, what is refused in bad_inputs."""
import math
import sys
import unittest

from folder_test import FolderTest, block, box

G, STONE = 9.81, {"stone": {"density": 2400, "young": 1e10, "poisson": 0.2}}
STATIC = [{"analysis": "static"}]


def scene(blocks, stages=STATIC, friction=30, **more):
    return {"materials": STONE, "joint": {"friction_angle_deg": friction}, "time_step": 0.01, "stages": stages,
            "blocks": blocks, **more}


def cube(kind, name="cube", low=(0, 0, 0), high=(1, 1, 1)):
    return block(name, low, high, kind)


FLOOR = block("floor", [-20, -20, -1], [20, 20, 0], "fixed")


class Loads(FolderTest):
    def near(self, value, exact, relative):
        self.assertLessEqual(abs(value - exact), relative * abs(exact), (value, exact))

    def test_a_mass_hangs_and_its_tie_is_in_all_files(self):
        for kind in ("rigid", "deformable"):
            tie = {"name": "rod", "from": {"point": [0.5, 0.5, 5]}, "to": {"block": "cube", "point": [0.5, 0.5, 0.5]},
                   "young": 2e11, "area": 1e-3}
            summary = self.run_scene(scene([cube(kind)], ties=[tie]))
            self.near(summary["ties"][0]["length"] - 4.5, 2400 * G * 4.5 / 2e8, 1e-4)
            rows = self.rows("ties.csv")
            self.assertEqual((rows[0]["state"], rows[-1]["name"], rows[-1]["state"]), ("slack", "rod", "elastic"))
            self.assertEqual(float(rows[-1]["force"]), summary["ties"][0]["force"])
            self.assertTrue((self.folder / "out" / "ties_000000.vtp").exists())

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

    def test_what_acts_on_nothing_is_told(self):
        load = {"type": "point", "block": "b", "point": [0, 0, 1], "force": [1, 0, 0]}
        far = {"type": "disc", "name": "far", "dip_deg": 0, "centre": [0, 0, 9], "radius": 1}
        cut = {"block": {"kind": "fixed", "material": "stone"}, "body": box([0, 0, 0], [1, 1, 1]), "cuts": [far]}
        missed = scene([FLOOR, cube("rigid", low=(2, 0, 0), high=(3, 1, 1))], cut=cut)  # of many, one may miss
        self.run_scene(missed, err='/cut/cuts/0: "far" cuts no block')
        over = [FLOOR, cube("rigid"), cube("rigid", "b", (0.6, 0, 1), (2.6, 1, 2))]
        self.run_scene(scene(over, [{"analysis": "static", "on_mechanism": "remove"},
                                    {"analysis": "static", "loads": [load]}]),
                       err="b: its loads act on nothing: it came loose in stage 0")

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
            done = self.quoin("run", self.written(scene(blocks, **more)), code=0, err=line)
            self.assertEqual(done.stderr.count("\n"), 1 if line else 0, done.stderr)

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
            self.run_scene(scene([cube(kind)], ties=[tie]), code=1, err="mechanism")


unittest.main(argv=sys.argv[:1] + sys.argv[3:])
