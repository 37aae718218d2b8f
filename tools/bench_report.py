#!/usr/bin/env python3
"""Tables and pictures from the result files of the geometry benchmarks.

  bench_report.py --merge OUT.json PART.json …
  bench_report.py RESULT.json --tables OUT.md --pictures DIRECTORY
"""
import argparse
import collections
import json
import math
import os
import sys

# The in-run peer that a workload's times are divided by.
REFERENCES = {"W1": "FCL libccd Convex", "W2": "FCL libccd Convex", "W3": "FCL libccd Convex",
              "W4": "ODE dBoxBox", "W5": "libccd EPA 1e-12", "W6": "FCL libccd Convex",
              "B/broad": "Bullet dbvt", "B/find": "find", "B/t": "find"}
# Goals: workload -> (entry, largest ratio to the reference).
GOALS = {"W1/box": ("quoin", 0.12), "W2/8": ("quoin", 0.17), "W2/16": ("quoin", 0.17),
         "W2/32": ("quoin", 0.17), "W2/64": ("quoin", 0.17), "W2/128": ("quoin", 0.25),
         "W2/256": ("quoin", 0.25), "W3/box": ("quoin warm", 0.04), "W3/32": ("quoin warm", 0.045),
         "W3/128": ("quoin warm", 0.045), "W4/box-overlap": ("quoin", 0.5),
         "W4/box-gap": ("quoin", 0.5), "W4/prism-overlap": ("quoin", 1.9),
         "W4/prism-gap": ("quoin", 1.9),
         **{f"W4/box-tilt-{tilt}": ("quoin batch", 0.5) for tilt in ("1e-9", "1e-6", "1e-3", "1e-2")},
         "W5/box": ("quoin", 0.2), "W5/16": ("quoin", 0.2),
         "W5/64": ("quoin", 0.2), "B/broad-jitter-100000": ("quoin", 0.5),
         "B/broad-drift-100000": ("quoin", 0.5), "B/find-100000": ("find 2 threads", 1 / 1.8)}


def reference_of(workload):
    return next((peer for start, peer in REFERENCES.items() if workload.startswith(start)), None)


def load(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def groups(result):
    """Workload -> entries, in the order of the file."""
    found = collections.OrderedDict()
    for entry in result["results"]:
        found.setdefault(entry["workload"], []).append(entry)
    return found


def reference_time(workload, entries):
    name = reference_of(workload)
    return next((e["nanoseconds"] for e in entries if e["peer"] == name and e["nanoseconds"]), None)


def merge(out, parts):
    files = [load(part) for part in parts]
    merged = {"context": files[0]["context"],
              "results": [entry for file in files for entry in file["results"]]}
    with open(out, "w", encoding="utf-8") as file:
        file.write('{\n  "context": ' + json.dumps(merged["context"]) + ',\n  "results": [\n    ')
        file.write(",\n    ".join(json.dumps(entry) for entry in merged["results"]) + "\n  ]\n}\n")


def time_text(nanoseconds):
    if nanoseconds is None:
        return "–"
    return f"{nanoseconds:.1f}" if nanoseconds < 100 else f"{nanoseconds:.0f}"


def goal_rows(result):
    """(workload, entry, ns, ratio, goal) for every workload with a goal."""
    for workload, entries in groups(result).items():
        if workload not in GOALS:
            continue
        name, goal = GOALS[workload]
        base = reference_time(workload, entries)
        for entry in entries:
            if entry["peer"] == name and base and entry["nanoseconds"]:
                yield workload, entry, entry["nanoseconds"] / base, goal


def bytes_needed(workload):
    """Both solids' placements once and the answer (with four contact points in W4)."""
    family = workload.split("/")[1]
    vertices = 8 if family.startswith("box") else int(family) if family.isdigit() else 0
    answer = 192 + (4 * 120 if workload.startswith("W4") else 0)
    return str(2 * 24 * vertices + answer) if vertices else "–"


def find_goal(result):
    """find() of 1e5 bricks on one thread, against what it cannot do without: each pair at the time it
    takes in the wall of 1e3, and one pass over the placements. ns a pair: (find, parts) or None."""
    times = {(w, e["peer"]): e["nanoseconds"] for w, entries in groups(result).items()
             for e in entries if w.startswith("B/find-")}
    found = [times.get(("B/find-100000", "find")), times.get(("B/find-1000", "pairs alone")),
             times.get(("B/find-100000", "placements once"))]
    return (found[0], found[1] + found[2]) if all(found) else None


def goal_table(result):
    context = result["context"]
    lines = [f"Machine: {context['processor']}, {context['cores']} cores; {context['compiler']}, "
             f"`{context['flags'].strip()}`, {context['build']}; {context['gigahertz']:.2f} cycles a ns.", "",
             "Goals (ratio of medians to the in-run peer):", "",
             "| workload | entry | ns | peer | ns | ratio | goal | | bytes | floor, ns | cycles | times the floor |",
             "|---|---|---|---|---|---|---|---|---|---|---|---|"]
    by_workload = groups(result)
    for workload, entry, ratio, goal in goal_rows(result):
        base = reference_time(workload, by_workload[workload])
        floor = next((e["nanoseconds"] for e in by_workload[workload]
                      if e["peer"].startswith("floor") and e["nanoseconds"]), None)
        far = f"{entry['nanoseconds'] / floor:.0f}" if floor else "–"
        cycles = f"{floor * context['gigahertz']:.0f}" if floor else "–"
        size = bytes_needed(workload) if workload[0] == "W" else "–"
        lines.append(f"| {workload} | {entry['peer']} | {time_text(entry['nanoseconds'])} | "
                     f"{reference_of(workload)} | {time_text(base)} | {ratio:.3f} | {goal:.3g} | "
                     f"{'reached' if ratio <= goal else 'missed'} | {size} | {time_text(floor)} | "
                     f"{cycles} | {far} |")
    if find_goal(result):
        whole, parts = find_goal(result)
        lines.append(f"| B/find-100000 | find | {time_text(whole)} | pairs alone at 1e3 + placements once | "
                     f"{time_text(parts)} | {whole / parts:.3f} | 1.3 | "
                     f"{'reached' if whole <= 1.3 * parts else 'missed'} | – | – | – | – |")
    return lines


def tables(result):
    lines = goal_table(result)
    for workload, entries in groups(result).items():
        base = reference_time(workload, entries)
        error = "area error" if workload.startswith("W4") else "gap error"
        lines += ["", f"**{workload}**", "",
                  f"| peer | ns | ratio | wrong | {error} median | max | |", "|---|---|---|---|---|---|---|"]
        for e in entries:
            if e["setting"]:
                continue
            ratio = f"{e['nanoseconds'] / base:.3f}" if base and e["nanoseconds"] else "–"
            judged = workload[0] == "W"
            wrong = f"{e['wrong']} of {e['pairs']}" if judged else "–"
            errors = (f"{e['error_median']:.1e} | {e['error_max']:.1e}" if judged else "– | –")
            lines.append(f"| {e['peer']} | {time_text(e['nanoseconds'])} | {ratio} | {wrong} | "
                         f"{errors} | {e['note']} |")
    return "\n".join(lines) + "\n"


def put_tables(path, lines):
    """Replaces what stands between the marks in a Markdown file."""
    begin, end = "<!-- goals: written by tools/bench_report.py -->", "<!-- end of goals -->"
    with open(path, encoding="utf-8") as file:
        text = file.read()
    before, rest = text.split(begin, 1)
    after = rest.split(end, 1)[1]
    with open(path, "w", encoding="utf-8") as file:
        file.write(before + begin + "\n" + "\n".join(lines) + "\n" + end + after)


COLOURS = {"quoin": "#c1272d", "FCL libccd": "#1f77b4", "FCL indep": "#7fb2dd", "FCL Box": "#08519c",
           "FCL tree": "#1f77b4", "libccd": "#6a51a3", "Bullet": "#2ca02c", "ODE": "#ff7f0e",
           "find": "#c1272d", "floor": "#555555"}


def colour(peer):
    return next((c for start, c in COLOURS.items() if peer.startswith(start)), "#777777")


def plot_times(result, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    chosen = [(w, [e for e in entries if not e["setting"] and e["nanoseconds"]
                   and "wrong answers" not in e["note"]])
              for w, entries in groups(result).items() if w[0] == "W" and w[1] != "6"]
    figure, axes = plt.subplots(math.ceil(len(chosen) / 4), 4, figsize=(15, 2.3 * math.ceil(len(chosen) / 4)))
    for axis in axes.flat[len(chosen):]:
        axis.set_visible(False)
    for axis, (workload, entries) in zip(axes.flat, chosen):
        entries = sorted(entries, key=lambda e: e["nanoseconds"], reverse=True)
        for row, e in enumerate(entries):
            axis.barh(row, e["nanoseconds"], color=colour(e["peer"]), height=0.75,
                      alpha=1.0 if e["wrong"] == 0 else 0.45)
            wrong = "" if e["wrong"] == 0 else f"  ({100 * e['wrong'] / e['pairs']:.1f} % wrong)"
            axis.text(e["nanoseconds"] * 1.1, row, f"{e['nanoseconds']:.0f}{wrong}", va="center", fontsize=7)
        axis.set_yticks(range(len(entries)), [e["peer"] for e in entries], fontsize=7)
        axis.set_xscale("log")
        times = [e["nanoseconds"] for e in entries]
        axis.set_xlim(min(times) / 3, max(times) * 9)
        axis.set_title(f"{workload}, ns a query", fontsize=9)
        axis.tick_params(axis="x", labelsize=7)
        for side in ("top", "right"):
            axis.spines[side].set_visible(False)
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    plt.close(figure)


def plot_errors(result, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    floor = 1e-20
    chosen = [(w, [e for e in entries if e["nanoseconds"] and not e["peer"].startswith("floor")
                   and not e["note"].startswith("on ")])
              for w, entries in groups(result).items() if w[0] == "W"]
    figure, axes = plt.subplots(math.ceil(len(chosen) / 5), 5, figsize=(17, 3.0 * math.ceil(len(chosen) / 5)),
                                sharey=True)
    for axis in axes.flat[len(chosen):]:
        axis.set_visible(False)
    for axis, (workload, entries) in zip(axes.flat, chosen):
        for e in entries:
            low, high = max(e["error_median"], floor), max(e["error_max"], floor)
            shade = colour(e["peer"])
            axis.plot([e["nanoseconds"]] * 2, [low, high], color=shade, linewidth=1, alpha=0.6)
            axis.plot(e["nanoseconds"], high, marker="o" if not e["setting"] else ".", color=shade,
                      markersize=7 if not e["setting"] else 5)
            axis.plot(e["nanoseconds"], low, marker="_", color=shade, markersize=7)
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_ylim(floor / 3, 10)
        axis.grid(alpha=0.25)
        axis.set_title(workload, fontsize=9)
        axis.tick_params(labelsize=7)
        axis.tick_params(axis="x", which="minor", labelsize=5)
    for axis in axes[:, 0]:
        axis.set_ylabel("error / size: median to max", fontsize=8)
    shown = [name for name in COLOURS if any(e["peer"].startswith(name) for _, g in chosen for e in g)]
    handles = [plt.Line2D([], [], marker="o", linestyle="", color=COLOURS[n], label=n) for n in shown]
    figure.legend(handles=handles, loc="lower right", ncol=len(handles), fontsize=9)
    figure.supxlabel("ns a query", fontsize=9)
    figure.tight_layout(rect=(0, 0.03, 1, 1))
    figure.savefig(path, dpi=80)
    plt.close(figure)


def plot_broad(result, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(1, 3, figsize=(13, 3.6))
    for axis, start in zip(axes, ("B/broad-jitter-", "B/broad-drift-", "B/find-")):
        lines = collections.defaultdict(list)
        for workload, entries in groups(result).items():
            if workload.startswith(start):
                for e in entries:
                    if e["nanoseconds"]:
                        lines[e["peer"]].append((int(workload[len(start):]), e["nanoseconds"]))
        for index, (peer, points) in enumerate(lines.items()):
            axis.plot(*zip(*points), marker="o", label=peer,
                      color=colour(peer) if start != "B/find-" else f"C{index}")
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.grid(alpha=0.25)
        unit = "pair" if start == "B/find-" else "brick"
        axis.set_title(f"{start[:-1]}: ns a {unit} and step", fontsize=9)
        axis.set_xlabel("bricks", fontsize=8)
        if lines:
            axis.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("result", nargs="*")
    parser.add_argument("--merge", metavar="OUT")
    parser.add_argument("--tables", metavar="FILE")
    parser.add_argument("--readme", metavar="FILE", help="put the table of goals between its two marks")
    parser.add_argument("--pictures", metavar="DIRECTORY")
    arguments = parser.parse_args()
    if arguments.merge:
        merge(arguments.merge, arguments.result)
        return 0
    result = load(arguments.result[0])
    if arguments.tables:
        with open(arguments.tables, "w", encoding="utf-8") as file:
            file.write(tables(result))
    if arguments.readme:
        put_tables(arguments.readme, goal_table(result))
    if arguments.pictures:
        plot_times(result, os.path.join(arguments.pictures, "times.png"))
        plot_errors(result, os.path.join(arguments.pictures, "error_against_time.png"))
        plot_broad(result, os.path.join(arguments.pictures, "walls.png"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
