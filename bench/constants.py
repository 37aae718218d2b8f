#!/usr/bin/env python3
"""How much the answers depend on each constant of the solver: the table of constants.md.

  constants.py [--build DIRECTORY] [--only TEXT ...]     two hours on two cores

A copy of the sources reads each constant from the environment. Each is taken ten times as large and a tenth (counts three times,
shares towards one and a third); where the first changes what is asked, the second is not tried. Lines are added to
DIRECTORY/constants.jsonl: a run that was broken off goes on. Rows of the page that this run has not made stay.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "bench/constants.md"
MADE = {"pile": "pile --blocks 24 --end-time 1.5", "bin": "bin --blocks 25 --end-time 0.6", "dome": "dome", "arch": "arch",
        "shaken_across": "shaken-wall --length 1.6 --height 1.5 --end-time 1.5",
        "shaken_plane": "shaken-wall --length 2.4 --height 1.5 --direction-deg 0 --peak 0.8 --end-time 1.5",
        "shaken_soft": "shaken-wall --length 1.6 --height 1.0 --young 1e9 --end-time 0.8",
        "struck": "struck-wall --length 2.4 --height 1.5 --mass 100 --end-time 0.6",
        "vault": "vault --length 0.8 --courses 9 --end-time 0.6", "jointed": "jointed-slope --rows 4 --columns 2 --end-time 0.6",
        "soft7": "wall --length 8 --height 2 --young 1e7", "soft8": "wall --length 4 --height 2 --young 1e8",
        "soft10": "wall --length 4 --height 2 --young 1e10"}
STATICS = re.compile(r"statics/|interior_point|kInside|kRedundantSoftness|kGoodInside|kSoftInside|kSmallGap|kFarGap|kSettles|kContradicts|kFarFromRest")
DECLARED = re.compile(r"^(\s*)((?:inline )?)constexpr (double|int|std::size_t) (k[A-Z][^;\[{]*);", re.M)
ITEM = re.compile(r"(k[A-Z]\w*) =\s*([^,;]+)")
# Compiled in, of the machine, of a documented limit, or without a number: none of these is varied.
LEFT_OUT = re.compile(r"/(linear|source_method)/|output|checkpoint|kPieces|kCorners|kWorth|kLarge\b|kLargeShare|step_flags.* kLargest|kMany\b.*step_control|kFlagKinds|kPlanes|kInner|kNoForce|kMost\b.*contact_newton|kComparisons|Turn$|Infinite")
VARY = """#pragma once
#include <cstdlib>
inline double quoin_vary(const char* name, double value) {
  const char* given = std::getenv(name);
  return given != nullptr ? value * std::atof(given) : value;
}
"""


def vary_sources(copy):
    """Constants of the copy, which reads them from the environment: (file, name, text of the value, kind)."""
    found = []
    for source in sorted(copy.glob("solver/src/**/*.[ch]pp")):
        place = source.relative_to(copy / "solver/src").as_posix()

        def swap(match):
            indent, inline, kind, items = match.groups()
            if "numeric_limits" in items or LEFT_OUT.search(f"/{place} {items.split(' =')[0]}"):
                return match.group(0)

            def one(item):
                name, value = item.group(1), item.group(2).strip()
                found.append((place, name, value, kind))
                return f'{name} = static_cast<{kind}>(quoin_vary("{source.stem}_{name}", static_cast<double>({value})))'
            return f"{indent}{inline or 'static '}const {kind} {ITEM.sub(one, items)};"
        source.write_text(DECLARED.sub(swap, source.read_text()))
    (copy / "vary.hpp").write_text(VARY)
    return found


def factors(value, kind):
    if kind != "double":
        return [("3 times", 3.0), ("a third", max(1.0, round(value / 3)) / value)]
    if 0.2 <= value < 1.0:
        return [("towards 1", (1 - (1 - value) / 5) / value), ("a third", 1 / 3)]
    return [("10 times", 10.0), ("a tenth", 0.1)]


def finish(command, environment, seconds):
    """What the command left, or None where it has no end in that CPU time."""
    done = subprocess.run(["prlimit", f"--cpu={seconds}", *map(str, command)], env={**os.environ, **environment}, capture_output=True, text=True)
    return done if done.returncode >= 0 else None


class Judge:
    def __init__(self, build):
        self.quoin, self.folder = str(build / "build/tools/quoin"), build / "scenes"
        self.cases = build / "cases"
        for folder in (self.folder, self.cases):
            folder.mkdir(exist_ok=True)
        for name, arguments in MADE.items():
            subprocess.run([self.quoin, "make", *arguments.split(), "--out", str(self.folder / f"{name}.json")], capture_output=True)
        sys.path.insert(0, str(ROOT / "tests/tools"))
        from test_static_stages import shear_wall
        (self.folder / "shear_wall.json").write_text(json.dumps(shear_wall(15.7e3)))
        self.scenes = sorted([*self.folder.glob("*.json"), *(ROOT / "bench/constants").glob("*.json")])
        for case in (ROOT / "tools/scenes/cases").glob("*.json"):
            if '"cases"' in case.read_text() and not case.name.startswith("mortar_wall"):
                (self.cases / case.name.replace("_", "-")).write_text(case.read_text())
        self.base = self.run({})
        wrong = self.failed_cases({}) + self.failed_tests("", {}) + self.failed_tests("statics/cone", {})
        if wrong:
            sys.exit(f"constants.py: with today's values {', '.join(wrong)} fails")

    def run_scene(self, scene, environment):
        with tempfile.TemporaryDirectory() as folder:
            done, written = finish([self.quoin, "run", scene, "--out", folder + "/out"], environment, 30), pathlib.Path(folder, "out/summary.json")
            if done is None or not written.exists():
                return {"solves": 0, "says": "no end", "bits": None}
            summary = json.loads(written.read_text())
        says = [str(done.returncode), summary["status"], *sorted(flag["flag"] for flag in summary["flags"])]
        bits = json.dumps([summary["energy"], summary["largest_overlap"], summary["factorizations"]])
        return {"solves": summary["factorizations"], "says": " ".join(says), "bits": bits}

    def run(self, environment):
        return {scene.stem: self.run_scene(scene, environment) for scene in self.scenes}

    def failed_cases(self, environment):
        done = finish([self.quoin, "validate", "--folder", self.cases, "--json"], environment, 600)
        if done is None or not done.stdout:
            return ["all cases"]
        return sorted({row["case"] for row in json.loads(done.stdout) if not row["ok"]})

    def failed_tests(self, place, environment):
        tests = ROOT / "tests/tools"
        with tempfile.TemporaryDirectory() as folder:
            other = "test_limit" if re.search("statics/(cone|equilibrium[.])", place) else "test_static_stages"
            for name, arguments in (("test_random_statics", [folder, "20"]), (other, [ROOT])):
                done = finish([sys.executable, tests / f"{name}.py", self.quoin, *arguments], environment, 600)
                if done is None or done.returncode != 0:
                    return [name]
        return []

    def judge(self, place, name, environment):
        now = self.run(environment)
        all_base = sum(scene["solves"] for scene in self.base.values())
        most = max((now[s]["solves"] / max(1, self.base[s]["solves"]), s) for s in now)
        row = {"same_bits": all(now[s]["bits"] == self.base[s]["bits"] for s in now),
               "ratio": round(sum(scene["solves"] for scene in now.values()) / all_base, 3), "worst": [round(most[0], 2), most[1]],
               "changed": sorted(s for s in now if now[s]["says"] != self.base[s]["says"]), "lost": []}
        if not row["changed"] and abs(row["ratio"] - 1) < 0.05:
            row["lost"] = self.failed_cases(environment)
            if STATICS.search(f"{place} {name}"):
                row["lost"] += self.failed_tests(place, environment)
        return row


def matters(row):
    return bool(row["changed"] or row["lost"] or abs(row["ratio"] - 1) > 0.05 or row["worst"][0] > 1.25)


def cell(row):
    if row is None:
        return "–"
    wrong = ", ".join([*row["changed"], *(name.replace("-", "_") for name in row["lost"])])
    text = "the same" if row["same_bits"] else f"{row['ratio']:.2f} ({row['worst'][0]:.2f})"
    return f"{text}; wrong: {wrong}" if wrong else text


def write_page(found, rows):
    text = PAGE.read_text()
    start = text.index("\n", text.index("<!-- table constants")) + 1
    end = text.index("<!-- end of table -->")
    stand = {line.rsplit("|", 3)[0]: line for line in text[start:end].splitlines()}
    lines = ["| constant | in | value | larger | smaller |", "|---|---|---|---|---|"]
    for place, name, value, _ in found:
        heading = f"| `{name}` | {re.sub('[.].*', '', place)} | {value} "
        own = {row["variant"]: row for row in rows if (row["file"], row["name"], row["value"]) == (place, name, value)}
        larger = next((row for variant, row in own.items() if not variant.startswith("a ")), None)
        smaller = next((row for variant, row in own.items() if variant.startswith("a ")), None)
        if own:
            lines.append(f"{heading}| {cell(larger)} | {cell(smaller)} |")
        elif heading in stand:
            lines.append(stand[heading])
    PAGE.write_text(text[:start] + "\n".join(lines) + "\n" + text[end:])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--build", default=str(ROOT / "build-constants"), metavar="DIRECTORY", help="of the copy (default: build-constants)")
    parser.add_argument("--only", nargs="+", default=[""], metavar="TEXT", help="constants with one of these in 'path name'")
    arguments = parser.parse_args()
    build = pathlib.Path(arguments.build).resolve()
    copy, results = build / "copy", build / "constants.jsonl"
    if not copy.exists():
        build.mkdir(parents=True, exist_ok=True)
        subprocess.run(["git", "clone", "-q", str(ROOT), str(copy)], check=True)
        (build / "found.json").write_text(json.dumps(vary_sources(copy)))
    subprocess.run(["cmake", "-S", str(copy), "-B", str(build / "build"), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                    f"-DCMAKE_CXX_FLAGS=-include {copy}/vary.hpp"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", str(build / "build"), "--target", "quoin"], check=True, stdout=subprocess.DEVNULL)
    judge = Judge(build)
    done = [json.loads(line) for line in results.read_text().splitlines()] if results.exists() else []
    known = {(row["file"], row["name"], row["value"], row["variant"]): row for row in done}
    found = json.loads((build / "found.json").read_text())

    def both(constant):
        place, name, value, kind = constant
        try:
            number = float(eval(value, {"__builtins__": {}}))  # of our own sources: 1.0 - 5e-7
        except NameError:
            return
        for variant, factor in factors(number, kind) if number else ():
            if factor == 1.0:
                continue
            row = known.get((place, name, value, variant))
            if row is None:
                row = judge.judge(place, name, {f"{pathlib.PurePath(place).stem}_{name}": repr(factor)})
                row = {"file": place, "name": name, "value": value, "variant": variant, **row}
                done.append(row)
                with results.open("a") as file:
                    file.write(json.dumps(row) + "\n")
                print(f"{name} {variant}: {cell(row)}", flush=True)
            if matters(row):
                return

    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        list(pool.map(both, [c for c in found if any(text in f"{c[0]} {c[1]}" for text in arguments.only)]))
    write_page(found, done)


if __name__ == "__main__":
    main()
