"""Inputs that can't be worked with: each ends within 2 s and 1 GiB, with the right exit code and one line
that names file, place, value and limit; no file is left behind.

Each line of bad_inputs/cases.jsonl is a case:
  set, remove   values by pointer and keys that go, in scene.json (or in `base`), which becomes bad.json; behind a list's last entry: one more
  files         by name; %SCENE%, %CUBE%, %CORNERS% stand for scene.json, cube.obj and its vertices
  arguments     of quoin; "run bad.json" by default
  exit          codes that are right, 2 by default
  says          words of the line, behind which a second one may say how to get help
  lines         1 where none may
  kilobytes     of memory, in place of 1 GiB; nothing may stand on standard output then
A text may be {"repeat": [[text, times], ...]}, a file {encoding: text}.

usage: test_bad_inputs.py QUOIN SOURCE_DIR [WORD]   (only cases whose name holds WORD, shown)
"""
import json
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

QUOIN = str(pathlib.Path(sys.argv[1]).resolve())
DATA = pathlib.Path(sys.argv[2]) / "tests" / "tools" / "bad_inputs"
ONLY = sys.argv[3] if len(sys.argv) > 3 else ""
SECONDS, BYTES = 2.0, 1 << 30
CUBE = (DATA / "cube.obj").read_text()
TEXTS = {"%SCENE%": (DATA / "scene.json").read_text(), "%CUBE%": CUBE, "%CORNERS%": CUBE[:CUBE.index("f ")]}


def spelled_out(value):
    """A value of a case with its repeated texts at full length."""
    if isinstance(value, list):
        return [spelled_out(v) for v in value]
    if not isinstance(value, dict):
        return value
    if "repeat" in value:
        return "".join(text * times for text, times in value["repeat"])
    return {key: spelled_out(v) for key, v in value.items()}


def bytes_of(content):
    encoding, text = ("utf-8", content) if isinstance(content, str) else next(iter(content.items()))
    for name, meant in TEXTS.items():
        text = text.replace(name, meant)
    return text.encode(encoding)


def place_of(scene, pointer):
    *way, last = (int(key) if key.isdigit() else key for key in pointer.split("/")[1:])
    for key in way:
        scene = scene[key]
    return scene, last


def bad_scene(case):
    scene = json.loads((DATA / case.get("base", "scene.json")).read_text())
    for pointer, value in case.get("set", {}).items():
        at, key = place_of(scene, pointer)
        if isinstance(at, list) and key == len(at):
            at.append(value)
        else:
            at[key] = value
    for pointer in case.get("remove", []):
        at, key = place_of(scene, pointer)
        del at[key]
    return json.dumps(scene)


def write_files(case, folder):
    files = case.get("files", {})
    if case.keys() & {"base", "set", "remove"}:
        files = {**files, "bad.json": bad_scene(case)}
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(bytes_of(content))


def fault(case, folder):
    """What is wrong with how the case ended; empty when all is well."""
    write_files(case, folder)
    arguments, stdin = case.get("arguments", ["run", "bad.json"]), case.get("stdin", "")
    codes, memory = case.get("exit", 2), case.get("kilobytes", BYTES >> 10) << 10

    def limits():
        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    before = sorted(folder.rglob("*"))
    start = time.monotonic()
    try:
        done = subprocess.run([QUOIN, *[a.encode("utf-8", "surrogateescape") for a in arguments]],
                              cwd=folder, input=stdin.encode(), capture_output=True, timeout=60,
                              preexec_fn=limits)
    except subprocess.TimeoutExpired:
        return "did not end"
    seconds = time.monotonic() - start
    said = (done.stdout if arguments[:1] == ["contact"] and stdin else done.stderr).decode()
    if ONLY:
        print(f"{case['name']}: exit {done.returncode}, {seconds:.2f} s: {said.strip()}")
    faults = [f"exit code {done.returncode}, not {codes}"
              if done.returncode not in (codes if isinstance(codes, list) else [codes]) else "",
              f"{seconds:.1f} s" if seconds > SECONDS else "",
              "says more than 700 bytes" if len(said) > 700 else "",
              "not one line" if said.count("\n") not in range(1, case.get("lines", 2) + 1) else "",
              "standard output" if "kilobytes" in case and done.stdout else "",
              "control characters" if any(c < " " and c != "\n" for c in said) else "",
              "the word of another program" if any(w in said for w in (
                  "json.exception", "std::", "stoi", "stol", "what():", "Traceback")) else "",
              "left something behind" if sorted(folder.rglob("*")) != before else ""]
    faults += [f"does not say {word!r}" for word in case["says"] if word not in said]
    return "; ".join(f for f in faults if f) + (f"\n       said: {said[:300].strip()}" if any(faults) else "")


cases = [spelled_out(json.loads(line)) for line in (DATA / "cases.jsonl").read_text().splitlines()]
failures = 0
for case in cases:
    if ONLY in case["name"]:
        with tempfile.TemporaryDirectory() as holder:
            wrong = fault(case, pathlib.Path(holder))
        failures += bool(wrong)
        if wrong:
            print(f"WRONG  {case['name']}: {wrong}")
print(f"{len(cases)} bad inputs, {failures} not refused as they should be")
sys.exit(1 if failures or len(cases) < 150 else 0)
