#!/usr/bin/env python3
"""Work-precision picture of a study: error against CPU time, with the Pareto front of all points.

    tools/plot_study.py STUDY.json [PEERS.json …] OUT.png [--by KEY …] [--title TEXT]

STUDY.json is what `quoin study --out DIR` left, the others what bench_study left on the same scene.
KEY are the settings that colour the points (default: all but dt).
"""
import argparse
import json
import math
import pathlib

import plot  # colours, marks and style of all pictures
import matplotlib.pyplot as plt

LEAST = 1e-17  # an error of nothing is drawn here
PEERS = ("Bullet SI 50", "Bullet NNCG 100", "ODE step", "ODE quick 50")  # always in the same colours


def read(path):
    return json.loads(pathlib.Path(path).read_text(encoding="utf-8"))


def counted(points):
    return [p for p in points if not p["failure"] and p["error"] is not None
            and math.isfinite(p["error"])]


def front(points):
    """Points that no other beats in both time and error, quickest first."""
    best, chosen = math.inf, []
    for p in sorted(points, key=lambda p: (p["cpu_seconds"], p["error"])):
        if p["error"] < best:
            best = p["error"]
            chosen.append(p)
    return chosen


def label(point, by):
    """A setting that speaks for itself stands alone, a number with its name."""
    settings = point["settings"]
    if "code" in settings:
        return settings["code"]
    words = [value if value[0].isalpha() else f"{key} {value}" for key, value in settings.items()
             if (key in by if by else key != "dt")]
    text = ", ".join(words).replace("augmented_lagrangian", "default").replace("_", " ")
    return f"quoin: {text}" if words else "quoin"


def style(name, order):
    """Peers hollow and dotted, quoin full."""
    if name in PEERS:
        i = PEERS.index(name)
        return {"color": ("#999999", "#555555", "#E69F00", "#A0522D")[i], "linestyle": ":",
                "marker": plot.MARKERS[i], "fillstyle": "none"}
    colours = [plot.COLOURS[i] for i in (3, 4, 0, 2, 5, 7)] + ["#882255", "#6A5ACD"]
    return {"color": colours[order % 8], "linestyle": "-", "marker": plot.MARKERS[order % 8]}


def draw(path, title, studies, by):
    points = [p for study in studies for p in counted(study["points"])]
    if not points:
        raise SystemExit(f"{title}: no point has an error")
    figure, axis = plt.subplots(figsize=(8.6, 4.8), layout="constrained")
    groups = {}
    for p in points:
        groups.setdefault(label(p, by), []).append(p)
    for i, (name, group) in enumerate(groups.items()):
        group.sort(key=lambda p: -p["time_step"])
        axis.loglog([p["cpu_seconds"] for p in group], [max(p["error"], LEAST) for p in group],
                    markersize=5.5, linewidth=1, label=name, **style(name, i))
    best = front(points)
    axis.loglog([p["cpu_seconds"] for p in best], [max(p["error"], LEAST) for p in best],
                color="#dddddd", linewidth=5, marker="o", markersize=11, markeredgewidth=0, zorder=0, label="Pareto front")
    axis.set(xlabel="CPU time of the run (s)", ylabel="error", title=title)
    axis.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    plot.save(figure, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("studies", nargs="+")
    parser.add_argument("picture")
    parser.add_argument("--by", nargs="+")
    parser.add_argument("--title")
    given = parser.parse_args()
    studies = [read(path) for path in given.studies]
    draw(given.picture, given.title or studies[0]["scene"], studies, given.by)


if __name__ == "__main__":
    main()
