"""Error against run time of the narrow phase, on pairs whose gap is known exactly. Writes narrow_phase_error.png.

The peer is Gilbert's algorithm (Frank and Wolfe's on the Minkowski difference) on whole arrays of numpy, stopped after
more and more iterations. Packages with compiled narrow phases: bench/README.md.
"""
import argparse
import time

import matplotlib.pyplot as plt
import numpy as np
import quoin


def known_pairs(count, generator):
    """Two hulls each, on either side of a gap between a face of one and a vertex of the other; turned together."""
    shapes, gaps = [], generator.uniform(0.01, 0.5, count)
    for gap in gaps:
        turn = np.linalg.qr(generator.normal(size=(3, 3)))[0]
        lower, upper = (generator.uniform([-1, -1, low], [1, 1, low + 2], (12, 3)) for low in (-2.2, gap + 0.2))
        lower = np.vstack([[[3, 0, 0], [-2, 3, 0], [-2, -3, 0]], lower])
        upper = np.vstack([[[0, 0, gap]], upper])
        shapes += [quoin.Shape(lower @ turn), quoin.Shape(upper @ turn)]
    return shapes, gaps


def gilbert(first, second, iterations):
    """Distances of pairs of clouds (n, points, 3)."""
    nearest = first[:, 0] - second[:, 0]
    rows = np.arange(len(first))
    for _ in range(iterations):
        a = first[rows, np.einsum("npk,nk->np", first, nearest).argmin(axis=1)]
        b = second[rows, np.einsum("npk,nk->np", second, nearest).argmax(axis=1)]
        way = a - b - nearest
        part = -(nearest * way).sum(axis=1) / np.maximum((way * way).sum(axis=1), 1e-300)
        nearest = nearest + np.clip(part, 0.0, 1.0)[:, None] * way
    return np.linalg.norm(nearest, axis=1)


def timed(call):
    start = time.perf_counter()
    return call(), time.perf_counter() - start


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=5000, help="pairs")
    parser.add_argument("--out", default="narrow_phase_error.png")
    arguments = parser.parse_args()
    shapes, gaps = known_pairs(arguments.count, np.random.default_rng(1))
    bodies = quoin.Bodies(shapes, np.tile(np.eye(4), (len(shapes), 1, 1)))
    pairs = np.arange(len(shapes)).reshape(-1, 2)
    batch = quoin.PairBatch()
    marks = []
    for name in ("quoin, first call", "quoin, from the last answer"):
        rows, seconds = timed(lambda: batch.nearest(bodies, pairs))
        marks.append((name, seconds, np.abs(rows["gap"] - gaps).max()))
    most = max(len(shape.vertices) for shape in shapes)
    clouds = np.array([np.resize(shape.vertices, (most, 3)) for shape in shapes])  # repeated to one length
    curve = []
    for iterations in (10, 30, 100, 300, 1000):
        found, seconds = timed(lambda: gilbert(clouds[::2], clouds[1::2], iterations))
        curve.append((seconds, np.abs(found - gaps).max()))
    for name, seconds, error in marks + [("numpy, 1000 iterations", *curve[-1])]:
        print(f"{name}: {seconds / len(gaps) * 1e6:.2f} us a pair, largest error {error:.1e} m")

    figure, axis = plt.subplots(figsize=(6, 4.5), constrained_layout=True)
    axis.loglog(*(np.array(curve) / [len(gaps), 1]).T, "o-", label="Gilbert's algorithm, numpy")
    for name, seconds, error in marks:
        axis.loglog(seconds / len(gaps), max(error, 1e-17), "s", label=name)
    axis.set(xlabel="time of a pair, s", ylabel="largest error of the gap, m", title=f"{len(gaps)} pairs of hulls")
    axis.legend()
    axis.grid(True, which="major", alpha=0.3)
    figure.savefig(arguments.out, dpi=120)


if __name__ == "__main__":
    main()
