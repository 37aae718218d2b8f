"""Monte Carlo of a rock slope on all cores: how likely a block on a joint of uncertain dip and friction slides or
topples. Each sample is decided by a proof, and held against the closed form. Writes rock_slope.png."""
import argparse
import functools
import multiprocessing

import matplotlib.pyplot as plt
import numpy as np
import quoin

WIDTH, HEIGHT = 1.0, 1.6  # of the block along the dip and across the joint, m
DIP, FRICTION = (28.0, 4.0), (33.0, 4.0)  # mean and standard deviation, degrees


@functools.cache
def slope():
    scene = quoin.Scene(materials={"rock": {"density": 2600.0}}, joint={"friction_angle_deg": "=phi"}, end_time=1.0,
                        parameters={"dip": 0, "phi": 0}, gravity=["=9.81*sin(dip*deg)", 0, "=-9.81*cos(dip*deg)"])
    scene.add(quoin.Shape.box([-5, -5, -1], [5, 5, 0]), name="joint plane", kind="fixed")
    scene.add(quoin.Shape.box([0, 0, 0], [WIDTH, 1, HEIGHT]), name="block", kind="rigid", material="rock")
    return scene


def falls(sample):
    dip, phi = sample
    return quoin.equilibrium(slope(), changes=[f"dip={dip}", f"phi={phi}"]).verdict == "mechanism"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=4000, help="samples")
    parser.add_argument("--out", default="rock_slope.png")
    arguments = parser.parse_args()
    generator = np.random.default_rng(1)
    dip, phi = (generator.normal(*law, arguments.count).clip(1, 80) for law in (DIP, FRICTION))
    with multiprocessing.Pool() as pool:
        fallen = np.array(pool.map(falls, np.column_stack([dip, phi]).tolist(), chunksize=50))
    expected = np.tan(np.radians(dip)) > np.minimum(np.tan(np.radians(phi)), WIDTH / HEIGHT)
    likely = fallen.mean()
    print(f"{likely:.3f} +- {2 * np.sqrt(likely * (1 - likely) / len(fallen)):.3f} of {len(fallen)} samples fall; "
          f"{(fallen == expected).sum()} as the closed form has it")

    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.5), constrained_layout=True)
    for which, colour, name in ((~fallen, "steelblue", "stands"), (fallen, "crimson", "falls")):
        left.plot(dip[which], phi[which], ".", color=colour, ms=3, label=name)
    line = np.linspace(*left.get_xlim(), 200)
    left.plot(line, line, "k-", lw=1, label="slides, closed form")
    left.axvline(np.degrees(np.arctan(WIDTH / HEIGHT)), color="k", ls="--", lw=1, label="topples, closed form")
    left.set(xlabel="dip, degrees", ylabel="friction angle, degrees", ylim=(phi.min() - 1, phi.max() + 1))
    left.legend(loc="upper right")
    number = np.arange(1, len(fallen) + 1)
    mean = np.cumsum(fallen) / number
    width = 2 * np.sqrt(mean * (1 - mean) / number)
    right.fill_between(number, mean - width, mean + width, alpha=0.3, label="2 standard errors")
    right.plot(number, mean)
    right.set(xlabel="samples", ylabel="probability that it falls", xscale="log", ylim=(0, 1))
    right.legend()
    figure.savefig(arguments.out, dpi=120)


if __name__ == "__main__":
    main()
