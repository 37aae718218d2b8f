"""Inputs that can't be worked with: each ends within 2 s and 1 GiB, with the right exit code and one line
that names file, place, value and limit; no file is left behind.

usage: test_bad_inputs.py QUOIN SOURCE_DIR [WORD]   (only cases whose name holds WORD, shown)
"""
import copy
import json
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

QUOIN = str(pathlib.Path(sys.argv[1]).resolve())
ONLY = sys.argv[3] if len(sys.argv) > 3 else ""
SECONDS, BYTES = 2.0, 1 << 30
BOX = {"type": "box", "min": [0, 0, 0], "max": [1, 1, 1]}
SCENE = {
    "parameters": {"phi": 30},
    "materials": {"rock": {"density": 2600, "young": 5e9, "poisson": 0.25}},
    "joint": {"friction_angle_deg": "=phi"},
    "blocks": [
        {"name": "base", "kind": "fixed",
         "shape": {"type": "box", "min": [-2, -2, -1], "max": [3, 3, 0]}},
        {"name": "top", "material": "rock", "shape": BOX},
    ],
    "time_step": 0.01,
    "end_time": 0.02,
    "monitors": [{"name": "top", "block": "top"}],
    "references": [{"monitor": "top", "quantity": "displacement", "component": "x", "exact": "0"}],
}
CUBE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
CUBE_FACES = "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
cases = []  # name, exit code, words in the line, files by name, arguments, standard input


def add(name, words, files, arguments, code=2, stdin=""):
    cases.append((name, code, [words] if isinstance(words, str) else words, files, arguments, stdin))


def changed(pointer, value):
    """SCENE with a value in another place; None stands for `null`, KeyError for a key that goes."""
    scene = copy.deepcopy(SCENE)
    at = scene
    keys = [int(k) if k.isdigit() else k for k in pointer.split("/")[1:]]
    for key in keys[:-1]:
        at = at[key]
    if value is KeyError:
        del at[keys[-1]]
    elif isinstance(at, list) and keys[-1] == len(at):
        at.append(value)
    else:
        at[keys[-1]] = value
    return json.dumps(scene)


def scene(pointer, value, *words):
    """A scene with one bad value: the line names the place, unless `words` do."""
    name = f"{pointer} = {str(json.dumps(value) if value is not KeyError else 'missing')[:60]}"
    add(name, ["bad.json: ", *(words or (pointer,))], {"bad.json": changed(pointer, value)},
        ["run", "bad.json"])


def text(name, content, *words, code=2):
    add(name, ["bad.json", *words], {"bad.json": content}, ["run", "bad.json"], code)


def syntax():
    good = json.dumps(SCENE)
    text("empty file", "", "line 1")
    text("blanks", "  \n \n", "line 3")
    text("half a scene", good[: len(good) // 2], "line 1")
    text("two scenes", good + good, "line 1")
    text("no JSON", "blocks: []", "line 1")
    text("a number", "7", "must be of type object")
    text("a list", "[]", "must be of type object")
    text("null", "null", "must be of type object")
    text("a word", '"scene"', "must be of type object")
    text("zeros", "\0" * 1000, "line 1")
    text("no UTF-8", b'{"title": "\xff\xfe"}', "line 1")
    text("UTF-16", good.encode("utf-16"), "line 1")
    text("a picture", b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 20, "line 1")
    text("a key twice", '{"blocks": [], "blocks": []}', '"blocks"', "twice")
    text("NaN", good.replace("0.02", "NaN"), "line 1")
    text("1e999", good.replace("0.02", "1e999"), "1e999")
    text("a comma too many", good[:-1] + ",}", "line 1")
    text("single quotes", "{'blocks': []}", "line 1")
    text("a bare control character", '{"title": "a\nb"}', "control character")
    text("a long wrong word", '{"title": ' + "x" * 100000 + "}", "line 1")
    for depth in (100, 30000, 1000000):
        text(f"{depth} lists in each other", "[" * depth, "deep", "64")
        text(f"{depth} objects in each other", '{"a":' * depth, "deep", "64")
    text("lists 30000 deep, closed", '{"blocks":' + "[" * 30000 + "]" * 30000 + "}", "deep", "64")
    text("lists 30000 deep in a formula", '{"title":' + "[" * 30000 + "]" * 30000 + "}", "deep", "64")
    add("no such file", "none.json", {}, ["run", "none.json"], 1)
    add("a folder", "can't be read", {"folder/x": ""}, ["run", "folder"], 1)
    add("an empty name", "scene", {}, ["run", ""], 2)
    add("a name with an end of line", "a\\x0ab.json: can't be read", {}, ["run", "a\nb.json"], 1)
    add("a device without end", "/dev/zero", {}, ["run", "/dev/zero"], 2)


def values():
    scene("/blocks", None, "/blocks", "null")
    scene("/blocks", KeyError, "blocks")
    scene("/blocks", [])
    scene("/blocks", [None], "/blocks/0", "null")
    scene("/blocks", [[]], "/blocks/0")
    scene("/blocks", "stones")
    scene("/blocks", 7)
    scene("/blocks/1", {}, "/blocks/1", '"shape"')
    scene("/blocks/1/shape", None)
    scene("/blocks/1/shape", "box")
    scene("/blocks/1/shape", {})
    scene("/blocks/1/shape/type", "ball")
    scene("/blocks/1/shape/type", None)
    scene("/blocks/1/shape/min", [0, 0])
    scene("/blocks/1/shape/min", [0, 0, "0"])
    scene("/blocks/1/shape/min", [0, 0, None])
    scene("/blocks/1/shape/min", [5, 0, 0], "/blocks/1/shape")
    scene("/blocks/1/shape/max", [1, 1, 0], "/blocks/1/shape")
    scene("/blocks/1/shape/max", [1, 1, 1e300], "/blocks/1")
    scene("/blocks/1/shape", {"type": "hull", "points": []}, "/blocks/1/shape")
    scene("/blocks/1/shape", {"type": "hull", "points": [[0, 0, 0]] * 8}, "/blocks/1/shape")
    scene("/blocks/1/shape", {"type": "hull", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]},
          "/blocks/1/shape")
    scene("/blocks/1/shape", {"type": "prism", "polygon": [[0, 0, 0], [1, 0, 0]], "sweep": [0, 0, 1]},
          "/blocks/1/shape")
    scene("/blocks/1/shape", {"type": "prism", "polygon": [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
                              "sweep": [1, 0, 0]}, "/blocks/1/shape")
    tetrahedron = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    for index in (4, -1, 4294967296, 4294967303, 1 << 62, 10**30, 2.5, "2", None):
        faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, index]]
        scene("/blocks/1/shape", {"type": "polyhedron", "vertices": tetrahedron, "faces": faces},
              "/blocks/1/shape")
    scene("/blocks/1/shape", {"type": "polyhedron", "vertices": tetrahedron, "faces": [[0, 1, 2]]},
          "/blocks/1/shape")
    scene("/blocks/1/kind", "soft")
    scene("/blocks/1/kind", ["rigid"])
    scene("/blocks/1/material", "wood", "/blocks/1/material", "wood")
    scene("/blocks/1/material", KeyError, "/blocks/1", "material")
    scene("/blocks/1/name", "base", "/blocks/1", "base")
    scene("/blocks/1/name", "")
    scene("/blocks/1/name", 7)
    scene("/blocks/1/name", "a\nb", "/blocks/1/name", "control character")
    scene("/blocks/1/name", "a\0b", "/blocks/1/name", "control character")
    scene("/blocks/1/name", "x" * 100000, "/blocks/1/name", "1000")
    scene("/blocks/1/colour", "red", "/blocks/1/colour", "unknown key")
    scene("/blocks/1/velocity", [1, 2])
    scene("/blocks/0/velocity", [1, 2, 3])
    scene("/blocks/1/motion", {"velocity": [1, 0, 0]}, "/blocks/1")
    scene("/blocks/1/initial_stress", [1] * 5)
    scene("/blocks/1/pose", {"rotation": {"axis": [0, 0, 0], "angle_deg": 3}}, "/blocks/1/pose")
    scene("/blocks/1/pose", {"rotation": {"quaternion": [0, 0, 0, 0]}}, "/blocks/1/pose")
    scene("/blocks/1/pose", {"rotation": {"matrix": [[2, 0, 0], [0, 1, 0], [0, 0, 1]]}},
          "/blocks/1/pose")
    scene("/blocks/1/pose", {"rotation": {}}, "/blocks/1/pose/rotation")
    scene("/blocks/1/pose", {"translation": [0, 0, -0.5]}, "overlap", "0.5")
    for key, bad in (("density", 0), ("density", -1), ("density", "x"), ("density", None),
                     ("density", KeyError), ("young", 0), ("young", -5e9), ("young", "=0"),
                     ("young", KeyError), ("poisson", 0.5), ("poisson", -1), ("poisson", 1e300)):
        words = ("young",) if (key, bad) == ("young", KeyError) else ("/materials/rock", key)
        scene(f"/materials/rock/{key}", bad, *words)
    scene("/materials/rock/colour", 1, "unknown key")
    scene("/materials/rock/densty", 1, 'did you mean "density"')
    scene("/materials", [])
    scene("/joint", KeyError, '"joint"')
    scene("/joint", None)
    for key, bad in (("friction_angle_deg", 90), ("friction_angle_deg", -1),
                     ("friction_angle_deg", None), ("cohesion", -1), ("tension", -1),
                     ("restitution", 2), ("friction", 0.5)):
        scene(f"/joint/{key}", bad)
    scene("/joints", [{"between": ["rock", "wood"], "friction_angle_deg": 3}], "/joints/0", "wood")
    for key, value, words in (
            ("dilation_angle_deg", 40, "/dilation_angle_deg: 40 must not exceed friction_angle_deg, 30"),
            ("normal_stiffness", 1e9, 'missing key "shear_stiffness"'),
            ("shear_stiffness", 1e9, 'missing key "normal_stiffness"')):
        scene("/joint", {"friction_angle_deg": 30, key: value}, "/joint", words)
        scene("/joints", [{"between": ["rock", "rock"], "friction_angle_deg": 30, key: value}], "/joints/0", words)
    scene("/joint", {"friction_angle_deg": 30, "dilation_angle_deg": 20, "residual_friction_angle_deg": 10},
          "/joint/dilation_angle_deg: 20 must not exceed residual_friction_angle_deg, 10")
    text("options that don't go together", json.dumps({**SCENE, "method": "paper", "scheme": "energy_momentum"}),
         "bad.json: /: method paper knows the scheme constant_acceleration alone")
    scene("/gravity", [0, 0])
    scene("/gravity", {"table": []})
    scene("/gravity", {"table": [[1, 0, 0, 1], [0, 0, 0, 2]]}, "/gravity/table", "ascend")
    scene("/gravity", {"table": [[0, 0, 0, 1]] * 3}, "/gravity/table", "ascend")  # twice is a jump
    scene("/gravity", {"formula": ["0", "0"]})
    scene("/loads", [{"type": "wind"}], "/loads/0")
    scene("/loads", [{"type": "body", "block": "base", "force": [0, 0, 1]}], "/loads/0/block")
    scene("/loads", [{"type": "body", "block": "none", "force": [0, 0, 1]}], "/loads/0/block", "none")
    scene("/loads", [{"type": "face", "block": "top", "towards": [0, 0, 0], "traction": [0, 0, 1]}],
          "/loads/0/towards")
    scene("/loads", [{"type": "face", "block": "top", "towards": [1, 0, 1], "traction": [0, 0, 1]}],
          "/loads/0/towards", "two faces")
    for key in ("time_step", "end_time", "penalty", "tolerance", "reach", "output_interval"):
        for bad in (0, -1, "1", None, "=0/0", "=1/0"):
            scene(f"/{key}", bad)
    scene("/tolerance", 0.5, "tolerance")
    scene("/smallest_time_step", 1, "smallest time step")
    for key in ("max_iterations", "history_every"):
        for bad in (0, -1, 1.5, 4294967303, 10**30, "3"):
            scene(f"/{key}", bad)
    scene("/method", "magic")
    scene("/stages", [{"analysis": "static"}], "stages", "end_time")
    scene("/endtime", 1, 'did you mean "end_time"')
    text("no time", changed("/end_time", KeyError), "end_time")
    text("stages, empty", changed("/end_time", KeyError)[:-1] + ', "stages": []}', "/stages")
    for stage, word in (({"analysis": "rest"}, "analysis"), ({}, "analysis"),
                        ({"analysis": "dynamic"}, "end_time"), ({"analysis": "static", "steps": 0}, "steps"),
                        ({"analysis": "static", "steps": 4294967303}, "steps"),
                        ({"analysis": "static", "steps": 5, "until": "rest"}, "until"),
                        ({"analysis": "static", "max_steps": -1}, "max_steps"), (None, "null")):
        text(f"stage {stage}", changed("/end_time", KeyError)[:-1] + f', "stages": [{json.dumps(stage)}]}}',
             "/stages/0", word)
    scene("/monitors", [{"name": "m"}], "/monitors/0")
    scene("/monitors", [{"name": "m", "block": "none"}], "/monitors/0/block", "none")
    scene("/monitors", [{"name": "m", "block": "top"}] * 2, "/monitors/1/name", "two")
    scene("/monitors", [{"name": "m\r\n=1+1", "block": "top"}], "/monitors/0/name", "control character")
    scene("/references/0/monitor", "none")
    scene("/references/0/quantity", "force")
    scene("/references/0/quantity", "colour")
    scene("/references/0/exact", ["0", "0", "0"])
    scene("/references/0/exact", None)
    scene("/references/0/exact", {"table": [[0, 1, 2, 3]]})


def formulas():
    for bad, *words in (("=", ""), ("=1+", ""), ("=x", '"x"'), ("=sin(", ""), ("=1,2", "one value"),
                        ("=t=5", "assign"), ("=phi=5", "assign"), ("=phi+=5", "assign"),
                        ("=0/0", "finite"), ("=1/0", "finite"), ("=sqrt(-1)", "finite"),
                        ("=1e308*10", "finite"), ('="a"', ""), ("=" + "(" * 100000, ""),
                        ("=" + "1+" * 50000 + "x", ""), ("=" + "x" * 100000, ""),
                        ("=1;2", ""), ("=rnd(", "")):
        scene("/time_step", bad, "/time_step", *words)
    for name, word in (("pi", "pi"), ("deg", "deg"), ("t", '"t"'), ("sin", "sin"), ("a b", "a b"),
                       ("1x", "1x"), ("", "name"), ("a+b", "a+b"), ("x" * 500, "name")):
        scene(f"/parameters/{name}", 3, "/parameters", word)
    scene("/parameters", [1])
    scene("/parameters", None)
    scene("/parameters/phi", None)
    scene("/parameters/phi", "30")
    scene("/parameters/phi", "=psi", "/parameters/phi")
    scene("/parameters/phi", "=phi", "/parameters/phi")
    for exact in ("t=5", "x", "", "1,2", "sin("):
        scene("/references/0/exact", exact)
    for exact in ("0/0", "1/0", "sqrt(-1)", "t/(t-t)"):
        add(f"reference {exact}", ["reference", "displacement"],
            {"bad.json": changed("/references/0/exact", exact)}, ["run", "bad.json"], 1)
    add("a reference that is missed", ["reference", "allowed 1e-09"],
        {"bad.json": changed("/references/0", {**SCENE["references"][0], "exact": 1, "allowed": 1e-9})},
        ["run", "bad.json"], 1)
    add("a reference that is not reached", ["reference", "no step"],
        {"bad.json": changed("/references/0/from", 5)}, ["run", "bad.json"], 1)


def block_files():
    def mesh(name, content, *words, keys=None, code=None, file="stones.obj"):
        blocks = {"file": file, "format": "obj", "material": "rock", "supports": "lowest_course",
                  **(keys or {})}
        bare = copy.deepcopy(SCENE)
        bare.update(blocks=blocks, monitors=[], references=[])
        add(f"file: {name}", list(words), {"bad.json": json.dumps(bare), "stones.obj": content},
            ["run", "bad.json"], code or (1, 2))

    good = CUBE + CUBE_FACES
    mesh("missing", good, "none.obj", file="none.obj")
    mesh("a folder", good, ".", file=".")
    mesh("empty", "", "stones.obj")
    mesh("no faces", CUBE, "stones.obj")
    mesh("coordinates that are words", "v a b c\n", "stones.obj", "line 1")
    mesh("two coordinates", "v 1 2\n", "stones.obj", "line 1")
    for index in ("9", "0", "-9", "4294967303", "99999999999999999999", "x", "1x", "-", "/1", "1.5"):
        mesh(f"vertex {index}", CUBE + f"f 1 2 {index}\n", "stones.obj", "line 9")
    mesh("an edge", CUBE + "f 1 2\n", "stones.obj", "line 9")
    mesh("not closed", CUBE + CUBE_FACES[:40], "block0")
    mesh("not a number", good.replace("v 1 1 1", "v 1 1 nan"), "stones.obj")
    mesh("no such support", good, "/blocks/supports/0", keys={"supports": ["seven"]})
    mesh("no support at all", good, "/blocks", "support", keys={"supports": "flagged"})
    mesh("no such format", good, "/blocks/format", keys={"format": "step"})
    mesh("no format", good, "format", keys={"format": None})
    mesh("OBJ taken for COMPAS", good, "stones.obj", keys={"format": "compas"})
    mesh("COMPAS taken for OBJ", '{"data": {}}', "stones.obj")
    mesh("scale 0", good, "/blocks/scale", keys={"scale": 0})
    mesh("unknown key", good, "/blocks/unit", keys={"unit": "mm"})
    mesh("no material", good, "material", keys={"material": "wood"})
    for name, content in (("no JSON", "x"), ("a list", "[]"), ("empty", "{}"), ("null", "null"),
                          ("nodes null", '{"data":{"graph":{"data":{"node":null}}}}'),
                          ("nodes a list", '{"data":{"graph":{"data":{"node":[1]}}}}'),
                          ("a block null", '{"data":{"graph":{"data":{"node":{"0":{"block":null}}}}}}'),
                          ("no vertices", '{"blocks":{"0":{"vertex":{},"face":{}}}}'),
                          ("a face without vertex",
                           '{"blocks":{"0":{"vertex":{"0":{"x":0,"y":0,"z":0}},"face":{"0":[0,1,7]}}}}'),
                          ("30000 deep", "[" * 30000 + "]" * 30000)):
        mesh(f"COMPAS, {name}", content, "stones.obj", keys={"format": "compas"})


def command_line():
    good = {"good.json": json.dumps(SCENE)}
    for words, said in (([], "command"), (["fly"], "fly"), (["run"], "scene"),
                        (["run", "good.json", "--fly"], "--fly"),
                        (["run", "good.json", "--threads", "0"], "--threads"),
                        (["run", "good.json", "--threads", "many"], "--threads"),
                        (["run", "good.json", "--threads", "99999999999999999999"], "--threads"),
                        (["run", "good.json", "--max-seconds", "-1"], "--max-seconds"),
                        (["run", "good.json", "--max-seconds", "nan"], "--max-seconds"),
                        (["run", "good.json", "--checkpoint", "soon"], "--checkpoint"),
                        (["run", "good.json", "--checkpoint", "5"], "--out"),
                        (["run", "good.json", "--checkpoint", "0", "--out", "x"], "--checkpoint: must lie in"),
                        (["run", "good.json", "--resume", "x"], "--resume"),
                        (["run", "good.json", "--on-failure", "pray"], "--on-failure"),
                        (["run", "good.json", "--set", "phi"], "NAME=VALUE"),
                        (["run", "good.json", "--set", "=3"], "NAME=VALUE"),
                        (["run", "good.json", "--set", "psi=3"], "psi"),
                        (["run", "good.json", "--set", "phi=[1]"], "/parameters/phi"),
                        (["run", "good.json", "--set", "phi=" + "[" * 30000], "deep"),
                        (["run", "good.json", "--set", "/title=\udcff"], "/title"),
                        (["run", "good.json", "--set", "/blocks/7/name=x"], "/blocks/7"),
                        (["run", "good.json", "--set", "/blocks/-/name=x"], "/blocks/-"),
                        (["run", "good.json", "--set", "/blocks/01/name=x"], "/blocks/01"),
                        (["run", "good.json", "--set", "/blocks/99999999999999999999/name=x"], "/blocks"),
                        (["run", "good.json", "--set", "/blocks/x/name=x"], "/blocks/x"),
                        (["run", "good.json", "--set", "/a~2=1"], "/a~2"),
                        (["run", "good.json", "--set", "/end_time/x=1"], "/end_time"),
                        (["study", "good.json"], "--vary"),
                        (["study", "good.json", "--vary", "dt"], "KEY=VALUE"),
                        (["study", "good.json", "--vary", "dt=1", "--jobs", "0"], "--jobs"),
                        (["study", "good.json", "--vary", "dt=1", "--max-seconds", "-1"], "--max-seconds"),
                        (["study", "good.json", "--vary", "dt=1", "--max-seconds", "1e10"], "--max-seconds: must lie in"),
                        (["study", "good.json", "--vary", "dt=1", "--vary", "/time_step=2"], "twice"),
                        (["study", "good.json", "--vary", "dt=1,,2"], "empty"),
                        (["stability", "--out", ""], "--out"),
                        (["make", "wall", "--length", "nan"], "--length: must lie in"),
                        (["make", "arch", "--young", "nan"], "--young: must lie in"),
                        (["make", "tower", "--end-time", "-nan"], "--end-time: must lie in"),
                        (["info", "good.json", "--units", "nan"], "--units"),
                        (["info", "good.json", "--units", "0"], "--units"),
                        (["validate", "V999"], "V999"), (["stability", "--filter", "("], "--filter"),
                        (["contact"], "--pairs"),
                        (["contact", "--pairs", "-", "--reach", "-1"], "--reach")):
        add("quoin " + " ".join(words)[:70].encode("ascii", "replace").decode(), said, good, words)
    add("nothing to resume", "checkpoint", good, ["run", "--resume", "out"], 1)
    add("results in the way", "letter.txt", {**good, "out/letter.txt": "dear"},
        ["run", "good.json", "--out", "out"], 1)
    add("a file in the way", "file", {**good, "file": ""}, ["run", "good.json", "--out", "file"], 1)
    add("a summary of somebody", "summary.json", {**good, "out/summary.json": "{}"},
        ["run", "good.json", "--out", "out"], 1)
    add("a manifest of somebody", "manifest.json", {**good, "out/manifest.json": "[1]"},
        ["run", "good.json", "--out", "out"], 1)
    add("stability, cells of somebody", "good.json", good,
        ["stability", "--filter", "mass", "--out", "good.json"], (1, 2))
    add("stability, a folder in the way", ".: can't be read", good,
        ["stability", "--filter", "impact", "--out", "."], 1)
    add("stability, no such folder", "none/cells.json.part: can't be written", good,
        ["stability", "--quick", "--filter", "impact", "--out", "none/cells.json"], 1)
    add("study that can't be read", "none.json", good, ["study", "none.json", "--vary", "dt=1"], 1)


def pairs():
    cube = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    good = {"id": 1, "a": cube, "b": [[x + 3, y, z] for x, y, z in cube]}
    for name, line, words in (
            ("unknown key", {**good, "tolerance": 1}, 'unknown key \\"tolerance\\"'),
            ("key twice", '{"a": [], "a": []}', "twice"), ("30000 deep", "[" * 30000, "deep"),
            ("30000 deep, closed", '{"a":' + "[" * 30000 + "]" * 30000 + "}", "deep"),
            ("null body", {**good, "a": None}, '\\"a\\"'), ("flat", {**good, "a": cube[:4]}, '\\"a\\"'),
            ("long wrong value", {**good, "tol": "x" * 100000}, '\\"tol\\"'),
            ("tol null", {**good, "tol": None}, '\\"tol\\"')):
        content = line if isinstance(line, str) else json.dumps(line)
        add(f"contact: {name}", [words, "line 1"], {}, ["contact", "--pairs", "-"], 2, content + "\n")


def limits():
    resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def fault(case, folder):
    """What is wrong with how the case ended; empty when all is well."""
    _, code, words, files, arguments, stdin = case
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
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
        print(f"{case[0]}: exit {done.returncode}, {seconds:.2f} s: {said.strip()}")
    faults = [f"exit code {done.returncode}, not {code}"
              if done.returncode not in (code if isinstance(code, tuple) else (code,)) else "",
              f"{seconds:.1f} s" if seconds > SECONDS else "",
              "says more than 700 bytes" if len(said) > 700 else "",
              "not one line" if said.count("\n") not in (1, 2) else "",
              "control characters" if any(c < " " and c != "\n" for c in said) else "",
              "the word of another program" if any(w in said for w in (
                  "json.exception", "std::", "stoi", "stol", "what():", "Traceback")) else "",
              "left something behind" if sorted(folder.rglob("*")) != before else ""]
    faults += [f"does not say {word!r}" for word in words if word not in said]
    return "; ".join(f for f in faults if f) + (f"\n       said: {said[:300].strip()}" if any(faults) else "")


for fill in (syntax, values, formulas, block_files, command_line, pairs):
    fill()
failures = 0
for case in cases:
    if ONLY in case[0]:
        with tempfile.TemporaryDirectory() as holder:
            wrong = fault(case, pathlib.Path(holder))
        failures += bool(wrong)
        if wrong:
            print(f"WRONG  {case[0]}: {wrong}")
print(f"{len(cases)} bad inputs, {failures} not refused as they should be")
sys.exit(1 if failures or len(cases) < 150 else 0)
