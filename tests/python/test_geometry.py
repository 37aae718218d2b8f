"""The geometry of the Python module against answers in closed form."""
import gc
import threading
import tracemalloc
import unittest

import numpy as np
import quoin


def at(x, y=0.0, z=0.0):
    place = np.eye(4)
    place[:3, 3] = x, y, z
    return place


BRICK = quoin.Shape.box([0, 0, 0], [2, 1, 1])


class Geometry(unittest.TestCase):
    def test_shapes(self):
        cube = quoin.Shape(np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, 8).T)
        self.assertEqual((len(cube.vertices), len(cube.faces), len(cube.edges)), (8, 6, 12))
        self.assertAlmostEqual(cube.volume, 1.0)
        np.testing.assert_allclose(cube.centroid, [0.5, 0.5, 0.5])
        np.testing.assert_allclose(np.diag(cube.second_moment), 1 / 12)
        same = quoin.Shape.from_faces(cube.vertices, cube.faces)
        np.testing.assert_array_equal(same.vertices, cube.vertices)
        prism = quoin.Shape.prism([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [0, 0, 2])
        self.assertAlmostEqual(prism.volume, 1.0)
        with self.assertRaises(ValueError):
            cube.vertices[0, 0] = 3.0

    def test_placements(self):
        turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
        square = at(1, 2, 3)
        square[:3, :3] = turn
        for placement in (square, square[:3], (turn, [1, 2, 3]), [turn.tolist(), (1, 2, 3)]):
            body = quoin.Body(BRICK, placement)
            np.testing.assert_array_equal(body.placement, square)
            np.testing.assert_allclose(body.bounds, [[0, 2, 3], [1, 4, 4]])
        np.testing.assert_array_equal(quoin.Body(BRICK).placement, np.eye(4))

    def test_one_pair(self):
        above = quoin.Body(BRICK, at(1, 0, 1.25))
        nearest = quoin.nearest(BRICK, above)
        self.assertEqual((nearest.status, nearest.gap), ("separated", 0.25))
        np.testing.assert_array_equal(nearest.normal, [0, 0, 1])
        self.assertEqual(nearest.feature_a[0], "face")
        self.assertEqual(quoin.distance(BRICK, above), 0.25)
        self.assertEqual(quoin.distance(BRICK, above, cut_off=0.1), np.inf)
        self.assertFalse(quoin.overlap(BRICK, above))
        self.assertEqual(len(quoin.contacts(BRICK, above)), 0)
        found = quoin.contacts(BRICK, above, reach=0.3)
        self.assertEqual([quoin.CONTACT_TYPES[t] for t in found["type"]], 4 * ["face-face"])
        self.assertAlmostEqual(found["area"].sum(), 1.0)
        np.testing.assert_allclose(found["point"].mean(axis=0), [1.5, 0.5, 1.125])
        whole = quoin.pair_contact(BRICK, above)
        self.assertEqual((whole.type, whole.area, len(whole.polygon)), ("face-face", 1.0, 4))
        above.move(at(1, 0, 0.75))
        self.assertEqual(quoin.nearest(BRICK, above).gap, -0.25)
        self.assertTrue(quoin.overlap(BRICK, above))

    def test_rays_and_points(self):
        body = quoin.Body(BRICK, at(0, 0, 5))
        hit = quoin.ray(body, [0.5, 0.5, 0], [0, 0, 2])
        self.assertEqual(hit.s, 2.5)
        np.testing.assert_array_equal(hit.normal, [0, 0, -1])
        self.assertIsNone(quoin.ray(body, [0.5, 0.5, 0], [0, 0, 2], length=2))
        rows = quoin.ray(body, [[0.5, 0.5, 0], [9, 9, 9]], [[0, 0, 1], [0, 0, 1]])
        self.assertEqual(rows["hit"].tolist(), [True, False])
        self.assertEqual(rows["s"].tolist(), [5.0, np.inf])
        self.assertTrue(quoin.contains(body, [1, 0.5, 5.5]))
        self.assertEqual(quoin.contains(body, [[1, 0.5, 5.5], [1, 0.5, 4.9]]).tolist(), [True, False])

    def test_cuts(self):
        below, above = quoin.split(BRICK, [0.5, 0, 0], [1, 0, 0])
        self.assertAlmostEqual(below[0].volume, 0.5)
        self.assertAlmostEqual(above[0].volume, 1.5)
        self.assertEqual(sorted(below[1].tolist()), [-1] + sorted(set(below[1].tolist()) - {-1}))
        self.assertEqual(quoin.split(BRICK, [0, 0, 3], [0, 0, 1])[1], None)

    def test_faults_and_rounded_coordinates(self):
        rounded = np.array(BRICK.vertices)
        rounded[0, 0] += 1e-4
        faces = [face.tolist() for face in BRICK.faces]
        (text, refused), *_ = quoin.shape_faults(rounded, faces)
        self.assertTrue(refused)
        with self.assertRaises(quoin.InputError):
            quoin.Shape.from_faces(rounded, faces)
        self.assertAlmostEqual(quoin.Shape.from_faces(rounded, faces, coordinate_rounding=1e-4).volume, 2.0, places=3)
        self.assertEqual(quoin.shape_faults(BRICK.vertices, faces), [])

    def test_time_of_impact(self):
        above = quoin.Body(BRICK, at(0, 0, 3))
        hit = quoin.time_of_impact(BRICK, None, above, ([0, 0, -4], [0, 0, 0]), length=1e-6)
        self.assertEqual(hit.status, "impact")
        self.assertAlmostEqual(hit.s, 0.5, places=6)
        self.assertLess(hit.nearest.gap, 1e-6)
        self.assertEqual(quoin.time_of_impact(BRICK, None, above, ([0, 0, -1], [0, 0, 0])).status, "apart")
        turned = quoin.time_of_impact(BRICK, None, quoin.Body(BRICK, at(0, 0, 1.2)), ([0, 0, 0], [0, np.pi / 2, 0]))
        self.assertEqual(turned.status, "impact")  # the half diagonal reaches lower than the half height


class Finder(unittest.TestCase):
    def test_compounds_and_queries(self):
        finder = quoin.ContactFinder(reach=1e-3)
        ground = finder.add(quoin.Shape.box([-9, -9, -1], [9, 9, 0]), category=2)
        corner = finder.add_compound([BRICK, quoin.Body(BRICK, at(0, 0, 1))], at(0, 0, 0))
        self.assertEqual((corner, len(finder), finder.part_name(corner + 1)), (1, 3, (1, 1)))
        self.assertEqual(set(finder.find()["b"].tolist()), {corner})
        handle, hit = finder.nearest_hit([0.5, 0.5, 9], [0, 0, -1])
        self.assertEqual((handle, hit.s), (corner + 1, 7.0))
        self.assertEqual([h for h, _ in finder.all_hits([0.5, 0.5, 9], [0, 0, -1])], [corner + 1, corner, ground])
        self.assertEqual([h for h, _ in finder.all_hits([0.5, 0.5, 9], [0, 0, -1], categories=2)], [ground])
        self.assertIsNone(finder.nearest_hit([0.5, 0.5, 9], [0, 0, -1], length=3))
        self.assertEqual(finder.bodies_in_box([0, 0, 1.5], [1, 1, 3]).tolist(), [corner + 1])
        self.assertEqual(finder.bodies_at([0.5, 0.5, -0.5]).tolist(), [ground])
        finder.move(corner, at(0, 0, 5))
        self.assertEqual(len(finder.find()), 0)
        for call in (lambda: finder.add_compound([]), lambda: finder.add_compound([3]), lambda: finder.part_name(9),
                     lambda: finder.bodies_in_box([1, 0, 0], [0, 1, 1]), lambda: finder.bodies_at([0, 0, 0], -1.0),
                     lambda: finder.nearest_hit([0, 0, 0], [0, 0, 0]), lambda: finder.add_compound([BRICK, None])):
            with self.assertRaises((ValueError, TypeError, RuntimeError)):
                call()

    def test_events_and_previous(self):
        finder = quoin.ContactFinder(reach=1e-3)
        handles = finder.add_all(BRICK, [at(0), at(1, 0, 1), at(20)])
        self.assertEqual(handles.tolist(), [0, 1, 2])
        found = finder.find()
        self.assertEqual(len(found), 4)
        self.assertEqual(set(found["previous"]), {-1})
        self.assertEqual([quoin.PAIR_EVENTS[e] for e in finder.pairs()["event"]], ["begin"])
        finder.move_all([1], [at(1, 0, 1.0005)])
        self.assertEqual(finder.find()["previous"].tolist(), [0, 1, 2, 3])
        finder.move(1, at(1, 0, 3))
        self.assertEqual(len(finder.find()), 0)
        self.assertEqual([quoin.PAIR_EVENTS[e] for e in finder.pairs()["event"]], ["end"])
        finder.remove(2)
        self.assertEqual((len(finder), 2 in finder, 1 in finder), (2, False, True))
        with self.assertRaisesRegex(quoin.InputError, "2"):
            finder.move(2, at(0))

    def test_filter_and_what_it_raises(self):
        finder = quoin.ContactFinder(reach=1e-3)
        finder.add_all([BRICK, BRICK], [at(0), at(0, 0, 1)])
        finder.set_filter(lambda a, b: False)
        self.assertEqual(len(finder.find()), 0)
        finder.set_filter(lambda a, b: 1 / 0)
        with self.assertRaises(ZeroDivisionError):
            finder.find()
        finder.set_filter(lambda a, b: finder.find())
        with self.assertRaisesRegex(RuntimeError, "has not returned"):
            finder.find()
        finder.set_filter(None)
        self.assertEqual(len(finder.find()), 4)

    def test_batch_gives_what_single_calls_give(self):
        generator = np.random.default_rng(1)
        shapes = [quoin.Shape(generator.normal(size=(12, 3))) for _ in range(20)]
        places = np.array([at(*generator.uniform(0, 4, 3)) for _ in shapes])
        bodies = quoin.Bodies(shapes, places)
        pairs = np.array([(a, b) for a in range(20) for b in range(a + 1, 20)])
        batch = quoin.PairBatch(reach=0.1, threads=2)
        for _ in range(2):
            rows = batch.nearest(bodies, pairs)
            single = [quoin.nearest(quoin.Body(shapes[a], places[a]), quoin.Body(shapes[b], places[b]))
                      for a, b in pairs]
            np.testing.assert_allclose(rows["gap"], [n.gap for n in single], atol=1e-12)
        points = batch.find(bodies, pairs)
        expected = [quoin.contacts(quoin.Body(shapes[a], places[a]), quoin.Body(shapes[b], places[b]), reach=0.1)
                    for a, b in pairs]
        self.assertEqual(len(points), sum(map(len, expected)))
        np.testing.assert_array_equal(points["gap"], np.concatenate([e["gap"] for e in expected]))
        bodies.move(places[:1] + 100 * (np.arange(16).reshape(4, 4) == 3), [0])
        self.assertTrue((batch.find(bodies, pairs)["a"] > 0).all())

    def test_two_threads_in_one_finder(self):
        finder = quoin.ContactFinder(reach=0.1)
        side = np.arange(12)
        finder.add_all(BRICK, [at(2 * x, y, z) for x in side for y in side for z in side])
        refused = []

        def find():
            for _ in range(20):
                try:
                    finder.find()
                except RuntimeError as error:
                    refused.append(str(error))

        threads = [threading.Thread(target=find) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertTrue(all("has not returned" in line for line in refused))
        self.assertGreater(len(finder.find()), 0)


class Memory(unittest.TestCase):
    def test_no_leak_in_many_calls(self):
        finder = quoin.ContactFinder(reach=1e-3)
        finder.add_all(BRICK, [at(0), at(0, 0, 1)])
        body = quoin.Body(BRICK, at(0, 0, 1.5))

        def calls(count):
            for _ in range(count):
                quoin.nearest(BRICK, body)
                quoin.contacts(BRICK, body, 1.0)
                finder.move(1, at(0, 0, 1))
                finder.find()
                quoin.Shape.box([0, 0, 0], [1, 1, 1]).vertices
                try:
                    quoin.Shape.box([0, 0, 0], [0, 1, 1])
                except ValueError:
                    pass

        calls(100)
        tracemalloc.start()
        before, resident = tracemalloc.get_traced_memory()[0], resident_pages()
        calls(5000)
        gc.collect()  # what waits for it is no leak
        grown = tracemalloc.get_traced_memory()[0] - before
        tracemalloc.stop()
        self.assertLess(grown, 20000)
        self.assertLess(resident_pages() - resident, 1000)


def resident_pages():
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1])


if __name__ == "__main__":
    unittest.main()
