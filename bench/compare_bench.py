#!/usr/bin/env python3
"""Compares two result files of the benchmarks by the ratios of their medians to the in-run peer.

  compare_bench.py BEFORE.json AFTER.json [--threshold 0.10]

Absolute times differ between machines and days; the ratio to a peer timed in the same run travels.
Prints every workload of quoin's entries, names what got slower or answers more pairs wrongly, and
exits with 1 when there is any beyond the threshold.
"""
import argparse
import sys

from tables import groups, load, reference_of, reference_time


QUOIN = ("quoin", "find")  # how its entries begin


def ratios(result):
    """(workload, peer) -> (ratio to the in-run peer, share of wrong answers)."""
    found = {}
    for workload, entries in groups(result).items():
        base = reference_time(workload, entries)
        for entry in entries:
            named = entry["peer"].startswith(QUOIN) and entry["peer"] != reference_of(workload)
            if named and not entry["setting"] and base and entry["nanoseconds"]:
                wrong = entry["wrong"] / entry["pairs"] if entry["pairs"] else 0.0
                found[workload, entry["peer"]] = (entry["nanoseconds"] / base, wrong)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("before")
    parser.add_argument("after")
    parser.add_argument("--threshold", type=float, default=0.10, help="share by which it may get slower")
    arguments = parser.parse_args()
    try:
        before, after = (ratios(load(path)) for path in (arguments.before, arguments.after))
    except (OSError, ValueError, KeyError, TypeError) as error:  # exits with 2
        parser.error(f"no results to compare: {type(error).__name__}: {error}")
    slower = []
    for key in before:
        if key not in after:
            slower.append(f"{key[0]} {key[1]}: not measured any more")
            continue
        (old, old_wrong), (new, new_wrong) = before[key], after[key]
        change = new / old - 1
        print(f"{key[0]:26} {key[1]:18} ratio {old:9.4f} -> {new:9.4f}  {100 * change:+7.1f} %")
        if change > arguments.threshold:
            slower.append(f"{key[0]} {key[1]}: slower by {100 * change:.1f} %")
        if new_wrong > old_wrong:
            slower.append(f"{key[0]} {key[1]}: wrong answers {old_wrong:.4f} -> {new_wrong:.4f} of the pairs")
    if not before:
        slower.append("nothing to compare in " + arguments.before)
    for line in slower:
        print("WORSE: " + line)
    return 1 if slower else 0


if __name__ == "__main__":
    sys.exit(main())
