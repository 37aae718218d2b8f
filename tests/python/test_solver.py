"""Scenes, steps and equilibrium from Python, against closed forms and against the command's own run."""
import _thread
import json
import os
import pathlib
import sys
import tempfile
import threading
import time
import unittest

import numpy as np
import quoin

SOURCE = pathlib.Path(sys.argv.pop(1)).resolve()
FLOOR = {"name": "floor", "kind": "fixed", "shape": {"type": "box", "min": [-5, -5, -1], "max": [5, 5, 0]}}


def cube_scene(height=0.0, **members):
    scene = quoin.Scene(title="a cube", materials={"rock": {"density": 2000.0}}, joint={"friction_angle_deg": 30},
                        blocks=[dict(FLOOR)], end_time=0.5, **members)
    scene.add(quoin.Body(quoin.Shape.box([0, 0, 0], [1, 1, 1]), (np.eye(3), [0, 0, height])), name="cube",
              kind="rigid", material="rock")
    return scene


class Scenes(unittest.TestCase):
    def test_dict_in_and_out(self):
        scene = cube_scene()
        again = quoin.Scene(scene.to_dict())
        self.assertEqual(json.loads(again.to_json()), json.loads(scene.to_json()))
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "cube.json"
            path.write_text("// with a comment\n" + scene.to_json())
            read = quoin.read(path)
            self.assertEqual(read, scene.to_dict())
            self.assertEqual(read.folder, folder)

    def test_each_message_is_that_of_the_command(self):
        scene = cube_scene()
        scene["blocks"][1]["kind"] = "solid"
        with self.assertRaisesRegex(quoin.InputError, "^/blocks/1/kind: ") as raised:
            scene.check()
        self.assertNotIn("\n", str(raised.exception))
        with self.assertRaisesRegex(OSError, "can't be read"):
            quoin.read("nowhere.json")
        with self.assertRaisesRegex(quoin.InputError, "density"):
            cube_scene().check(["/materials/rock/density=-1"])
        with self.assertRaises(TypeError):
            quoin.Scene(blocks=[object()]).check()

    def test_a_run_is_the_command_s(self):
        found = quoin.run(quoin.read(SOURCE / "tools/scenes/paper/incline.json"), changes=["phi=0", "/end_time=0.2"])
        self.assertEqual((found["status"], found["failures"]), ("completed", []))
        self.assertLess(found["references"]["displacement"]["error"], 1e-9)
        self.assertAlmostEqual(found["time"], 0.2)
        way = np.linalg.norm(found["monitors"]["block"]["displacement"])
        self.assertAlmostEqual(way, 9.81 * np.sin(np.radians(20)) * 0.02, places=9)


class Steps(unittest.TestCase):
    def test_free_fall_and_views(self):
        simulation = quoin.Simulation(cube_scene(height=3.0), time_step=0.01)
        blocks = simulation.blocks
        self.assertEqual(simulation.block_names, ["floor", "cube"])
        report = simulation.run(until=0.5)
        self.assertEqual((report.status, simulation.step_count), ("converged", 50))
        self.assertIs(simulation.blocks, blocks)
        self.assertAlmostEqual(blocks["velocity"][1, 2], -9.81 * 0.5, places=10)
        self.assertAlmostEqual(blocks["centroid"][1, 2], 3.5 - 9.81 * 0.125, places=10)
        np.testing.assert_allclose(simulation.vertices("cube").mean(axis=0), blocks["centroid"][1])
        with self.assertRaises(ValueError):
            blocks["velocity"][1, 2] = 0.0
        self.assertAlmostEqual(simulation.energy["kinetic"], 0.5 * 2000 * (9.81 * 0.5) ** 2, places=6)

    def test_weight_arrives_in_the_contacts(self):
        simulation = quoin.Simulation(cube_scene(), analysis="static")
        self.assertEqual(simulation.run().verdict, "rest")
        contacts = simulation.contacts
        self.assertAlmostEqual(contacts["normal_force"].sum(), 2000 * 9.81, places=4)
        self.assertEqual({quoin.CONTACT_MODES[m] for m in contacts["mode"]}, {"stick"})
        self.assertAlmostEqual(contacts["area"].sum(), 1.0)

    def test_forces_and_motions_are_functions(self):
        asked = []

        def push(t):
            asked.append(t)
            return [2000.0 * 9.81 * t, 0.0, 2000.0 * 9.81]

        simulation = quoin.Simulation(cube_scene(height=3.0), time_step=0.01, forces={"cube": push},
                                      motions={"floor": lambda t: (0, 0, -1)})
        simulation.run(until=0.1)
        self.assertTrue(asked)
        self.assertAlmostEqual(simulation.blocks["velocity"][1, 2], 0.0, places=9)
        self.assertAlmostEqual(simulation.blocks["velocity"][1, 0], 9.81 * 0.1**2 / 2, delta=6e-3)
        self.assertAlmostEqual(simulation.vertices("floor")[:, 2].max(), -0.1, places=9)

    def test_what_a_function_raises_the_step_raises(self):
        for function, error in ((lambda t: 1 / 0, ZeroDivisionError), (lambda t: [0, 0], quoin.InputError),
                                (lambda t: [0, 0, float("nan")], quoin.InputError), (lambda t: "a", TypeError)):
            for arguments in ({"forces": {"cube": function}}, {"motions": {1: function}}):
                with self.assertRaises(error):
                    quoin.Simulation(cube_scene(), **arguments).advance()

    def test_a_step_within_a_step_is_refused(self):
        simulation = quoin.Simulation(cube_scene(), forces={"cube": lambda t: simulation.advance()})
        with self.assertRaisesRegex(RuntimeError, "has not returned"):
            simulation.advance()

    def test_saved_and_gone_on_with(self):
        first = quoin.Simulation(cube_scene(height=0.2), time_step=0.01)
        first.run(steps=5)
        saved = first.save()
        first.run(steps=30)
        second = quoin.Simulation(cube_scene(height=0.2), time_step=0.01)
        second.run(steps=5)
        self.assertEqual(second.save(), saved)
        second.load(saved)
        second.run(steps=30)
        self.assertEqual(first.blocks.tobytes(), second.blocks.tobytes())
        damaged = [saved[:place] + bytes([saved[place] ^ 0x40]) + saved[place + 1:] for place in range(0, len(saved), 97)]
        for wrong in (b"nothing", saved[:-1], *damaged):
            with self.assertRaisesRegex(quoin.InputError, "damaged|cut short|another"):
                second.load(wrong)
        self.assertEqual(first.blocks.tobytes(), second.blocks.tobytes())

    def test_what_scenes_and_files_are_not_is_one_line(self):
        scene = cube_scene()
        scene["blocks"][0]["velocity"] = [0, float("nan"), 0]
        of_numpy = quoin.Scene(cube_scene(), end_time=np.float32("inf"))
        simulation = quoin.Simulation(cube_scene())
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "list.json").write_text("[1]")
            for kind, says, action in (
                    (quoin.InputError, "^/blocks/0/velocity/1: must be finite, is nan$", scene.check),
                    (quoin.InputError, "^/end_time: must be finite, is inf$", of_numpy.check),
                    (quoin.InputError, "^scene: must be a Scene, is dict$", lambda: quoin.Simulation({})),
                    (quoin.InputError, "list.json: must be of type object, is list$", lambda: quoin.read(folder / "list.json")),
                    (quoin.InputError, "^steps: must be at least 0, is -3$", lambda: simulation.run(steps=-3)),
                    (quoin.InputError, "quoin run --out leaves it$", lambda: quoin.view(folder / "none")),
                    (OSError, "can't be written: ", lambda: simulation.to_vtk("/nowhere/blocks.vtu")),
                    (OSError, "can't be written: ", lambda: simulation.to_vtk(name))):
                with self.assertRaisesRegex(kind, says):
                    action()
            self.assertEqual([path.name for path in folder.iterdir()], ["list.json"])
            self.assertFalse(pathlib.Path(name + ".part").exists())

    def test_copies_of_a_scene_find_its_files(self):
        scene = quoin.Scene(cube_scene(), folder="/elsewhere")
        for copy in (quoin.Scene(scene), scene.copy(), scene | {"title": "other"}):
            self.assertIsInstance(copy, quoin.Scene)
            self.assertEqual(copy.folder, "/elsewhere")

    def test_callback_ends_a_run(self):
        simulation = quoin.Simulation(cube_scene(height=3.0), time_step=0.01)
        simulation.run(until=0.5, callback=lambda: simulation.step_count < 7)
        self.assertEqual(simulation.step_count, 7)
        with self.assertRaises(ZeroDivisionError):
            simulation.run(until=0.5, callback=lambda: 1 / 0)

    def test_bad_arguments(self):
        scene = cube_scene()
        for arguments in ({"time_step": float("nan")}, {"time_step": 0.0}, {"time_step": "a"}, {"analysis": "fast"},
                          {"threads": 0}, {"forces": {"nobody": lambda t: 0}}, {"forces": {7: lambda t: 0}},
                          {"forces": {"cube": 3.0}}, {"motions": {0.5: lambda t: 0}}, {"changes": ["phi"]},
                          {"changes": [3]}, {"forces": 3}):
            with self.subTest(arguments=arguments), self.assertRaises((ValueError, TypeError)):
                quoin.Simulation(scene, **arguments)
        for bad in (None, {}, "scene", 3, quoin.Scene(), quoin.Scene(blocks=[]), quoin.Scene(blocks=3, end_time=1)):
            with self.subTest(scene=bad), self.assertRaises((ValueError, TypeError)):
                quoin.Simulation(bad)
        simulation = quoin.Simulation(scene)
        for call in (lambda: simulation.run(), lambda: simulation.run(until=float("nan")),
                     lambda: simulation.vertices("nobody"), lambda: simulation.vertices(-1),
                     lambda: simulation.stress(2), lambda: simulation.set_velocity("floor", [0, 0, 1]),
                     lambda: simulation.set_velocity("cube", [0, 0, float("inf")]),
                     lambda: simulation.set_analysis("fast"), lambda: setattr(simulation, "time_step", -1.0)):
            with self.assertRaises((ValueError, TypeError)):
                call()
        self.assertEqual(simulation.advance().status, "converged")

    def test_interrupt_within_a_step_and_the_gil(self):
        side = range(14)
        scene = quoin.Scene(materials={"rock": {"density": 2000.0}}, joint={"friction_angle_deg": 35},
                            blocks=[{**FLOOR, "shape": {"type": "box", "min": [-50, -50, -1], "max": [50, 50, 0]}}],
                            end_time=1.0)
        for x in side:
            for y in side:
                for z in range(6):
                    scene.add(quoin.Shape.box([x, y, z], [x + 1, y + 1, z + 1]), kind="rigid", material="rock")
        def first_step(simulation):
            start = time.monotonic()
            try:
                simulation.advance()
            finally:
                taken.append(time.monotonic() - start)

        taken, ticks = [], []
        first, second = (quoin.Simulation(scene, time_step=0.05) for _ in range(2))
        first_step(first)

        def interrupt():
            for _ in range(5):
                time.sleep(taken[0] / 50)
                ticks.append(time.monotonic())
            _thread.interrupt_main()

        thread = threading.Thread(target=interrupt)
        with self.assertRaises(KeyboardInterrupt):
            thread.start()
            first_step(second)
        thread.join()
        self.assertEqual((len(ticks), second.step_count), (5, 0))
        self.assertLess(taken[1], 0.6 * taken[0])  # within the step


class Statics(unittest.TestCase):
    def test_forces_and_mechanism(self):
        stands = quoin.equilibrium(cube_scene())
        self.assertEqual(stands.verdict, "admissible")
        np.testing.assert_allclose(stands.contacts["force"].sum(axis=0), [0, 0, 2000 * 9.81], atol=1e-3)
        falls = quoin.equilibrium(cube_scene(gravity=[0, 7.0, -9.81]))  # tan 30 is less than 7 / 9.81
        self.assertEqual(falls.verdict, "mechanism")
        self.assertGreater(falls.power, falls.dissipation)
        self.assertGreater(falls.velocities[1, 1], 0.1)

    def test_largest_factor(self):
        push = cube_scene(gravity=[0, 0, 0], loads=[{"type": "point", "block": "cube", "point": [0.5, 0.5, 0.1],
                                                     "force": [1000, 0, 0]}])
        found = quoin.equilibrium(cube_scene(), live=push)
        self.assertAlmostEqual(found.factor, 2000 * 9.81 * np.tan(np.radians(30)) / 1000, places=4)
        self.assertFalse(quoin.equilibrium(cube_scene(), live=push, largest=1.0).limited)


class Limits(unittest.TestCase):
    def test_both_sides_are_proved(self):
        found = quoin.limit(cube_scene(), "tilt=0:60", tolerance=1e-3)
        self.assertIsNone(found["why"])
        self.assertAlmostEqual(found["stands"]["value"], 30.0, delta=0.05)
        self.assertLess(found["stands"]["value"], found["falls"]["value"])
        self.assertEqual(found["certificates"]["falls"]["certificate"], "falls")
        with self.assertRaisesRegex(quoin.InputError, "WHAT=FROM:TO"):
            quoin.limit(cube_scene(), "tilt")
        with self.assertRaisesRegex(quoin.InputError, "density"):
            quoin.limit(cube_scene(), "tilt=0:60", changes=["/materials/rock/density=-1"])


class Pages(unittest.TestCase):
    def test_files_and_pages(self):
        simulation = quoin.Simulation(cube_scene(height=0.01), time_step=0.01)
        recording = quoin.Recording(simulation, every=2)
        simulation.run(steps=6, callback=recording)
        self.assertEqual(len(recording), 4)
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            simulation.to_vtk("blocks.vtu", "contacts.vtp")
            self.assertIn(b"UnstructuredGrid", pathlib.Path("blocks.vtu").read_bytes())
            self.assertIn(b"PolyData", pathlib.Path("contacts.vtp").read_bytes())
            recording.save("page.html")
            page = pathlib.Path("page.html").read_text()
            os.chdir("/")
        self.assertIn("cube", page)
        self.assertNotIn("@DATA@", page)
        for shown in (recording, quoin.view(cube_scene()), quoin.view(simulation)):
            self.assertTrue(shown._repr_html_().startswith("<iframe srcdoc="))


if __name__ == "__main__":
    unittest.main()
