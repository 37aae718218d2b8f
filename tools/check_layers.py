#!/usr/bin/env python3
"""Holds the include rules of the house: who may include what, and in which order within a room.

Prints one line for each breach and exits with 1 when there is one.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent

# Each rule: files, pattern of what they must not include, reason.
RULES = [
    ("geometry/include/**/*", r"^(fcl|ccd|octomap)/", "public geometry headers know Eigen and the standard library alone"),
    ("geometry/**/*", r"^quoin/solver|solver/", "geometry does not know the solver"),
    ("geometry/**/*", r"^(catch2|CLI|nlohmann|fmt)/", "packages of tools and tests stay there"),
    ("geometry/src/*", r"^(fcl|ccd)/", "FCL has one door: broad_phase.cpp"),
    ("solver/**/*", r"^(fcl|ccd)/", "the solver does no search of its own"),
    ("solver/**/*", r"^(catch2|CLI|nlohmann|fmt)/", "packages of tools and tests stay there"),
    ("solver/**/*", r"geometry/src/", "private headers of geometry"),
    ("tools/**/*", r"(geometry|solver)/src/", "tools use public headers"),
    ("tools/**/*", r"^catch2/", "tools do not test"),
    ("tools/**/*", r"^(tests|support|bench)/", "tests and bench use tools, not the other way"),
    ("bench/**/*", r"^(tests|support)/", "bench and tests share tools/referee/pairs"),
    ("bench/**/*", r"(geometry|solver)/src/", "bench uses public headers"),
    ("bench/**/*", r"^catch2/", "bench does not test"),
    ("tests/**/*", r"^fcl/", "tests ask the referee's plug-ins, not FCL"),
]
DOORS = {"geometry/src/finder/broad_phase.cpp": r"^fcl/"}

# Within a room a file includes private headers only from its own folder of src and those before it,
# and, of the public headers of geometry, only from its own or those before it.
FOLDERS = {
    "geometry": ["simd", "numeric", "shape", "polygon", "certify", "search", "kernels", "contact", "finder",
                 "bindings"],
    "solver": ["base", "block", "contact", "scene", "linear", "iteration", "statics", "step",
               "source_method", "simulation"],
}
CHAINS = {
    "geometry": [["types"], ["shape"], ["body"], ["nearest_features"], ["contact_type"],
                 ["contact_point"], ["contact_finder"]],
}
SOURCES = (".hpp", ".cpp", ".h", ".c")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^">]+)[">]', re.M)


def includes(path):
    return [(kind, name) for kind, name in INCLUDE.findall(path.read_text(encoding="utf-8"))]


def forbidden(path, name):
    relative = path.relative_to(ROOT).as_posix()
    if relative in DOORS and re.search(DOORS[relative], name):
        return None
    for files, pattern, reason in RULES:
        if pathlib.PurePath(relative).is_relative_to(files.split("/*")[0]) and re.search(pattern, name):
            return reason
    return None


def level(room, stem):
    return next((i for i, stems in enumerate(CHAINS[room]) if stem in stems), None)


def chain_breaches(room, path, names):
    mine = level(room, path.stem)
    for kind, name in names:
        other = level(room, pathlib.PurePath(name).stem)
        private_or_geometry = kind == '"' or (room == "geometry" and name.startswith("quoin/geometry/"))
        if private_or_geometry and mine is not None and other is not None and other > mine:
            yield f"{path.relative_to(ROOT)}: includes {name}, which stands after it in the chain"


def folder_breaches(room, path, names):
    """A folder of src includes from itself and from those before it."""
    folders = FOLDERS[room]
    mine = path.relative_to(ROOT / room / "src").parts[0]
    if mine not in folders:
        yield f"{path.relative_to(ROOT)}: lies in no folder of the chain"
        return
    for kind, name in names:
        other = name.split("/")[0]
        if kind == '"' and other in folders and folders.index(other) > folders.index(mine):
            yield f"{path.relative_to(ROOT)}: includes {name}, whose folder stands after {mine}"


def cycles(graph):
    done, open_ = set(), []

    def walk(node):
        if node in open_:
            yield open_[open_.index(node):] + [node]
            return
        if node in done:
            return
        open_.append(node)
        for other in sorted(graph.get(node, ())):
            yield from walk(other)
        open_.pop()
        done.add(node)

    for node in sorted(graph):
        yield from walk(node)


def header_graph(room):
    graph = {}
    for path in (ROOT / room).rglob("*.hpp"):
        for kind, name in includes(path):
            folders = [path.parent, ROOT / room / "src"] if kind == '"' else [ROOT / room / "include"]
            for target in (folder / name for folder in folders):
                if target.exists():
                    graph.setdefault(path.relative_to(ROOT).as_posix(), set()).add(
                        target.resolve().relative_to(ROOT).as_posix())
                    break
    return graph


def breaches():
    for room in ("geometry", "solver", "tools", "tests", "bench"):
        for path in sorted((ROOT / room).rglob("*")):
            if path.suffix not in SOURCES or not path.is_file():
                continue
            names = includes(path)
            for _, name in names:
                reason = forbidden(path, name)
                if reason:
                    yield f"{path.relative_to(ROOT)}: includes {name}: {reason}"
            if room in CHAINS:
                yield from chain_breaches(room, path, names)
            if room in FOLDERS and path.is_relative_to(ROOT / room / "src"):
                yield from folder_breaches(room, path, names)
    for room in FOLDERS:
        for cycle in cycles(header_graph(room)):
            yield "cycle: " + " -> ".join(cycle)


def main():
    found = list(breaches())
    for line in found:
        print(line)
    print(f"{len(found)} breaches of the include rules")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
