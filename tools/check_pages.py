#!/usr/bin/env python3
"""Counts the words of the pages (rows of tables not counted) against their limits, and looks for the files that the tables of
README.md name; one without a folder lies beside the one before it.

Prints one line for each fault, and exits with 1 when there is one.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
LIMITS = {"README.md": 800, "geometry/README.md": 2500, "solver/README.md": 4500, "bench": 6000,
          "CHANGELOG.md": 1500, "CONTRIBUTING.md": 500, ".": 25000}


def words(place):
    pages = [page for page in [ROOT / place, *ROOT.glob(f"{place}/**/*.md")] if page.suffix == ".md" and page.is_file()
             and not re.match(r"(build|out|\.)", page.relative_to(ROOT).parts[0])]
    return sum(len(line.split()) for page in pages for line in page.read_text(encoding="utf-8").splitlines()
               if not line.startswith("|"))


def missing():
    for row in (ROOT / "README.md").read_text(encoding="utf-8").splitlines():
        folder = ROOT
        for name in re.findall(r"`([\w./]+)`", row) if row.startswith("|") else ():
            folder = (ROOT / name).parent if "/" in name else folder
            if re.search(r"/|\.\w+$", name) and not (ROOT / name if "/" in name else folder / name).exists():
                yield f"README.md: there is no {name} in {folder.relative_to(ROOT)}"


faults = [f"{place}: {words(place)} words, at most {limit}" for place, limit in LIMITS.items() if words(place) > limit]
faults += missing()
print("\n".join(faults) or f"{words('.')} words in all pages")
sys.exit(1 if faults else 0)
