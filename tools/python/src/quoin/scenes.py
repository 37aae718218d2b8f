"""Scenes: dicts by the schema of scene files (tools/scene.schema.json)."""
import json
import pathlib

from . import _quoin


def _plain(value):
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{type(value).__name__}: no part of a scene")


class Scene(dict):
    """A scene, as scene files hold it: a dict that may hold numpy arrays.

    Scene(blocks=[...], end_time=1.0), Scene(a_dict) or read("scene.json"). It is checked when it is used, and by
    check(). Files that it names are relative to `folder`.
    """

    def __init__(self, *members, folder=".", **more):
        super().__init__(*members, **more)
        self.folder = str(folder)

    def add(self, solid, **members):
        """Appends a block with the shape of a Shape, or of a Body where it stands; members as in the schema: name,
        kind, material, velocity, ..."""
        shape = solid.shape if isinstance(solid, _quoin.Body) else solid
        polyhedron = {"type": "polyhedron", "vertices": solid.vertices.tolist(),
                      "faces": [face.tolist() for face in shape.faces]}
        self.setdefault("blocks", []).append({**members, "shape": polyhedron})

    def to_json(self):
        """The text of a scene file."""
        return json.dumps(self, default=_plain)

    def to_dict(self):
        """A plain copy, of lists and numbers."""
        return json.loads(self.to_json())

    def check(self, changes=()):
        """Raises InputError, with one line that names the place and the limit, for a scene that can't be run."""
        _quoin.Simulation(self, changes=list(changes))


def read(path):
    """The Scene of a scene file. Raises InputError and OSError."""
    path = pathlib.Path(path)
    return Scene(json.loads(_quoin._plain_json(str(path))), folder=path.parent)
