#!/usr/bin/env python3
"""What the count of instructions says of calls that it can do nothing with: one line, exit code 2 or 1.

  test_count_errors.py PROJECT
"""
import os
import subprocess
import sys
import tempfile

project = sys.argv[1]
failures = []


def check(command, code, text, **settings):
    run = subprocess.run(command, capture_output=True, text=True, **settings)
    if run.returncode != code or text not in run.stderr or "Traceback" in run.stderr:
        failures.append(f"{command}: {run.returncode}, {run.stderr}")


with tempfile.TemporaryDirectory() as empty:
    count = [sys.executable, os.path.join(project, "bench/count_bench.py"), empty, "--out", os.path.join(empty, "counts.json")]
    check(count + ["--filter", "NOSUCH"], 2, "no workload with a goal fits --filter NOSUCH")
    check(count + ["--filter", "("], 2, "--filter (")
    check(count, 1, "valgrind is not installed", env={"PATH": empty})
    with open(os.path.join(empty, "valgrind"), "w", encoding="utf-8") as file:
        os.chmod(file.name, 0o755)
    check(count, 1, "bench_nearest_features has not been built", env={"PATH": empty})
for options in (["--quick", "--counts"], ["--counts", "--filter", "W1"]):
    check(["sh", os.path.join(project, "bench/bench-geometry"), *options], 2, "--counts takes no other option")

print("\n".join(failures) or "all passed")
sys.exit(len(failures) > 0)
