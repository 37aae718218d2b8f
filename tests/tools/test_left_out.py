"""What `quoin run --json` says it left out, for scenes that need little; and that time goes by phase."""
import sys
import unittest

from folder_test import FolderTest, block


def brick(x, z, kind="deformable", **changes):
    return block(f"b{x},{z}", [x, 0, z], [x + 1, 1, z + 1], kind, **changes)


def scene(**changes):
    """Block on a slab: deformable, with friction, dynamic."""
    return {"materials": {"stone": {"density": 2600, "young": 5e9, "poisson": 0.25}},
            "joint": {"friction_angle_deg": 30}, "time_step": 0.01, "end_time": 0.2,
            "blocks": [block("slab", [-2, -2, -1], [3, 3, 0], "fixed"), brick(0, 0)], **changes}


class LeftOut(FolderTest):
    def run_scene(self, content):
        return self.told("run", self.written(content))

    def check(self, summary, said, not_said=()):
        lines = summary["left_out"]
        for words in said:
            self.assertTrue(any(words in line for line in lines), f"{words!r} not in {lines}")
        for words in not_said:
            self.assertFalse(any(words in line for line in lines), f"{words!r} in {lines}")

    def test_two_blocks_need_no_tree(self):
        self.check(self.run_scene(scene()),
                   ["2 blocks are one pair", "fixed or prescribed",
                    "no point, face, body or pressure load", "no folder is asked for", "one thread"],
                   ["friction", "rigid", "static"])

    def test_frictionless(self):
        self.check(self.run_scene(scene(joint={"friction_angle_deg": 0})),
                   ["shear forces and friction limits"])
        self.check(self.run_scene(scene(joint={"friction_angle_deg": 0, "cohesion": 10})), [],
                   ["shear forces"])

    def test_rigid(self):
        summary = self.run_scene(scene(blocks=[scene()["blocks"][0], brick(0, 0, kind="rigid")]))
        self.check(summary, ["strain and elasticity of 1 block: rigid"])
        self.assertEqual(summary["system"]["largest_strain"], 0)

    def test_static(self):
        static = {"analysis": "static", "steps": 20}
        rest = scene(stages=[static], blocks=[scene()["blocks"][0], brick(0, 0), brick(1.5, 0)])
        del rest["end_time"]
        summary = self.run_scene(rest)
        self.check(summary, ["the analysis is static"])
        self.assertEqual(summary["energy"]["kinetic"], 0)
        pairs = summary["pairs"]  # two pairs: searched until nobody moves
        self.assertEqual((pairs["candidates"], pairs["searched"]), (8, 8))
        rest["stages"].append({"analysis": "dynamic", "end_time": 0.1})
        self.check(self.run_scene(rest), ["3 blocks, all pairs"], ["static"])  # what one stage needs is not left out

    def test_what_stands_is_not_searched_again(self):
        standing = [brick(x, 0, kind="rigid") for x in (-2, -0.5, 1)]
        falling = brick(0, 20, kind="rigid", velocity=[0, 0, -5])
        pairs = self.run_scene(scene(blocks=scene()["blocks"][:1] + standing + [falling]))["pairs"]
        self.assertEqual(pairs["candidates"], 60)
        self.assertLess(pairs["searched"], 40)

    def test_fixed_pairs_are_not_searched(self):
        base = scene()["blocks"]
        wall = [brick(x, -3, kind="fixed") for x in range(30)]
        self.check(self.run_scene(scene(blocks=base + wall)), ["between blocks that are fixed"], ["tree"])
        self.assertEqual(self.run_scene(scene(blocks=base + wall))["pairs"],
                         self.run_scene(scene(blocks=base))["pairs"])

    def test_penalty(self):
        self.check(self.run_scene(scene(method="penalty")), ["contacts are springs"], ["contacts are exact"])

    def test_time_by_phase(self):
        summary = self.run_scene(scene())
        phases = summary["seconds"]
        self.assertEqual(set(phases), {"detect", "assemble", "solve", "update", "rest"})
        for name, seconds in phases.items():
            self.assertGreater(seconds, 0, name)
        self.assertAlmostEqual(sum(phases.values()), summary["wall_seconds"], places=9)


unittest.main(argv=[sys.argv[0]], verbosity=2)
