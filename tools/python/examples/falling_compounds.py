"""Solids that are not convex fall into a bin: own dynamics, in twenty lines, on ContactFinder. Writes
falling_compounds.png."""
import argparse

import matplotlib.pyplot as plt
import numpy as np
import quoin

# An L of two bricks about its centre of mass, m, of unit density, with a mean moment of inertia for all axes.
PARTS = [quoin.Shape.box([-0.44, -0.2, -0.44], [-0.04, 0.2, 0.76]),
         quoin.Shape.box([-0.04, -0.2, -0.44], [0.76, 0.2, -0.04])]
MASS = sum(part.volume for part in PARTS)
INERTIA = 2 / 3 * sum(np.trace(part.second_moment) + part.volume * part.centroid @ part.centroid for part in PARTS)
STIFFNESS, DAMPING, FRICTION, GRAVITY = 2e4, 80.0, 0.5, 9.81


def turned(rotation, by):
    """Rotations (n, 3, 3) after rotation vectors (n, 3), by Rodrigues' formula."""
    angle = np.linalg.norm(by, axis=1)[:, None, None] + 1e-300
    K = np.cross(np.eye(3), by[:, None] / angle)
    return (np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K) @ rotation


def fall(count, steps, dt):
    generator = np.random.default_rng(1)
    finder = quoin.ContactFinder()
    for low, high in (((-9, -9, -1), (9, 9, 0)), ((-9, -9, 0), (-2, 9, 9)), ((2, -9, 0), (9, 9, 9)),
                      ((-9, -9, 0), (9, -2, 9)), ((-9, 2, 0), (9, 9, 9))):  # a bin of 4 m x 4 m
        finder.add(quoin.Shape.box(low, high), moving=False)
    place = np.zeros((count, 3, 4))
    place[:, :, :3] = np.linalg.qr(generator.normal(size=(count, 3, 3)))[0]
    place[:, :, 0] *= np.linalg.det(place[:, :, :3])[:, None]
    i = np.arange(count)
    place[:, :, 3] = np.column_stack([2.0 * (i % 2) - 1, 2.0 * (i // 2 % 2) - 1, 1.5 + 1.8 * (i // 4)])
    place[:, :, 3] += generator.uniform(-0.1, 0.1, (count, 3))
    handles = np.array([finder.add_compound(PARTS, p) for p in place])
    owner = np.full(handles[-1] + len(PARTS), -1)  # which compound a contact's body belongs to; -1: the bin
    for k in range(len(PARTS)):
        owner[handles + k] = np.arange(count)
    v, w = np.zeros((count, 3)), np.zeros((count, 3))
    fastest = []
    for _ in range(steps):
        found = finder.find()
        found = found[found["gap"] < 0]
        force, torque = np.tile([0, 0, -MASS * GRAVITY], (count, 1)), np.zeros((count, 3))
        a, b = owner[found["a"]], owner[found["b"]]
        arm = [found["point"] - place[i, :, 3] for i in (a, b)]
        speed = [np.where((i >= 0)[:, None], v[i] + np.cross(w[i], r), 0.0) for i, r in zip((a, b), arm)]
        slide = speed[1] - speed[0]
        closing = -(slide * found["normal"]).sum(axis=1)
        push = np.maximum(0.0, -STIFFNESS * found["gap"] + DAMPING * closing)
        slide += closing[:, None] * found["normal"]
        drag = np.minimum(push * FRICTION / (np.linalg.norm(slide, axis=1) + 1e-12), 0.1 * MASS / dt)
        on_b = push[:, None] * found["normal"] - drag[:, None] * slide
        for i, r, f in ((a, arm[0], -on_b), (b, arm[1], on_b)):
            own = i >= 0
            np.add.at(force, i[own], f[own])
            np.add.at(torque, i[own], np.cross(r, f)[own])
        v += dt * force / MASS
        w += dt * torque / INERTIA
        place[:, :, 3] += dt * v
        place[:, :, :3] = turned(place[:, :, :3], dt * w)
        finder.move_all(handles, place)
        fastest.append(np.linalg.norm(v, axis=1).max())
    return place, np.array(fastest)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=24)
    parser.add_argument("--steps", type=int, default=10000)
    parser.add_argument("--out", default="falling_compounds.png")
    arguments = parser.parse_args()
    dt = 5e-4
    place, fastest = fall(arguments.count, arguments.steps, dt)
    print(f"{arguments.count} compounds, {arguments.steps} steps of {dt} s: fastest {fastest[-1]:.3g} m/s, "
          f"lowest centre at {place[:, 2, 3].min():.3f} m")

    figure = plt.figure(figsize=(10, 4.5), constrained_layout=True)
    left = figure.add_subplot(1, 2, 1, projection="3d")
    bodies = [quoin.Body(part, p) for p in place for part in PARTS]
    quoin.plot.blocks(left, bodies, values=np.repeat(np.arange(len(place)), len(PARTS)), cmap="tab20")
    left.set(xlabel="x, m", ylabel="y, m", title="the heap; heights in m")
    right = figure.add_subplot(1, 2, 2)
    right.semilogy(dt * np.arange(len(fastest)), np.maximum(fastest, 1e-6))
    right.set(xlabel="time, s", ylabel="fastest compound, m/s")
    figure.savefig(arguments.out, dpi=120)


if __name__ == "__main__":
    main()
