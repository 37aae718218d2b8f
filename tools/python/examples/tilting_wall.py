"""A dry wall on a table that is tilted until it falls: a proof on both sides of the limit. Writes tilting_wall.png."""
import argparse

import matplotlib.pyplot as plt
import numpy as np
import quoin

LENGTH, HEIGHT, DEPTH = 0.4, 0.2, 0.2  # of a brick, m


def wall(courses, bricks):
    scene = quoin.Scene(title="a dry wall", materials={"stone": {"density": 2000.0}}, joint={"friction_angle_deg": 35},
                        end_time=1.0, parameters={"tilt": 0},  # degrees, about the y axis
                        gravity=["=9.81*sin(tilt*deg)", 0, "=-9.81*cos(tilt*deg)"])
    scene.add(quoin.Shape.box([-1, -1, -0.2], [LENGTH * bricks + 1, DEPTH + 1, 0]), name="table", kind="fixed")
    for course in range(courses):
        ends = [0.0, *(LENGTH * np.arange(course % 2 / 2 or 1, bricks)), LENGTH * bricks]  # half bricks at the ends
        for left, right in zip(ends, ends[1:]):
            scene.add(quoin.Shape.box([left, 0, HEIGHT * course], [right, DEPTH, HEIGHT * (course + 1)]),
                      kind="rigid", material="stone")
    return scene


def limit(scene, low, high, tolerance):
    """Tilts (degrees) at which it stands and falls, with what proves each."""
    proofs = {}
    while high - low > tolerance:
        tilt = 0.5 * (low + high)
        found = quoin.equilibrium(scene, changes=[f"tilt={tilt}"])
        proofs[found.verdict] = tilt, found
        if found.verdict == "undecided":
            break
        low, high = (tilt, high) if found.verdict == "admissible" else (low, tilt)
    return proofs["admissible"], proofs["mechanism"]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--courses", type=int, default=8)
    parser.add_argument("--bricks", type=int, default=3)
    parser.add_argument("--out", default="tilting_wall.png")
    arguments = parser.parse_args()
    scene = wall(arguments.courses, arguments.bricks)
    (stands, forces), (falls, mechanism) = limit(scene, 0.0, 60.0, 0.01)
    print(f"stands at {stands:.3f} degrees: forces within friction balance all weights to {forces.unbalance:.1g}")
    print(f"falls at {falls:.3f} degrees: along the mechanism weights do {mechanism.power:.4g} W, "
          f"joints take at most {mechanism.dissipation:.4g} W")

    simulation = quoin.Simulation(scene)
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.5), constrained_layout=True)
    quoin.plot.blocks(left, simulation, facecolor="#e8dcc5")
    quoin.plot.forces(left, forces.contacts)
    left.set(title=f"contact forces at {stands:.2f} degrees", xlim=(-0.4, LENGTH * arguments.bricks + 0.4))
    speed = np.linalg.norm(mechanism.velocities[:, :3], axis=1)
    collection = quoin.plot.blocks(right, simulation, values=speed, cmap="viridis")
    figure.colorbar(collection, ax=right, label="speed of the mechanism, to scale")
    right.set(title=f"mechanism at {falls:.2f} degrees", xlim=left.get_xlim())
    figure.savefig(arguments.out, dpi=120)


if __name__ == "__main__":
    main()
