#!/usr/bin/env python3
"""Tables of the benchmarks' result files, put between the marks of the pages in bench/; with pictures, which need matplotlib.

  tables.py --merge OUT.json PART.json …            parts of one run of the geometry benchmarks
  tables.py geometry RESULT.json FOLDER [README.md]  geometry.md, times.png, error_against_time.png, walls.png
  tables.py counts COUNTS.json README.md             of count_bench.py
  tables.py convergence|stability RESULT.json FOLDER of `quoin validate --convergence --json`, `quoin stability --json`
  tables.py large RESULT.json FOLDER                 of large.py: large_errors.png, large_phases.png, rest.md, peers.md, moving.md
  tables.py moving PEERS.json PROBLEMS.csv FOLDER    of moving.py: moving.png, peers.md, problems.md
"""
import collections
import csv
import json
import math
import pathlib
import statistics
import sys

# The in-run peer that a workload's times are divided by.
REFERENCES = {"W1": "FCL libccd", "W2": "FCL libccd", "W3": "FCL libccd",
              "W4": "ODE dBoxBox", "W5": "libccd EPA 1e-9", "W6": "FCL libccd",
              "B/broad": "Bullet dbvt", "B/find": "find", "B/t": "find"}
# Goals: workload -> (entry, largest ratio to the reference).
GOALS = {"W1/box": ("quoin", 0.12), "W2/8": ("quoin", 0.17), "W2/16": ("quoin", 0.17),
         "W2/32": ("quoin", 0.17), "W2/64": ("quoin", 0.17), "W2/128": ("quoin", 0.25),
         "W2/256": ("quoin", 0.25), "W3/box": ("quoin warm", 0.04), "W3/32": ("quoin warm", 0.045),
         "W3/128": ("quoin warm", 0.045), "W4/box-overlap": ("quoin", 2.0),
         "W4/box-gap": ("quoin", 2.0), "W4/prism-overlap": ("quoin", 1.9),
         "W4/prism-gap": ("quoin", 1.9),
         **{f"W4/box-tilt-{tilt}": ("quoin batch", 1.8) for tilt in ("1e-9", "1e-6", "1e-3", "1e-2")},
         "W5/box": ("quoin", 0.2), "W5/16": ("quoin", 0.2),
         "W5/64": ("quoin", 0.2), "B/broad-jitter-100000": ("quoin", 0.5),
         "B/broad-drift-100000": ("quoin", 0.5), "B/find-100000": ("find 2 threads", 1 / 1.8)}


def reference_of(workload):
    return next((peer for start, peer in REFERENCES.items() if workload.startswith(start)), None)


def load(path):
    return json.loads(pathlib.Path(path).read_text(encoding="utf-8"))


def put(path, text, name=""):
    """Replaces what stands between two marks of a page; `name`: of one table of several."""
    begin, end = f"<!-- table{name and ' ' + name}: written by bench/tables.py -->\n", "<!-- end of table -->"
    before, rest = pathlib.Path(path).read_text(encoding="utf-8").split(begin)
    pathlib.Path(path).write_text(before + begin + text.strip("\n") + "\n" + end + rest.split(end, 1)[1], encoding="utf-8")


def row(*cells):
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def head(*names):
    return [row(*names), "|" + "---|" * len(names)]


def page(*lines):
    return "\n".join(lines) + "\n"


def ratio(value):
    """Two significant digits, or all before the point."""
    return f"{value:.2g}" if value < 99.5 else f"{value:.0f}"


# --- geometry


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
    rows = ",\n    ".join(json.dumps(entry) for entry in merged["results"])
    pathlib.Path(out).write_text(f'{{\n  "context": {json.dumps(merged["context"])},\n  "results": [\n    {rows}\n  ]\n}}\n',
                                 encoding="utf-8")


def time_text(nanoseconds):
    return "–" if nanoseconds is None else f"{nanoseconds:.{1 if nanoseconds < 100 else 0}f}"


def goal_rows(result):
    """(workload, entry, ns, peer, ns, goal) for every workload with a goal."""
    for workload, entries in groups(result).items():
        name, goal = GOALS.get(workload, (None, 0))
        base = reference_time(workload, entries)
        for entry in entries:
            if entry["peer"] == name and base and entry["nanoseconds"]:
                yield workload, name, entry["nanoseconds"], reference_of(workload), base, goal
    if find_goal(result):
        whole, parts = find_goal(result)
        yield "B/find-100000", "find", whole, "pairs alone at 1e3 + placements once", parts, 1.3


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
    return [f"Machine: {context['processor']}, {context['cores']} cores; {context['compiler']}, "
            f"`{context['flags'].strip()}`, {context['build']}; {context['gigahertz']:.2f} cycles a ns.", "",
            "Goals (ratio of medians to the in-run peer):", "",
            *head("workload", "entry", "ns", "peer", "ns", "ratio", "goal", ""),
            *(row(workload, entry, time_text(time), peer, time_text(base), f"{time / base:.3f}", f"{goal:.3g}",
                  "reached" if time <= goal * base else "missed")
              for workload, entry, time, peer, base, goal in goal_rows(result))]


def tables(result):
    lines = goal_table(result)
    for workload, entries in groups(result).items():
        base = reference_time(workload, entries)
        error = "area error" if workload.startswith("W4") else "gap error"
        lines += ["", f"**{workload}**", "", *head("peer", "ns", "ratio", "wrong", f"{error} median", "max", "")]
        for e in (e for e in entries if not e["setting"]):
            judged = ([f"{e['wrong']} of {e['pairs']}", f"{e['error_median']:.1e}", f"{e['error_max']:.1e}"]
                      if workload[0] == "W" else 3 * "–")
            ratio = f"{e['nanoseconds'] / base:.3f}" if base and e["nanoseconds"] else "–"
            lines.append(row(e["peer"], time_text(e["nanoseconds"]), ratio, *judged, e["note"]))
    return page(*lines)


def times_of(result):
    """(workload, peer) -> ns, without settings and without rows of another workload."""
    return {(e["workload"], e["peer"]): e["nanoseconds"] for e in result["results"]
            if not e["setting"] and not e["note"].startswith("on ")}


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
                 "2 workers in turns, times as fast", "Bullet's collision step", "find by it")
    for workload, text in WALLS.items():
        find, alone, two, turns, bullet = (times.get((workload, peer)) for peer in
                                           ("find", "pairs alone", "find 2 threads", "2 workers in turns",
                                            "Bullet's collision step"))
        if find:
            lines.append(row(text, time_text(find), time_text(alone), ratio_text(find, alone), time_text(two),
                             ratio_text(find, two), ratio_text(find, turns), time_text(bullet),
                             ratio_text(find, bullet)))
    return lines


def touching_table(result):
    times = times_of(result)
    texts = {"B/apart-1000": "three leaves askew, joints of 20 times the reach: boxes meet, bricks do not",
             "B/apart-100000": "the same, 1e5 bricks",
             "B/touching-0": "three leaves, 1000 bricks, touching exactly at faces and edges (7147 pairs)"}
    return head("wall", "find", "pairs alone") + [
        row(texts.get(workload, f"the same with noise of {workload.split('-', 1)[1]} m and rad"),
            time_text(times[workload, "find"]), time_text(times[workload, "pairs alone"]))
        for workload in groups(result) if workload.startswith(("B/apart", "B/touching"))]


# Manifolds: workload -> (what, goal of the batch by ODE's time).
MANIFOLDS = {"box-overlap": ("boxes, overlap", 2.0), "box-gap": ("boxes, gap", 2.0),
             "box-tilt-1e-9": ("boxes leaning by 1e-9", 1.8), "box-tilt-1e-6": ("1e-6", 1.8),
             "box-tilt-1e-3": ("1e-3", 1.8), "box-tilt-1e-2": ("1e-2", 1.8),
             "prism-overlap": ("prisms of 5–10 sides, overlap", 1.9), "prism-gap": ("prisms, gap", 1.9), "prism-tilt-1e-3": ("prisms leaning by 1e-3", "1200 ns")}


def manifold_table(result):
    times = times_of(result)
    lines = head("", "alone", "batch", "ODE dBoxBox", "batch / ODE", "goal")
    for name, (text, goal) in MANIFOLDS.items():
        workload = "W4/" + name
        base = times.get((workload, "ODE dBoxBox")) or times.get(("W4/box-overlap", "ODE dBoxBox"))
        batch = times.get((workload, "quoin batch"))
        if batch:
            lines.append(row(text, time_text(times[workload, "quoin warm"]), time_text(batch), time_text(base),
                             ratio_text(batch, base), goal))
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
    lines = head("", "quoin, both moved", "FCL libccd", "ratio", "Bullet GJK", "ratio")
    for workload in [w for w in groups(result) if w.startswith(("W1/", "W2/"))]:
        moved, fcl, bullet = (times.get((workload, peer)) for peer in
                              ("quoin, both moved", "FCL libccd", "Bullet GJK"))
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
            lines.append(row(workload, f"{time / 1e3:.0f}" if time else "–", f"{published['wrong']} of {published['pairs']}",
                             time_text(ours["nanoseconds"]), f"{time / ours['nanoseconds']:.0f}" if time else "–"))
    return lines


def size_table(result):
    times = times_of(result)
    notes = {e["workload"]: e["note"] for e in result["results"]}
    first = times.get(("B/memory-10000", "find"))
    return head("bricks", "find alone, ns a pair", "by that of 10000", "bytes a brick") + [
        row(workload.split("-")[1], time_text(times[workload, "find"]), ratio_text(times[workload, "find"], first),
            notes[workload].split(", ")[1].split()[0])
        for workload in groups(result) if workload.startswith("B/memory-")]


def count_table(counts):
    """Of count_bench.py: two rows a workload, quoin's entry and its peer."""
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


# --- walls of 1e2 to 1e5 bricks, and large scenes that move

PHASES = {"detect": "contact search", "assemble": "assembly", "solve": "solutions", "update": "update"}


def settled(runs):
    """Of each wall the run on most threads."""
    best = {}
    for run in runs:
        if run[0]["threads"] >= best.get(run[0]["bricks"], run)[0]["threads"]:
            best[run[0]["bricks"]] = run
    return [best[bricks] for bricks in sorted(best)]


def phases(row):
    """CPU seconds by phase: the CPU time in the shares that the phases have of the time on the clock."""
    clock = sum(row[f"{phase}_s"] for phase in PHASES)
    return {phase: row["cpu_s"] * row[f"{phase}_s"] / clock for phase in PHASES}


def number(value):
    return f"{value:.3g}"


def rest_table(result):
    lines = head("bricks", "threads", "CPU s", "s on the clock", "solutions' share", "solves", "peak MB", "drift m", "unbalance")
    for run in result["rest"]:
        r = run[0]
        clock = sum(r[f"{phase}_s"] for phase in PHASES)
        lines.append(row(r["bricks"], r["threads"], number(r["cpu_s"]), number(clock), f"{r['solve_s'] / clock:.2f}",
                         r["solves"], f"{r['peak_mb']:.0f}", f"{r['drift']:.1e}", f"{r['unbalance']:.1e}"))
    words = growth([run[0] for run in settled(result["rest"])][1:], "cpu_s", "bricks", 0, "")
    return page(*lines, "", f"CPU time grows with the power of the bricks: {words}.")


def growth(rows, cost, size, first, since):
    """The powers from row to row, and in all from row `first` on."""
    def power(a, b):
        return f"{math.log(b[cost] / a[cost]) / math.log(b[size] / a[size]):.2f}"

    words = [f"{power(a, b)} from {a[size]} to {b[size]}" for a, b in zip(rows, rows[1:])]
    if len(rows) > 2:
        words.append(f"{power(rows[first], rows[-1])} in all{since} (goal 1.15)")
    return ", ".join(words)


def peers_table(result):
    ends = [run[0] for run in settled(result["rest"])] + [run[-1] for run in result["peers"] if run]
    return page(*head("bricks", "code", "steps", "CPU s", "drift m", "unbalance"), *(
        row(r["bricks"], r["code"], r["step"], number(r["cpu_s"]), f"{r['drift']:.1e}", f"{r['unbalance']:.1e}")
        for r in sorted(ends, key=lambda r: r["bricks"])))


def moving_large_table(result):
    """quoin beside Bullet; then how CPU time grows with the shaken walls."""
    lines = head("scene", "steps", "code", "CPU s a step", "factorizations a step", "largest overlap m", "energy growth",
                 "CPU by Bullet's")
    runs = result["shaken"] + result["moving"]
    bullet = {run["scene"]: run["cpu_ms_per_step"] for run in runs if run["code"] != "quoin"}
    for run in runs:
        ours, steps = run["code"] == "quoin", round(run["time"] / run["time_step"])
        cells = [number(1e-3 * run["cpu_ms_per_step"]), number(run["factorizations_per_step"]) if ours else "",
                 f"{run['overlap']:.1e}", f"{run['energy_growth']:.0e}",
                 ratio(run["cpu_ms_per_step"] / bullet[run["scene"]]) if ours and run["scene"] in bullet else ""]
        if steps == 0:  # its limit was over in the first one
            cells = [f"> {cells[0]}", "", "", "", f"> {cells[4]}" if cells[4] else ""]
        lines.append(row(run["scene"] if ours else "", f"{steps}{', gave up' if run['gave_up'] else ''}", run["code"], *cells))
    walls = [run for run in result["shaken"] if run["code"] == "quoin"]
    words = growth(walls, "cpu_ms_per_step", "blocks", 1, f" from {walls[min(1, len(walls) - 1)]['blocks']} on")
    return page(*lines, "", f"Shaken walls: quoin's CPU time a step grows with the power of the bricks: {words}.")


# --- many blocks that move at once

RESIDUALS = (1e-3, 1e-6)  # that the performance profiles ask for
FACTORS = (1, 2, 4, 16)


def costs(rows, key, residual):
    """{iteration: cost of each problem}: of the cheapest tolerance whose forces are as good; inf where none is."""
    table = {}
    for row in rows:
        of = table.setdefault(row["iteration"], {})
        problem = row["scene"], row["problem"]
        good = float(row["force_error"]) <= residual
        # No factorization at all counts as one: a factor of nothing says nothing.
        cost = max(float(row[key]), 1.0 if key == "factorizations" else 1e-6) if good else math.inf
        of[problem] = min(of.get(problem, math.inf), cost)
    return {iteration: [of[problem] for problem in sorted(of)] for iteration, of in table.items()}


def shares(cost, factor):
    """Share of the problems that each iteration solves within a factor of the best."""
    best = [min(costs) for costs in zip(*cost.values())]
    return {iteration: statistics.fmean(c < math.inf and c <= factor * b for c, b in zip(of, best)) for iteration, of in cost.items()}


def cell(row):
    if row["gave_up"]:
        return f"{row['code']}: gave up at {row['time']:.3g} s"
    words = f"{row['code']}: {row['cpu_ms_per_step']:.3g}; {row['overlap']:.1e}; {row['energy_growth']:.0e}"
    if "momentum_error" in row:
        words += f"; {row['momentum_error']:.0e}"
    return words + ("" if row["whole"] else f" (stopped at {row['time']:.2g} s)")


def moving_peers_table(rows):
    lines = head("scene", "CPU ms a step; largest overlap m; energy growth; momentum error in 5 ms", "CPU by Bullet's")
    for scene in dict.fromkeys(run["scene"] for run in rows):
        of = [run for run in rows if run["scene"] == scene]
        cost = {run["code"]: run["cpu_ms_per_step"] for run in of}
        by_bullet = ratio(cost["quoin"] / cost["Bullet SI 50"]) if {"quoin", "Bullet SI 50"} <= cost.keys() else "-"
        lines.append(row(scene, "<br>".join(map(cell, of)), by_bullet))
    return page(*lines)


def problems_table(rows):
    """To the tightest tolerance; then the profiles."""
    tightest = min({row["tolerance"] for row in rows}, key=float)
    lines = head("scene", "problems", f"iteration, tolerance {float(tightest):g}", "factorizations: median, largest",
                 "not ended", "CPU ms, median", "residual: median, largest", "largest gap error m")
    chosen = [one for one in rows if one["tolerance"] == tightest]
    for scene, iteration in dict.fromkeys((one["scene"], one["iteration"]) for one in chosen):
        of = [one for one in chosen if (one["scene"], one["iteration"]) == (scene, iteration)]
        solves, ended, cpu, residual, gap = ([float(one[key]) for one in of] for key in (
            "factorizations", "converged", "cpu_ms", "force_error", "gap_error_m"))
        lines.append(row(scene, len(of), iteration, f"{statistics.median(solves):.0f}, {max(solves):.0f}",
                         f"{len(of) - sum(ended):.0f}", f"{statistics.median(cpu):.2g}",
                         f"{statistics.median(residual):.0e}, {max(residual):.0e}", f"{max(gap):.0e}"))
    lines += ["", *head("residual", "share solved, by CPU time within", *(f"{f:g} x" for f in FACTORS), "at all")]
    for residual in RESIDUALS:
        cost = costs(rows, "cpu_ms", residual)
        columns = [shares(cost, factor) for factor in (*FACTORS, math.inf)]
        lines += [row(f"{residual:g}", iteration, *(f"{column[iteration]:.2f}" for column in columns)) for iteration in cost]
    return page(*lines)


# --- orders of convergence, stability


def convergence_table(series):
    lines = head("case", "quantity", "refined", "from … to", "error from … to", "order", "expected", "floor", "reached at", "ok")
    for one in series:
        unit = "N/m" if one["refined"] == "penalty" else "s"
        order = f"{one['order']:.2f}" if one["order"] is not None else "at its floor"
        stops = f"{one['stops_at']:.3g}" if one["stops_at"] is not None else "not reached"
        lines.append(row(
            one["case"], one["quantity"], one["refined"].replace("_", " "),
            f"{one['values'][0]:.3g} … {one['values'][-1]:.3g} {unit}", f"{one['errors'][0]:.1e} … {one['errors'][-1]:.1e}",
            order, f"{one['expected_order']:g}", f"{one['floor']:.0e}", stops, "yes" if one["ok"] else "NO"))
    return page(*lines)


def stability_rows(cells):
    """{parameter: {row name: [(value, cell)]}} in the order of the file."""
    table = {}
    for cell in cells:
        parameter, name = cell["cell"].split(" / ", 1)
        value = cell["parameters"][parameter]
        table.setdefault(parameter, {}).setdefault(name, []).append((value, cell))
    return table


def mark(cell):
    if cell["verdict"] not in ("right", "flagged"):
        return "W"
    if cell["verdict"] == "flagged":
        return "f" if cell["error"] is not None and cell["error"] <= cell["allowed"] else "F"
    return ""


def stability_table(cells):
    table = stability_rows(cells)
    count = {v: sum(c["verdict"] == v for c in cells) for v in ("right", "flagged")}
    count["failed"] = len(cells) - count["right"] - count["flagged"]
    right_flagged = sum(mark(c) == "f" for c in cells)
    lines = [f"{len(cells)} cells: {count['right']} right, {count['flagged']} flagged "
             f"as expected ({right_flagged} of them right all the same), {count['failed']} wrong, flagged "
             "otherwise or not converged; "
             f"{sum(c['seconds'] for c in cells):.0f} s.", "",
             *head("varied", "scene", "from … to", "worst error (right)", "allowed", "most solves a step (right)", "flagged at",
                   "failed at")]
    for parameter, rows in table.items():
        for name, of in rows.items():
            right = [c for _, c in of if c["verdict"] == "right"]
            worst = f"{max(c['error'] for c in right):.1e}" if right else "-"
            solves = f"{max(c['solves_per_step'] for c in right):.2g}" if right else "-"
            flagged = ", ".join(f"{x:g}" for x, c in of if c["verdict"] == "flagged")
            failed = ", ".join(f"{x:g}" for x, c in of if c["verdict"] not in ("right", "flagged"))
            lines.append(row(parameter, name, f"{of[0][0]:g} … {of[-1][0]:g}", worst, f"{of[0][1]['allowed']:g}", solves,
                             flagged, failed))
    return page(*lines)


def main():
    kind, *words = sys.argv[1:] or ["--help"]
    if kind == "--merge" and len(words) > 1:
        merge(words[0], words[1:])
        return
    if kind not in ("geometry", "counts", "convergence", "stability", "large", "moving") or len(words) < 2:
        print(__doc__)
        sys.exit(kind not in ("-h", "--help") and 2)
    result, folder = load(words[0]), pathlib.Path(words[-1] if kind in ("large", "moving") else words[1])
    if kind == "counts":
        put(folder, "\n".join(count_table(result)), "counts")
        return
    import plots
    texts = {}
    if kind == "geometry":
        texts = {"geometry": tables(result)}
        plots.geometry(result, folder)
        for name, table in README_TABLES.items() if words[2:] else ():
            put(words[2], "\n".join(table(result)), name)
    elif kind == "large":
        texts = {"rest": rest_table(result), "peers": peers_table(result), "moving": moving_large_table(result)}
        plots.large(result, folder)
    elif kind == "moving":
        with open(words[1], encoding="utf-8") as file:
            problems = list(csv.DictReader(file))
        texts = {"peers": moving_peers_table(result["compared"]), "problems": problems_table(problems)}
        plots.moving(result, problems, folder / "moving.png")
    else:
        table, draw = {"convergence": (convergence_table, plots.convergence), "stability": (stability_table, plots.stability)}[kind]
        texts = {kind: table(result)}
        draw(result, folder / f"{kind}.png")
    for name, text in texts.items():
        (folder / f"{name}.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
