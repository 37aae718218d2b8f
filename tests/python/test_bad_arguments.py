"""Bad arguments of every kind raise one exception each; nothing crashes, nothing is half done."""
import copy
import gc
import pickle
import unittest

import numpy as np
import quoin

BOX = quoin.Shape.box([0, 0, 0], [1, 1, 1])
BODY = quoin.Body(BOX)


class Odd:
    def __array__(self, dtype=None):
        raise RuntimeError("no array")


class Endless:
    def __len__(self):
        return 3

    def __getitem__(self, index):
        raise KeyError(index)


NAN, INF = float("nan"), float("inf")
SCALARS = [None, "text", b"bytes", object(), 1j, [1], {}, Odd(), Endless(), np.zeros(2), lambda: 0]
ROW = [[1, 2, 3]]
VECTORS = SCALARS + [3.0, [1, 2], [1, 2, 3, 4], ROW, [1, 2, "3"], [1, 2, None], [1, 2, 3j], [1, [2], 3],
                     np.zeros((3, 1)), np.array(["a", "b", "c"]), np.zeros(3, dtype="M8[s]"), np.zeros(3, bool)]
NOT_FINITE = [[NAN, 0, 0], [0, INF, 0], [0, 0, -INF]]
CLOUDS = VECTORS + [np.zeros((4, 2)), np.zeros((0, 3)), np.zeros((3, 3)), np.zeros((4, 3)), np.full((8, 3), NAN),
                    np.full((8, 3), 1e300), np.zeros((2, 4, 3)), np.full((3, 3), INF), [[0, 0, 0], [1, 0]]]
PLACEMENTS = ["text", object(), 1.0, [1, 2, 3], np.zeros((4, 4)), np.zeros((3, 3)), -np.eye(4), np.full((4, 4), NAN),
              np.full((3, 4), INF), (np.eye(3), [1, 2]), (np.eye(2), [1, 2, 3]), (np.eye(3), None),
              np.diag([1.0, 1, -1, 1]), np.vstack([np.eye(4)[:3], [1, 0, 0, 1]]), np.eye(4) * 1j, Odd(), {}, (1, 2),
              np.diag([1e200, 1e200, 1e200, 1.0])]
STACKS = PLACEMENTS + [None, np.eye(4), np.zeros((2, 4, 4)), np.full((2, 3, 4), NAN), np.zeros((2, 3, 3)), [np.eye(4), 1]]
FACES = [None, 1, "text", [[0, 1, 2]], [[0, 1], [2, 3]], [[0, 1, 99]] * 4, [[-1, 0, 1]] * 4, [[0.5, 1, 2]] * 4, [[]],
         [], [[0, 1, 2], [0, 1, 2], [0, 1, 2], [0, 1, 2]], [[2**40, 1, 2]], [object()], [Odd()]]
INDICES = ["text", 1.5, [0.5], [[0]], [2**70], [-1], [99], [object()], None, [NAN], Odd()]
LENGTHS = [NAN, INF, -1.0, "text", None, [1.0], 1j, object()]


def finder(**options):
    result = quoin.ContactFinder(**options)
    result.add(BOX)
    return result


def bodies():
    return quoin.Bodies(BOX, np.stack([np.eye(4)] * 2))


def removed():
    result = finder()
    result.remove(0)
    return result


def cases():
    yield from ((quoin.Shape, p) for p in CLOUDS + NOT_FINITE)
    for bad in VECTORS + NOT_FINITE:
        yield quoin.Shape.box, bad, [1, 1, 1]
        yield quoin.Shape.box, [0, 0, 0], bad
        yield quoin.Shape.prism, [[0, 0, 0], [1, 0, 0], [0, 1, 0]], bad
        yield quoin.ray, BODY, [0, 0, 5], bad
        yield quoin.ray, BODY, bad, [0, 0, 1]
    yield from ((quoin.contains, BODY, bad) for bad in VECTORS if bad is not ROW)
    for bad in CLOUDS:
        yield quoin.Shape.prism, bad, [0, 0, 1]
        yield quoin.Shape.from_faces, bad, [[0, 1, 2]]
    yield from ((quoin.Shape.from_faces, BOX.vertices, faces) for faces in FACES)
    for bad in PLACEMENTS:
        yield quoin.Body, BOX, bad
        yield BODY.move, bad
        yield finder().add, BOX, bad
        yield finder().move, 0, bad
    for bad in STACKS:
        yield finder().add_all, BOX, bad
        yield finder().move_all, [0], bad
        yield lambda bad=bad: quoin.PairBatch().find(quoin.Bodies(BOX, bad), [[0, 1]]),
    for bad in SCALARS:
        for call in (quoin.nearest, quoin.contacts, quoin.overlap, quoin.distance, quoin.pair_contact):
            yield call, bad, BODY
            yield call, BODY, bad
        yield finder().add, bad
        yield finder().replace_shape, 0, bad
        yield finder().remove, bad
        yield finder().move, bad, np.eye(4)
        yield quoin.Bodies, bad, np.stack([np.eye(4)])
        yield quoin.PairBatch().find, bad, [[0, 1]]
        yield quoin.Body, bad
    for bad in INDICES:
        yield finder().move_all, bad, np.stack([np.eye(4)])
        yield finder().contacts_of, bad
        yield quoin.PairBatch().find, bodies(), bad
        yield quoin.PairBatch().nearest, bodies(), [[0, 1], bad]
        if bad is not None:
            yield quoin.Bodies, [BOX], np.stack([np.eye(4)]), bad
            yield bodies().move, np.stack([np.eye(4)]), bad
    yield quoin.PairBatch().find, bodies(), [[0, 0]]
    yield quoin.PairBatch().find, bodies(), [[0, 2]]
    yield quoin.PairBatch().nearest, bodies(), [[-1, 1]]
    for bad in LENGTHS:
        yield lambda bad=bad: quoin.ContactFinder(reach=bad),
        yield lambda bad=bad: quoin.PairBatch(reach=bad),
        yield finder().set_reach, bad
    for bad in (NAN, "text", [1.0], object()):
        yield quoin.distance, BODY, BODY, bad
    for bad in (0, -1, 10**6, 2**40, 1.5, "2", None):
        yield lambda bad=bad: quoin.ContactFinder(threads=bad),
        yield lambda bad=bad: quoin.PairBatch(threads=bad),
    for handle in (-1, 1, 2**31, 2**70, 0.5, "0"):
        for call in (finder().remove, finder().placement, lambda h: finder().move(h, np.eye(4)),
                     lambda h: finder().set_reach(0.1, h), lambda h: finder().replace_shape(h, BOX),
                     lambda h: finder().contacts_of([h])):
            yield call, handle
    gone = removed()
    for call in (gone.remove, gone.placement, lambda h: gone.move(h, np.eye(4)), lambda h: gone.replace_shape(h, BOX)):
        yield call, 0
    for bad in (1, "text", [1]):
        yield finder().set_filter, bad
    for kind in (quoin.Shape, quoin.Body, quoin.Bodies, quoin.PairBatch, quoin.ContactFinder, quoin.NearestFeatures):
        yield kind.__new__, kind
        yield object.__new__, kind
        yield type, "Derived", (kind,), {}
    for made in (BOX, BODY, bodies(), finder(), quoin.nearest(BODY, BODY)):
        yield copy.copy, made
        yield pickle.dumps, made
        yield setattr, made, "vertices", 0


class BadArguments(unittest.TestCase):
    def test_each_raises(self):
        count = 0
        for call, *arguments in cases():
            count += 1
            with self.subTest(call=call, arguments=arguments):
                with self.assertRaises(Exception):
                    call(*arguments)
        gc.collect()
        self.assertGreater(count, 500)
        print(f"{count} kinds of bad arguments")

    def test_messages_are_one_line_and_name_the_argument(self):
        for call, text in ((lambda: quoin.Shape(np.zeros((4, 2))), r"^points: shape \(4, 2\), expected \(n, 3\)$"),
                           (lambda: quoin.Shape(["a"]), "^points: dtype <U1, expected real numbers$"),
                           (lambda: quoin.Body(BOX, -np.eye(4)), "^placement: the last row"),
                           (lambda: quoin.Body(BOX, np.diag([1, 1, -1, 1])), "^placement: its determinant is -1")):
            with self.assertRaisesRegex((ValueError, TypeError), text):
                call()

    def test_views_outlive_their_shape(self):
        vertices = quoin.Shape.box([0, 0, 0], [1, 2, 3]).vertices
        gc.collect()
        self.assertEqual(vertices.max(), 3.0)
        body = quoin.Body(quoin.Shape.box([0, 0, 0], [1, 2, 3]))
        gc.collect()
        self.assertEqual(body.bounds.max(), 3.0)

    def test_memory_order_and_dtype_do_not_matter(self):
        points = np.array(BOX.vertices)
        for given in (np.asfortranarray(points), points[::-1][::-1], points.astype(np.float32),
                      points.astype(int), points.tolist(), points.astype(">f8")):
            self.assertEqual(quoin.Shape(given).volume, 1.0)


if __name__ == "__main__":
    unittest.main()
