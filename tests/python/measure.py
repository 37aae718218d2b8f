"""The figures of tools/python/README.md: python3 measure.py PEER (build the target quoin_python_peer first)."""
import pathlib
import resource
import subprocess
import sys
import tempfile
import time
import tracemalloc

import numpy as np
import quoin

ROUNDS, REPEATS = 5, 7


def least_seconds(call, repeats):
    least = np.inf
    for _ in range(repeats):
        start = time.process_time()
        call()
        least = min(least, time.process_time() - start)
    return least


def against_peer(name, ours, *words):
    """Rounds of both in turn; the least of each."""
    own, peer = np.inf, np.inf
    for _ in range(ROUNDS):
        own = min(own, ours())
        peer = min(peer, float(subprocess.run([sys.argv[1], *words], check=True, capture_output=True).stdout))
    print(f"{name}: {own * 1e3:.2f} ms, C++ {peer * 1e3:.2f} ms, ratio {own / peer:.3f}")


def pairs(folder, count=100_000):
    generator = np.random.default_rng(1)
    points = generator.normal(size=(20, 3))
    places = np.zeros((count // 5, 3, 4))
    places[:, :, :3] = np.linalg.qr(generator.normal(size=(len(places), 3, 3)))[0]
    places[:, :, 0] *= np.linalg.det(places[:, :, :3])[:, None]
    places[:, :, 3] = generator.uniform(0, 1.7 * len(places) ** (1 / 3), (len(places), 3))
    order = np.argsort(places[:, 0, 3])
    near = np.array([(i, j) for k in range(1, 6) for i, j in zip(order, np.roll(order, k))])
    near.sort(axis=1)
    for name, values in (("points", points), ("places", places), ("pairs", near.astype(float))):
        values.tofile(folder / name)
    bodies = quoin.Bodies(quoin.Shape(points), places)

    def ours():
        batch = quoin.PairBatch(reach=0.05)
        return least_seconds(lambda: batch.find(bodies, near), REPEATS)

    files = [folder / name for name in ("points", "places", "pairs")]
    against_peer(f"PairBatch.find, {len(near)} pairs", ours, *files, str(REPEATS))


def step(folder, side=8):
    scene = quoin.Scene(materials={"rock": {"density": 2000.0}}, joint={"friction_angle_deg": 35}, blocks=[],
                        end_time=1.0, time_step=0.01)
    scene.add(quoin.Shape.box([-1, -1, -1], [side + 1, side + 1, 0]), kind="fixed")
    for x in range(side):
        for y in range(side):
            scene.add(quoin.Shape.box([x, y, 0], [x + 0.9, y + 0.9, 1]), kind="rigid", material="rock",
                      velocity=[1, 0, 0])
    path = folder / "scene.json"
    path.write_text(scene.to_json())

    def ours():
        def run(simulation):
            return least_seconds(lambda: [simulation.advance() for _ in range(10)], 1)

        return min(run(quoin.Simulation(scene)) for _ in range(5))

    at_rest = quoin.Simulation(scene)
    at_rest.run(steps=100)
    print(f"a step at rest, most of it the module's own: {least_seconds(at_rest.advance, 10_000) * 1e6:.1f} us CPU")
    against_peer(f"10 steps of {side * side} sliding blocks", ours, path, "10")


def leak(calls=1_000_000):
    a, b = quoin.Body(quoin.Shape.box([0, 0, 0], [1, 1, 1])), quoin.Body(quoin.Shape.box([0, 0, 1], [1, 1, 2]))

    def some(count):
        for i in range(count):
            quoin.contacts(a, b)
            if i % 10 == 0:
                try:
                    quoin.Shape([[0, 0, 0]])
                except quoin.InputError:
                    pass

    some(calls // 10)
    resident = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    some(calls)
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - resident
    tracemalloc.start()
    some(calls // 100)
    before = tracemalloc.get_traced_memory()[0]
    some(calls // 100)
    traced = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    print(f"{calls} calls of contacts(): peak memory grew by {grown} KiB, by tracemalloc {traced} bytes")


def imported():
    code = "import numpy, time; t = time.process_time(); import quoin; print(time.process_time() - t)"
    best = min(float(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True).stdout)
               for _ in range(5))
    print(f"import quoin after numpy: {best * 1e3:.0f} ms CPU")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        imported()
        leak()  # before others raise the peak
        pairs(pathlib.Path(name))
        step(pathlib.Path(name))
