#!/usr/bin/env python3
"""Writes tools/scenes/study/*.json: rigid scenes with exact answers, compared with other codes.

    tools/make_study_scenes.py [FOLDER]

The exact numbers are computed here: rocking by its equation of motion, the rest in closed form.
"""
import json
import math
import pathlib
import sys

import moving_scenes

FOLDER = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else
                      pathlib.Path(__file__).resolve().parent / "scenes" / "study")
G = 9.81


def box(name, low, high, **more):
    kind = {"kind": "rigid", "material": "stone"} if more.pop("moves", True) else {"kind": "fixed"}
    return {"name": name, **kind, "shape": {"type": "box", "min": low, "max": high}, **more}


def scene(title, description, density, friction, blocks, **more):
    return {"title": title, "description": description, **more.pop("first", {}),
            "materials": {"stone": {"density": density}},
            "joint": {"friction_angle_deg": friction}, "blocks": blocks, **more}


def write(name, document):
    FOLDER.mkdir(parents=True, exist_ok=True)
    text = "// Written by tools/make_study_scenes.py.\n" + json.dumps(document, indent=1) + "\n"
    (FOLDER / f"{name}.json").write_text(text, encoding="utf-8")


def friction_limit():
    """A cube a tenth of a degree under or over its friction angle."""
    tilt = {"rotation": {"axis": [0, 1, 0], "angle_deg": 20}}
    return scene(
        "Cube on 20 degrees, friction 20.1 or 19.9",
        "Under friction 20.1 it stays (error in m), under 19.9 it slides.", 2600, "=phi",
        [box("plane", [-5, -5, -1], [60, 5, 0], moves=False, pose=tilt),
         box("cube", [-0.5, -0.5, 0], [0.5, 0.5, 1], pose=tilt)],
        first={"parameters": {"phi": 19.9}}, time_step=0.01, end_time=10,
        monitors=[{"name": "cube", "block": "cube"}],
        references=[{"name": "displacement", "monitor": "cube", "quantity": "displacement",
                     "along": ["=cos(20*deg)", 0, "=-sin(20*deg)"],
                     "exact": "g/2 * max(0, sin(20*deg) - cos(20*deg)*tan(phi*deg)) * t^2",
                     "allowed": 1e-8}])


def tower(count):
    """Cubes one on another from rest: no drift, and at each interface the weight above."""
    cubes = [box(f"cube {i + 1}", [-0.5, -0.5, i], [0.5, 0.5, i + 1]) for i in range(count)]
    below = ["base"] + [cube["name"] for cube in cubes]
    monitors = [{"name": f"joint {i + 1}", "contact": [below[i], below[i + 1]]}
                for i in range(count)]
    references = [{"name": f"force {i + 1}", "monitor": f"joint {i + 1}", "quantity": "force",
                   "component": "z", "exact": f"{count - i}*2600*g", "from": 4.9, "until": 5,
                   "allowed": 1e-7 if count <= 10 else 1e-6} for i in range(count)]
    monitors.append({"name": "top", "block": below[-1]})
    references.append({"name": "drift", "monitor": "top", "quantity": "displacement", "exact":
                       [0, 0, 0], "allowed": 1e-6 if count <= 10 else 1e-5})
    return scene(f"Tower of {count} cubes", "At rest for 5 s. Error: the larger of the drift of the "
                 "top (m) and the largest relative error of a force.", 2600, 35,
                 [box("base", [-5, -5, -1], [5, 5, 0], moves=False)] + cubes,
                 time_step=0.01, end_time=5, monitors=monitors, references=references)


def dominoes():
    """Four dominoes; no exact answer once they have met: compared with the finest run."""
    blocks = [box("base", [-5, -5, -1], [10, 5, 0], moves=False)]
    for i in range(4):
        low = round(0.6 * i, 1)
        blocks.append(box(f"domino {i + 1}", [low, 0, 0], [round(low + 0.3, 1), 1, 1.5]))
    blocks[1].update({
        "pose": {"rotation": {"axis": [0, 1, 0], "angle_deg": 11.4}, "about": [0.3, 0, 0]},
        "angular_velocity": [0, "=push", 0],
        "velocity": ["=push*(0.75*cos(11.4*deg) + 0.15*sin(11.4*deg))", 0,
                     "=push*(0.15*cos(11.4*deg) - 0.75*sin(11.4*deg))"]})
    return scene(
        "Four dominoes", "The first stands past its balance (11.31 degrees), almost touches the second "
        "(at 11.54) and turns about its lower edge: with a push of 1 rad/s the row falls, without it "
        "leans. No exact answer: displacements at the end against the finest run.", 2700, 10, blocks,
        first={"parameters": {"push": 1}}, time_step=0.005, end_time=0.4,
        monitors=[{"name": f"domino {i + 1}", "block": f"domino {i + 1}"} for i in range(4)])


class Rocker:
    """Rigid block b x h that rocks about its edges [Housner 1963]: tilt(t) from rest at `tilt`."""

    def __init__(self, width, height, tilt):
        self.alpha, self.tilt0 = math.atan(width / height), tilt
        self.square = 0.75 * G / math.hypot(width / 2, height / 2)  # p^2, 1/s2
        self.ratio = 1 - 1.5 * math.sin(self.alpha) ** 2            # of the rates at an impact

    def acceleration(self, tilt):
        return -self.square * math.copysign(math.sin(self.alpha - abs(tilt)), tilt)

    def step(self, tilt, rate, dt):
        """Classical Runge-Kutta."""
        k1 = rate, self.acceleration(tilt)
        k2 = rate + dt / 2 * k1[1], self.acceleration(tilt + dt / 2 * k1[0])
        k3 = rate + dt / 2 * k2[1], self.acceleration(tilt + dt / 2 * k2[0])
        k4 = rate + dt * k3[1], self.acceleration(tilt + dt * k3[0])
        return (tilt + dt / 6 * (k1[0] + 2 * k2[0] + 2 * k3[0] + k4[0]),
                rate + dt / 6 * (k1[1] + 2 * k2[1] + 2 * k3[1] + k4[1]))

    def impact(self):
        """Time and rate of the first one: energy, and bisection of the last step."""
        time, tilt, rate, dt = 0.0, self.tilt0, 0.0, 1e-4
        while True:
            ahead = self.step(tilt, rate, dt)
            if ahead[0] > 0:
                time, (tilt, rate) = time + dt, ahead
            elif dt > 1e-15:
                dt /= 2
            else:
                return time, rate

    def at(self, time, dt=1e-4):
        """Tilt, before the second impact."""
        hit, rate = self.impact()
        left, tilt = time, self.tilt0
        if time > hit:
            left, tilt, rate = time - hit, -1e-300, self.ratio * rate
        else:
            rate = 0.0
        count = math.ceil(left / dt)
        for _ in range(count):
            tilt, rate = self.step(tilt, rate, left / count)
        return tilt


def rocking():
    """A block let go at 7 degrees: its tilt before and after the first impact."""
    rocker = Rocker(0.4, 1.6, math.radians(7))
    times = (0.4, 0.8)
    references = [{"name": f"tilt at {t} s", "monitor": "block", "quantity": "rotation",
                   "along": [0, 1, 0], "exact": {"table": [[t, rocker.at(t) - rocker.tilt0]]},
                   "from": t, "until": t, "allowed": 2e-3} for t in times]
    return scene(
        "Rocking block", "0.4 x 0.4 x 1.6 m, let go at 7 degrees; the first impact is at "
        f"{rocker.impact()[0]:.6f} s (Housner's rate ratio). Steps must divide 0.4 s.", 2600, 60,
        [box("base", [-5, -5, -1], [5, 5, 0], moves=False),
         box("block", [-0.2, -0.2, 0], [0.2, 0.2, 1.6],
             pose={"rotation": {"axis": [0, 1, 0], "angle_deg": 7}, "about": [0.2, 0, 0]})],
        time_step=0.01, end_time=0.8, monitors=[{"name": "block", "block": "block"}],
        references=references)


def arch():
    """27 voussoirs; least thickness / radius 0.106721 by linear programming for these blocks."""
    count, radius = 27, 10
    blocks = []
    for i in range(count):
        points = []
        for k in (i, i + 1):
            angle = math.pi * k / count
            for side in ("-", "+"):
                for y in (-0.5, 0.5):
                    points.append([f"={radius}*(1 {side} ratio/2)*{math.cos(angle):.17g}", y,
                                   f"={radius}*(1 {side} ratio/2)*{math.sin(angle):.17g}"
                                   if 0 < k < count else 0])
        blocks.append({"name": f"voussoir {i + 1}", "kind": "rigid", "material": "stone",
                       "shape": {"type": "hull", "points": points}})
    blocks += [box("right", [8, -2, -1], [12, 2, 0], moves=False),
               box("left", [-12, -2, -1], [-8, 2, 0], moves=False)]
    half = math.tan(math.pi / count / 2)  # a voussoir is a trapezium between straight chords
    area = f"{count}*{radius}^2*ratio*2*{half:.17g}*{math.cos(math.pi / count / 2) ** 2:.17g}"
    references = [{"name": "drift of the crown", "monitor": "crown", "quantity": "displacement",
                   "exact": [0, 0, 0], "allowed": 1e-6}]
    monitors = [{"name": "crown", "block": f"voussoir {count // 2 + 1}"}]
    for side, voussoir in (("right", 1), ("left", count)):
        monitors.append({"name": f"{side} foot", "contact": [side, f"voussoir {voussoir}"]})
        references.append({"name": f"reaction {side}", "monitor": f"{side} foot",
                           "quantity": "force", "component": "z", "from": 4.9, "until": 5,
                           "exact": f"2500*g*{area}/2", "allowed": 1e-6})
    return scene(
        "Semicircular arch of 27 voussoirs", "Stands above thickness/radius 0.106721 (the limit of "
        "these blocks), falls below. Error: the larger of the drift of the crown (m) and the "
        "relative error of the feet's vertical forces.", 2500, 40, blocks,
        first={"parameters": {"ratio": 0.1078}}, time_step=0.01, end_time=5, monitors=monitors,
        references=references)


def watched(document, description):
    """One of moving_scenes.py; no exact answer: displacements of all blocks at the end against the finest run."""
    names = [block["name"] for block in document["blocks"] if block["kind"] == "rigid"]
    return {**document, "time_step": 0.0025, "description": description,
            "monitors": [{"name": name, "block": name} for name in names]}


def main():
    write("friction_limit", friction_limit())
    for count in (10, 30):
        write(f"tower_{count}", tower(count))
    write("dominoes", dominoes())
    write("rocking", rocking())
    write("arch", arch())
    write("first_impacts", watched(moving_scenes.pile(2, 2, 0.35), "Eight turning boxes fall into a bin: until the "
                                   "first of them have hit the floor and each other."))
    write("pulled_base", watched(moving_scenes.pulled_base(6, 0.4), "The base goes off by 8 m/s2: drums slide and "
                                 "topple."))
    write("shaken_wall", watched(moving_scenes.shaken_wall(2, 4, "y", 0.2), "Ten bricks; the base is shaken across "
                                 "them by 0.5 g: the wall leans, opens joints and comes back."))


if __name__ == "__main__":
    main()
