#!/usr/bin/env python3
"""Work-precision picture of `quoin study … --out DIR`: error against CPU time, with the Pareto front.

    tools/plot_study.py DIR/study.json OUT.png [--by KEY]

KEY is the setting that colours the points (default: the first one but dt).
"""
import argparse
import json
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("study")
    parser.add_argument("picture")
    parser.add_argument("--by")
    arguments = parser.parse_args()
    study = json.loads(pathlib.Path(arguments.study).read_text(encoding="utf-8"))
    points = [p for p in study["points"] if not p["failure"] and p["error"] is not None]
    keys = list(study["points"][0]["settings"])
    by = arguments.by or next((k for k in keys if k != "dt"), keys[0])
    figure, axis = plt.subplots(figsize=(7, 5), layout="constrained")
    for value in dict.fromkeys(p["settings"][by] for p in points):
        chosen = [p for p in points if p["settings"][by] == value]
        axis.loglog([p["cpu_seconds"] for p in chosen], [max(p["error"], 1e-17) for p in chosen],
                    "o", label=f"{by} {value}")
    front = sorted((p["cpu_seconds"], max(p["error"], 1e-17)) for p in points if p["pareto"])
    axis.loglog([x for x, _ in front], [y for _, y in front], "-", color="#888888", label="Pareto front")
    axis.set_xlabel("CPU time, s")
    axis.set_ylabel("error")
    axis.set_title(study["scene"], loc="left")
    axis.grid(color="#e4e4e4")
    axis.legend(frameon=False, fontsize=8)
    figure.savefig(arguments.picture, dpi=110)


if __name__ == "__main__":
    main()
