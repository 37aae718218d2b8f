#!/usr/bin/env python3
"""Tables and pictures from the result files of the geometry benchmarks.

  bench_report.py --merge OUT.json PART.json …
  bench_report.py RESULT.json --tables OUT.md --readme README.md --pictures DIRECTORY
  bench_report.py COUNTS.json --counts README.md
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
    """Workload -> entries, in the order of the file; a peer's time on another workload only where it has none here."""
    own = {(e["workload"], e["peer"]) for e in result["results"] if not e["note"].startswith("on ")}
    found = collections.OrderedDict()
    for entry in result["results"]:
        if not entry["note"].startswith("on ") or (entry["workload"], entry["peer"]) not in own:
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


def times_of(result):
    """(workload, peer) -> ns, without settings and without rows of another workload."""
    return {(e["workload"], e["peer"]): e["nanoseconds"] for e in result["results"]
            if not e["setting"] and not e["note"].startswith("on ")}


def row(*cells):
    return "| " + " | ".join(cells) + " |"


def head(*names):
    return [row(*names), "|" + "---|" * len(names)]


def ratio_text(time, base):
    return f"{time / base:.2f}" if time and base else "–"


# Walls of bricks in which all candidates touch: workload -> what is done to them.
WALLS = {"B/find-1000": "1000, joints of 1e-5 m, shifted by up to 2e-6 m", "B/find-10000": "1e4, the same",
         "B/find-100000": "1e5, the same",
         "B/tilted-1e-09": "1000, turned by up to 1e-9 rad as well (within `tol` on some bricks, beyond on others)",
         "B/tilted-1e-06": "by up to 1e-6 rad", "B/turning-1000": "by up to 2e-6 rad",
         "B/turning-100000": "1e5, the same", "B/tilted-0.001": "1000, by up to 1e-3 rad",
         "B/tilted-0.01": "by up to 1e-2 rad (bricks overlap)"}


def wall_table(result):
    times = times_of(result)
    lines = head("wall of bricks, each moved in each step", "find", "pairs alone", "ratio", "2 threads", "times as fast",
                 "2 workers in turns, times as fast")
    for workload, text in WALLS.items():
        find, alone, two, turns = (times.get((workload, peer)) for peer in
                                   ("find", "pairs alone", "find 2 threads", "2 workers in turns"))
        if find:
            lines.append(row(text, time_text(find), time_text(alone), ratio_text(find, alone), time_text(two),
                             ratio_text(find, two), ratio_text(find, turns)))
    return lines


def touching_table(result):
    times = times_of(result)
    lines = head("wall", "find", "pairs alone")
    texts = {"B/apart-1000": "three leaves askew, joints of 20 times the reach: boxes meet, bricks do not",
             "B/apart-100000": "the same, 1e5 bricks",
             "B/touching-0": "three leaves, 1000 bricks, touching exactly at faces and edges (7147 pairs)"}
    for workload in [w for w in groups(result) if w.startswith(("B/apart", "B/touching"))]:
        text = texts.get(workload, f"the same with noise of {workload.split('-', 1)[1]} m and rad")
        lines.append(row(text, time_text(times[workload, "find"]), time_text(times[workload, "pairs alone"])))
    return lines


# Manifolds: workload -> (what, goal of the batch by ODE's time).
MANIFOLDS = {"box-overlap": ("boxes, overlap", 0.5), "box-gap": ("boxes, gap", 0.5),
             "box-tilt-1e-9": ("boxes leaning by 1e-9", 0.5), "box-tilt-1e-6": ("1e-6", 0.5),
             "box-tilt-1e-3": ("1e-3", 0.5), "box-tilt-1e-2": ("1e-2", 0.5),
             "prism-overlap": ("prisms of 5–10 sides, overlap", 1.9), "prism-gap": ("prisms, gap", 1.9)}


def manifold_table(result):
    times = times_of(result)
    lines = head("", "alone", "batch", "ODE dBoxBox", "batch / ODE", "goal")
    for name, (text, goal) in MANIFOLDS.items():
        workload = "W4/" + name
        base = times.get((workload, "ODE dBoxBox")) or times.get(("W4/box-overlap", "ODE dBoxBox"))
        batch = times.get((workload, "quoin batch"))
        if batch:
            lines.append(row(text, time_text(times[workload, "quoin warm"]), time_text(batch), time_text(base),
                             ratio_text(batch, base), str(goal)))
    return lines


def batch_goal_table(result):
    times = times_of(result)

    def text(workload, peer):
        return time_text(times.get((workload, peer)))

    def faster(workload):
        return ratio_text(times.get((workload, "find")), times.get((workload, "find 2 threads")))

    return head("", "goal, ns", "reached") + [
        row("apart by more than the reach", "15", f"{text('B/apart-1000', 'find')} in `find`, of which the search for "
            f"candidates {text('B/apart-1000', 'candidates alone')}"),
        row("W3, boxes and 32 vertices", "40, 70",
            f"{text('W3/box', 'quoin warm')} and {text('W3/32', 'quoin warm')} one by one"),
        row("flush bricks, whole manifold", "120", f"{text('W4/box-overlap', 'quoin batch')} with history"),
        row("flush prisms of 5–10 sides", "300", f"{text('W4/prism-overlap', 'quoin batch')} with history"),
        row("`find` of 1e5 bricks, a touching pair", "250", text("B/find-100000", "find")),
        row("two threads of `find`", "1.8 times", f"{faster('B/find-1000')}, {faster('B/find-10000')} and "
            f"{faster('B/find-100000')} at 1e3, 1e4 and 1e5 flush bricks, {faster('B/turning-100000')} at 1e5 that turn")]


def moved_table(result):
    times = times_of(result)
    lines = head("", "quoin, both moved", "FCL libccd Convex", "ratio", "Bullet GjkPair", "ratio")
    for workload in [w for w in groups(result) if w.startswith(("W1/", "W2/"))]:
        moved, fcl, bullet = (times.get((workload, peer)) for peer in
                              ("quoin, both moved", "FCL libccd Convex", "Bullet GjkPair"))
        lines.append(row(workload.split("/")[1] + ("" if "box" in workload else " vertices"), time_text(moved),
                         time_text(fcl), ratio_text(moved, fcl), time_text(bullet), ratio_text(moved, bullet)))
    return lines


def published_table(result):
    by_peer = {(e["workload"], e["peer"]): e for e in result["results"]}
    lines = head("", "published search, us", "wrong by over 0.1 %", "nearest_features, ns", "ratio")
    for workload in groups(result):
        published, ours = by_peer.get((workload, "published search")), by_peer.get((workload, "quoin"))
        if published:
            time = published["nanoseconds"]
            lines.append(row(workload, f"{time / 1e3:.0f}" if time else "–",
                             f"{published['wrong']} of {published['pairs']}",
                             time_text(ours["nanoseconds"]), f"{time / ours['nanoseconds']:.0f}" if time else "–"))
    return lines


def size_table(result):
    times = times_of(result)
    notes = {e["workload"]: e["note"] for e in result["results"]}
    lines = head("bricks", "find alone, ns a pair", "by that of 10000", "bytes a brick")
    for workload in [w for w in groups(result) if w.startswith("B/memory-")]:
        time, first = times[workload, "find"], times.get(("B/memory-10000", "find"))
        lines.append(row(workload.split("-")[1], time_text(time), ratio_text(time, first),
                         notes[workload].split(", ")[1].split()[0]))
    return lines


def count_table(counts):
    """Of tools/count_bench.py: two rows a workload, quoin's entry and its peer."""
    lines = head("workload", "entry", "instructions", "by the peer's", "branches missed", "the peer's",
                 "cache lines missed, 48 KB", "the peer's", "1 MB", "the peer's")
    for ours, peer in zip(counts[::2], counts[1::2]):
        cells = [ours["workload"], ours["peer"], f"{ours['instructions']:.0f}",
                 ratio_text(ours["instructions"], peer["instructions"])]
        for what in ("branches_missed", "first_cache_missed", "second_cache_missed"):
            cells += [f"{entry[what]:.{0 if entry[what] >= 20 else 1}f}" for entry in (ours, peer)]
        lines.append(row(*cells))
    return lines


# The tables of bench/README.md, by the name in their marks.
README_TABLES = {"goals": goal_table, "walls": wall_table, "manifolds": manifold_table, "pairs": batch_goal_table,
                 "touching": touching_table, "sizes": size_table, "moved": moved_table, "published": published_table}


def put_tables(path, tables_by_name):
    """Replaces what stands between each pair of marks in a Markdown file."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    for name, lines in tables_by_name.items():
        begin, end = f"<!-- table {name}: written by tools/bench_report.py -->", "<!-- end of table -->"
        before, rest = text.split(begin, 1)
        text = before + begin + "\n" + "\n".join(lines) + "\n" + end + rest.split(end, 1)[1]
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


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
    rows = max(1, math.ceil(len(chosen) / 4))
    figure, axes = plt.subplots(rows, 4, figsize=(17, 2.3 * rows))
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
        least, most = min(times) / 3, max(times)
        axis.set_xlim(least, most * (most / least) ** 0.8)  # room for the numbers, the same share everywhere
        axis.set_title(f"{workload}, ns a query", fontsize=9)
        axis.tick_params(axis="x", labelsize=7)
        for side in ("top", "right"):
            axis.spines[side].set_visible(False)
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    plt.close(figure)


# One panel for each kind of query.
PANELS = {"W1/box": "distance, boxes", "W2/64": "distance, 64 vertices", "W3/32": "distance in motion, 32 vertices",
          "W5/16": "depth, 16 vertices", "W4/box-overlap": "contact patch, boxes (area)",
          "W4/box-tilt-1e-3": "contact patch, boxes leaning by 1e-3 (area)",
          "W4/prism-overlap": "contact patch, prisms (area)", "W6/parallel": "distance, faces parallel within 1e-9"}


def plot_errors(result, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    floor = 1e-20
    by_workload = groups(result)
    chosen = [(title, [e for e in by_workload[workload] if e["nanoseconds"] and not e["note"].startswith("on ")
                       and not e["peer"].startswith(("floor", "published"))])
              for workload, title in PANELS.items() if workload in by_workload]
    figure, axes = plt.subplots(2, 4, figsize=(15, 7.4), sharey=True, squeeze=False)
    for axis in axes.flat[len(chosen):]:
        axis.set_visible(False)
    for axis, (title, entries) in zip(axes.flat, chosen):
        for e in entries:
            low, high = max(e["error_median"], floor), max(e["error_max"], floor)
            shade = colour(e["peer"])
            axis.plot([e["nanoseconds"]] * 2, [low, high], color=shade, linewidth=1, alpha=0.6)
            axis.plot(e["nanoseconds"], high, marker="o", color=shade, markersize=4 if e["setting"] else 9)
            axis.plot(e["nanoseconds"], low, marker="_", color=shade, markersize=9)
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_xlim(20, 3e4)
        axis.set_ylim(floor / 10, 1e3)
        axis.grid(alpha=0.25)
        axis.set_title(title, fontsize=11)
        axis.set_xlabel("ns a query", fontsize=10)
    for axis in axes[:, 0]:
        axis.set_ylabel("error / size: median (bar) to largest (dot)", fontsize=10)
    shown = [name for name in COLOURS if any(e["peer"].startswith(name) for _, g in chosen for e in g)]
    handles = [plt.Line2D([], [], marker="o", linestyle="", color=COLOURS[n], label=n) for n in shown]
    figure.legend(handles=handles, loc="lower center", ncol=max(1, len(handles)), fontsize=11)
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    figure.savefig(path, dpi=80)
    plt.close(figure)


def plot_broad(result, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(1, 3, figsize=(15, 4.2))
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
        shown = [time for points in lines.values() for _, time in points]
        if shown:  # whole decades: each has its label
            axis.set_ylim(10 ** math.floor(math.log10(min(shown))), 10 ** math.ceil(math.log10(max(shown))))
        axis.grid(alpha=0.25)
        unit = "pair" if start == "B/find-" else "brick"
        axis.set_title(f"{start[:-1]}: ns a {unit} and step", fontsize=9)
        axis.set_xlabel("bricks", fontsize=8)
        if lines:
            axis.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.18), ncol=4 if len(lines) > 3 else 3,
                        frameon=False)
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("result", nargs="*")
    parser.add_argument("--merge", metavar="OUT")
    parser.add_argument("--tables", metavar="FILE")
    parser.add_argument("--readme", metavar="FILE", help="put each table between its two marks")
    parser.add_argument("--counts", metavar="README", help="the result is of count_bench.py: put its table there")
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
        put_tables(arguments.readme, {name: table(result) for name, table in README_TABLES.items()})
    if arguments.counts:
        put_tables(arguments.counts, {"counts": count_table(result)})
    if arguments.pictures:
        plot_times(result, os.path.join(arguments.pictures, "times.png"))
        plot_errors(result, os.path.join(arguments.pictures, "error_against_time.png"))
        plot_broad(result, os.path.join(arguments.pictures, "walls.png"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
