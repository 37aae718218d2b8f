"""`quoin contact`: the G cases with their exact numbers, bad lines one by one, order and exit codes.

usage: test_contact_command.py QUOIN SOURCE_DIR
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import time

from elsewhere import rotation

QUOIN, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
failures = []


def expect(holds, what):
    if not holds:
        failures.append(what)


def asked(lines, *options):
    text = "\n".join(line if isinstance(line, str) else json.dumps(line) for line in lines)
    return subprocess.run([QUOIN, "contact", "--pairs", "-", *options], input=text,
                          capture_output=True, text=True)


def ask(lines, *options):
    done = asked(lines, *options)
    return done.returncode, [json.loads(line) for line in done.stdout.splitlines()]


def box(low, high):
    return [[(low, high)[i & 1][0], (low, high)[i >> 1 & 1][1], (low, high)[i >> 2][2]]
            for i in range(8)]


def turned(points, axis, degrees, shift=(0, 0, 0)):
    rows = rotation(axis, degrees)
    return [[sum(q * c for q, c in zip(row, p)) + s for row, s in zip(rows, shift)] for p in points]


CUBE = box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))

def moved(points, shift):
    return [[p[k] + shift[k] for k in range(3)] for p in points]


def test_configurations():
    """Known contacts (tests/pairs), as the library is asked for them by tests/pairs/test_known_pairs.cpp."""
    lines = list(map(json.loads, (SOURCE / "tests/pairs/configurations.jsonl").read_text().splitlines()))
    code, answers = ask([{key: line[key] for key in ("id", "source", "what", "a", "b")} for line in lines])
    expect(code == 0, f"exit code {code} for good lines")
    expect([a["id"] for a in answers] == [line["id"] for line in lines], "the order is not kept")
    for line, answer in zip(lines, answers):
        name, exact, known = line["id"], line["exact"], line["answer"]
        expect(abs(answer["gap"] - exact["gap"]) <= 1e-12 + 1e-15 * abs(exact["gap"]), f"{name}: gap {answer['gap']}")
        for body in "ab":
            residual = answer["certificate"]["residual_" + body]
            expect(0 <= residual <= 1e-9, f"{name}: residual_{body} {residual}")
        if "tolerance" in known or "reach" in known:
            continue
        if "type" in exact and not answer["indeterminate"]:
            expect(answer["type"] == known.get("type", exact["type"]), f"{name}: type {answer['type']}")
        for key, found in (("status", answer["status"]), ("indeterminate", answer["indeterminate"]),
                           ("points", len(answer["points"]))):
            expect(known.get(key, found) == found, f"{name}: {key} {found}")
        expect(abs(answer["area"] - known.get("area", answer["area"])) < 1e-9, f"{name}: area {answer['area']}")
        expect(all(abs(n - m) < 1e-12 for n, m in zip(answer["normal"], known.get("normal", answer["normal"]))),
               f"{name}: normal {answer['normal']}")
    tip, octagon = answers[[line["id"] for line in lines].index("published search")], answers[
        [line["id"] for line in lines].index("octagon 0")]
    expect(tip["features"]["b"] == {"kind": "vertex", "vertices": [0]}, f"the tip: features {tip['features']}")
    expect(sorted(tip["features"]["a"]["vertices"]) == [0, 1, 2, 3], "the face under the tip")
    expect(len(octagon["polygon"]) == 8, "the polygon is an octagon")


def test_keys_and_input_indices():
    order = [5, 3, 0, 7, 1, 6, 2, 4]
    points = [[0, 0, 0]] + [CUBE[i] for i in order]  # the first is inside
    code, (answer,) = ask([{"id": None, "a": points, "b": moved(CUBE, (0.25, 0.25, 1.5))}])
    expect(code == 0 and answer["id"] is None, "a null id comes back")
    expect(list(answer) == ["id", "status", "gap", "normal", "point_a", "point_b", "type",
                            "features", "indeterminate", "points", "area", "polygon",
                            "certificate", "iterations"], f"keys {list(answer)}")
    top = sorted(i for i, p in enumerate(points) if p[2] == 0.5)
    expect(sorted(answer["features"]["a"]["vertices"]) == top, "indices are those of the input")
    kinds = sorted(p["kind"] for p in answer["points"])
    expect(kinds == ["edge-edge"] * 2 + ["vertex-face"] * 2, f"kinds {kinds}")
    expect(answer["gap"] == 0.5 and answer["normal"] == [0, 0, 1], "gap and normal")


def test_reach_and_tol():
    tilted = turned(box((0, 0, 0), (1, 1, 1)), (0, 1, 0), -0.01, (0, 0, 0.5))
    floor = box((-2, -2, -1), (2, 2, 0))
    for options, tol, kind, count in (((), {}, "edge-face", 2), (("--reach", "0.01"), {}, "edge-face", 4),
                                      ((), {"tol": 1e-3}, "face-face", 4)):
        _, (answer,) = ask([{"id": 0, "a": floor, "b": tilted, **tol}], *options)
        expect(answer["type"] == kind and len(answer["points"]) == count,
               f"{options} {tol}: {answer['type']} with {len(answer['points'])} points")


def test_published_search():
    roof = [[-10, -10, 0], [10, -10, 0], [10, 10, 0], [-10, 10, 0], [0, 0, -0.5]]
    point = [[0, 0, 0.005], [1, 0, 1], [-.5, .8, 1], [-.5, -.8, 1]]
    lines = [{"id": "missed", "a": roof, "b": point},
             {"id": "right", "a": CUBE, "b": moved(CUBE, (0.25, 0.25, 1.5))}, {"id": "bad"}]
    done = asked(lines, "--search", "published")
    missed, right, bad = (json.loads(line) for line in done.stdout.splitlines())
    expect(done.returncode == 2 and "error" in bad, "a bad line with --search published")
    expect(missed["gap"] > 0.5 and missed["stands_still"], f"the roof: {missed}")
    expect(not missed["proved"] and missed["least_gap"] <= 0.005, f"the roof's proof: {missed}")
    expect(right["gap"] == 0.5 and right["proved"], f"two cubes: {right}")
    expect(done.stderr == "published search: 2 pairs, 1 proved, 0 never still\n", done.stderr)
    code = asked([], "--search", "best").returncode
    expect(code not in (0, 1), f"an unknown search: exit code {code}")


def test_placements():
    lid = box((0, 0, 0), (1, 1, 1))
    turn = [0, -1, 0, 1, 0, 0, 0, 0, 1]  # a quarter about z, by rows
    one = [1, 0, 0, 0, 1, 0, 0, 0, 1]
    code, (placed, plain, near) = ask([
        {"id": 0, "a": {"points": lid, "placement": [8, 0, 0] + turn}, "b": {"points": CUBE,
                                                                            "placement": [7.5, 0.5, 2] + one}},
        {"id": 1, "a": [[8 - y, x, z] for x, y, z in lid], "b": moved(CUBE, (7.5, 0.5, 2))},
        {"id": 2, "a": {"points": lid}, "b": moved(CUBE, (0.5, 0.5, 2))}])
    expect(code == 0, f"placements: exit code {code}")
    expect(placed["gap"] == 0.5 and placed["area"] == 1 and placed["type"] == "face-face",
           f"placed: {placed}")
    expect(sorted(p["point_a"] for p in placed["points"])
           == sorted(p["point_a"] for p in plain["points"]), "points stand in the world")
    expect(sorted(placed["features"]["a"]["vertices"]) == [4, 5, 6, 7], "indices of the input")
    expect(near["gap"] == 0.5, "points without a placement stand where they are")
    bad = [
        ({"points": lid, "placement": [0, 0, 0] + turn[:8]}, "12 numbers"),
        ({"points": lid, "placement": [0, 0, "0"] + turn}, "12 numbers"),
        ({"points": lid, "placement": [0, 0, 0] + [-1, 0, 0, 0, 1, 0, 0, 0, 1]}, "determinant -1"),
        ({"points": lid, "placement": [0, 0, 0] + 9 * [0]}, "determinant 0"),
        ({"points": lid, "placement": [1e31, 0, 0] + turn}, "moves by 1e+31 m, at most 1e+30"),
        ({"placement": [0, 0, 0] + turn}, "\"points\" is missing"),
        ({"points": "no"}, "not a list of points"),
        ({"points": lid[:3] + [[0, 0]]}, "point 3"),
        ({"points": lid, "pose": []}, "unknown key \"pose\""),
    ]
    code, answers = ask([{"id": 0, "a": CUBE, "b": b} for b, _ in bad])
    expect(code == 2, f"exit code {code} after bad placements")
    for (b, words), answer in zip(bad, answers):
        error = answer.get("error", "")
        expect("\"b\"" in error and words in error, f"{b}: {error}")


def test_bad_lines():
    good = {"id": "good", "a": CUBE, "b": moved(CUBE, (3, 0, 0))}
    tetrahedron = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    bad = [
        ({"id": 1, "a": CUBE[:3], "b": CUBE}, "3 points"),
        ({"id": 2, "a": [], "b": CUBE}, "0 points"),
        ({"id": 3, "a": CUBE}, "\"b\" is missing"),
        ({"id": 4, "a": CUBE, "b": tetrahedron[:3] + [[1, 1, 0]]}, "\"b\""),  # flat
        ({"id": 5, "a": CUBE, "b": tetrahedron[:3] + [[0, 0]]}, "point 3"),
        ({"id": 6, "a": CUBE, "b": tetrahedron[:3] + [[0, 0, "1"]]}, "point 3"),
        ({"id": 7, "a": CUBE, "b": CUBE, "tol": -1}, "tol"),
        ({"id": 8, "a": CUBE, "b": "no"}, "not a list"),
        ('{"id": 9, "a": [[0,0,NaN]], "b": []}', "not JSON"),
        ('{"id": 10, "a": [[0,0,1e999]], "b": []}', "not JSON"),
        ("[11]", "not a JSON object"),
        ("twelve", "not JSON"),
        ({"id": 13, "a": CUBE, "b": tetrahedron[:3] + [[0, 0, 1e300]]}, "point 3"),
    ]
    lines = [good, *(line for pair in bad for line in (pair[0], good))]
    code, answers = ask(lines)
    expect(code == 2, f"exit code {code} after bad lines")
    expect(len(answers) == len(lines), "one line out for each line in")
    for (line, words), answer in zip(bad, answers[1::2]):
        expect(set(answer) == {"id", "error"}, f"{line}: {answer}")
        expect(words in answer.get("error", ""), f"{line}: {answer.get('error')}")
        if isinstance(line, dict):
            expect(answer["id"] == line["id"], f"{line}: id {answer['id']}")
    expect(answers[17]["id"] == 9, "the id of a line that is no JSON, where it can be read")
    expect(all(a["gap"] == 2.0 for a in answers[::2]), "the rest go on")
    expect(ask([]) == (0, []), "no lines, no answers")


def test_round_trip_and_speed():
    lines = [{"id": i, "a": turned(CUBE, (1, 2, i + 1), 7 * i), "b": moved(CUBE, (1.9, 0.1, 0.2))}
             for i in range(20000)]
    with tempfile.NamedTemporaryFile("w", suffix=".jsonl") as file:
        file.write("\n".join(json.dumps(line) for line in lines))
        file.flush()
        start = time.monotonic()
        done = subprocess.run([QUOIN, "contact", "--pairs", file.name], capture_output=True, text=True)
        seconds = time.monotonic() - start
    answers = [json.loads(line) for line in done.stdout.splitlines()]
    expect([a["id"] for a in answers] == list(range(20000)), "20000 answers in order")
    expect(seconds < 60, f"20000 lines took {seconds:.1f} s")
    for answer in answers[:100]:
        along = sum((q - p) * n for p, q, n in
                    zip(answer["point_a"], answer["point_b"], answer["normal"]))
        expect(abs(along - answer["gap"]) < 1e-14, "digits enough to come round")


for test in (test_configurations, test_keys_and_input_indices, test_reach_and_tol, test_placements,
             test_published_search,
             test_bad_lines, test_round_trip_and_speed):
    test()
for failure in failures:
    print("failed:", failure)
print("all passed" if not failures else f"{len(failures)} failed")
sys.exit(1 if failures else 0)
