"""Contacts of two clouds of convex hulls: which pairs overlap, how deep, and how often. Writes hull_clouds.png."""
import argparse

import matplotlib.pyplot as plt
import numpy as np
import quoin


def cloud(count, generator):
    """Shapes of some 20 points in a unit box about their own origin, and turned placements in a cube."""
    shapes = [quoin.Shape(generator.uniform(-0.5, 0.5, (20, 3))) for _ in range(count)]
    places = np.tile(np.eye(4), (count, 1, 1))
    places[:, :3, :3] = np.linalg.qr(generator.normal(size=(count, 3, 3)))[0]
    places[:, :3, 0] *= np.linalg.det(places[:, :3, :3])[:, None]  # rotations, no mirrors
    places[:, :3, 3] = generator.uniform(0, 0.9 * count ** (1 / 3), (count, 3))
    return shapes, places


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000, help="hulls of each cloud")
    parser.add_argument("--out", default="hull_clouds.png")
    arguments = parser.parse_args()
    generator = np.random.default_rng(1)
    finder = quoin.ContactFinder()
    first, second = 1, 2
    finder.add_all(*cloud(arguments.count, generator), category=first, collides_with=second)
    finder.add_all(*cloud(arguments.count, generator), category=second, collides_with=first)
    points, pairs = finder.find(), finder.pairs()
    print(f"{len(pairs)} pairs of {arguments.count} and {arguments.count} hulls touch in {len(points)} points")

    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), constrained_layout=True)
    shown = left.scatter(points["point"][:, 0], points["point"][:, 2], c=-points["gap"], s=4)
    left.set(xlabel="x, m", ylabel="z, m", title="contact points", aspect="equal")
    figure.colorbar(shown, ax=left, label="overlap, m")
    right.hist(-pairs["gap"], bins=30)
    right.set(xlabel="overlap of a pair, m", ylabel="pairs")
    figure.savefig(arguments.out, dpi=120)


if __name__ == "__main__":
    main()
