"""Scenes: dicts by the schema of scene files (tools/scene.schema.json)."""
import copy
import json
import math
import os
import pathlib
import subprocess
import tempfile

from . import _quoin


def _plain(value):
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{type(value).__name__}: no part of a scene")


def _refuse_not_finite(value, pointer=""):
    """Raises InputError for the first number in a part of a scene that JSON has no word for."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, float) and not math.isfinite(value):
        raise _quoin.InputError(f"{pointer}: must be finite, is {value}")
    members = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, (list, tuple)) else ()
    for key, member in members:
        _refuse_not_finite(member, f"{pointer}/{key}")


class Scene(dict):
    """A scene, as scene files hold it: a dict that may hold numpy arrays.

    Scene(blocks=[...], end_time=1.0), Scene(a_dict) or read("scene.json"). It is checked when it is used, and by
    check(). Files that it names are relative to `folder` (default: that of a Scene it is made of, else the current one).
    """

    def __init__(self, *members, folder=None, **more):
        super().__init__(*members, **more)
        self.folder = str(folder or (getattr(members[0], "folder", ".") if members else "."))

    def copy(self):
        return Scene(self)

    def __or__(self, other):
        return Scene({**self, **other}, folder=self.folder)

    def add(self, solid, **members):
        """Appends a block with the shape of a Shape, or of a Body where it stands; members as in the schema: name,
        kind, material, velocity, ..."""
        shape = solid.shape if isinstance(solid, _quoin.Body) else solid
        polyhedron = {"type": "polyhedron", "vertices": solid.vertices.tolist(),
                      "faces": [face.tolist() for face in shape.faces]}
        self.setdefault("blocks", []).append({**members, "shape": polyhedron})

    def to_json(self):
        """The text of a scene file. Raises InputError for numbers that are not finite."""
        try:
            return json.dumps(self, default=_plain, allow_nan=False)
        except ValueError:
            _refuse_not_finite(self)
            raise

    def to_dict(self):
        """A plain copy, of lists and numbers."""
        return json.loads(self.to_json())

    def check(self, changes=()):
        """Raises InputError, with one line that names the place and the limit, for a scene that can't be run."""
        _quoin.Simulation(self, changes=list(changes))


def read(path):
    """The Scene of a scene file. Raises InputError and OSError."""
    path = pathlib.Path(path)
    document = json.loads(_quoin._plain_json(str(path)))
    if not isinstance(document, dict):
        raise _quoin.InputError(f"{path}: must be of type object, is {type(document).__name__}")
    return Scene(document, folder=path.parent)


def limit(scene, vary, *, tolerance=1e-4, changes=()):
    """How much a structure bears, with a proof on both sides: `quoin limit` as a call, and its report as a dict.

    vary: "load=NAME:FROM:TO", "tilt=FROM:TO[:x|y|z]" (degrees), "strength=FROM:TO", "friction=FROM:TO" (degrees) or
    "/json/pointer=FROM:TO". tolerance: how far apart the two proofs may be, relative. The dict has stands and falls
    (value and residuals, or None), convex, why (None: both are proved within the tolerance) and certificates: by
    "stands" and "falls", contact forces and mechanism (tools/guides/limit.md). Needs the command `quoin`, or the one
    that the environment names in QUOIN. Raises InputError where it refuses the scene.
    """
    document = copy.deepcopy(dict(scene))
    blocks = document.get("blocks")
    for entry in blocks if isinstance(blocks, list) else [blocks]:
        if isinstance(entry, dict) and "file" in entry:
            entry["file"] = str((pathlib.Path(scene.folder) / entry["file"]).resolve())
    with tempfile.TemporaryDirectory() as name:
        path, out = pathlib.Path(name) / "scene.json", pathlib.Path(name) / "out"
        path.write_text(Scene(document).to_json(), encoding="utf-8")
        words = [os.environ.get("QUOIN", "quoin"), "limit", str(path), "--vary", vary, "--tolerance", repr(tolerance),
                 "--out", str(out)]
        for change in changes:
            words += ["--set", change]
        done = subprocess.run(words, capture_output=True, text=True)
        if done.returncode not in (0, 1):
            raise _quoin.InputError((done.stderr.strip() or "quoin limit").replace(f"{path}: ", "").splitlines()[-1])
        report = json.loads((out / "limit.json").read_text(encoding="utf-8"))
        report["certificates"] = {side: json.loads(found.read_text(encoding="utf-8")) for side in ("stands", "falls")
                                  if (found := out / f"{side}.json").exists()}
        del report["scene"]
        return report
