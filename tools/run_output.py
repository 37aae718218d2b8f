"""What `quoin run --out` left, read back: history.csv, blocks_*.vtu and contacts_*.vtp."""
import contextlib
import csv
import pathlib
import re
import sys
import xml.etree.ElementTree as xml

import numpy as np

TYPES = {"Int8": "i1", "UInt8": "u1", "Int32": "<i4", "UInt32": "<u4", "Int64": "<i8",
         "UInt64": "<u8", "Float32": "<f4", "Float64": "<f8"}
FIXED, ABSENT = 2, 4  # solver::BlockKind: fixed; prescribed and absent above it


@contextlib.contextmanager
def reading(path):
    """What goes wrong in a file ends the program with a line that names it."""
    try:
        yield
    except OSError as error:
        sys.exit(f"{path}: {error.strerror}; quoin run --out leaves it")
    except (ValueError, LookupError, AttributeError, TypeError, StopIteration, xml.ParseError):
        sys.exit(f"{path}: is not as quoin run wrote it")


def run_program(main):
    """main(); what can't be written ends the program with a line that names it."""
    try:
        main()
    except OSError as error:
        sys.exit(f"{error.filename or 'the picture'}: can't be written: {error.strerror or error}")


def history(folder):
    """{column: values} of history.csv."""
    path = pathlib.Path(folder) / "history.csv"
    with reading(path), open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
        table = np.array(rows[1:], dtype=float).reshape(-1, len(rows[0]))
        return {name: table[:, i] for i, name in enumerate(rows[0])}


def arrays(path):
    """{name: values} of a .vtu or .vtp file, as text or with raw appended data."""
    data = pathlib.Path(path).read_bytes()
    mark = re.search(rb'<AppendedData[^>]*encoding="raw"[^>]*>\s*_', data)
    text = data if mark is None else data[:mark.start()] + b"</VTKFile>"
    root = xml.fromstring(text)
    head = np.dtype(TYPES[root.get("header_type", "UInt32")])
    found = {}
    for node in root.iter("DataArray"):
        kind = np.dtype(TYPES.get(node.get("type"), "<f8"))
        if node.get("type") == "String":
            continue
        if node.get("format") == "appended":
            at = mark.end() + int(node.get("offset"))
            size = int(np.frombuffer(data, head, 1, at)[0])
            values = np.frombuffer(data, kind, size // kind.itemsize, at + head.itemsize)
        else:
            values = np.array((node.text or "").split(), dtype=kind)
        components = int(node.get("NumberOfComponents", "1"))
        found[node.get("Name")] = values.reshape(-1, components) if components > 1 else values
    return found


def series(folder, name):
    """[(time, path)] of blocks.pvd or contacts.pvd."""
    path = pathlib.Path(folder) / f"{name}.pvd"
    with reading(path):
        found = [(float(d.get("timestep")), path.parent / d.get("file"))
                 for d in xml.parse(path).getroot().iter("DataSet")]
        if not found:
            raise ValueError
        return found


def pieces(path):
    """The arrays of a file, or of each that a .pvtu or .pvtp file names."""
    path = pathlib.Path(path)
    if not path.suffix.startswith(".p"):
        return [arrays(path)]
    return [arrays(path.parent / piece.get("Source")) for piece in xml.parse(path).getroot().iter("Piece")]


class Blocks:
    """Corners now and at the start, faces by corner, and what is known of each block."""

    def __init__(self, path):
        with reading(path):
            found = pieces(path)
            self.points = np.concatenate([piece["Points"] for piece in found])
            self.moved = np.concatenate([piece["displacement"] for piece in found])
            first, shown = 0, []
            for piece in found:
                stream = iter(piece["faces"])
                for block, kind in zip(piece["block"], piece["kind"]):
                    own = [[first + int(next(stream)) for _ in range(int(next(stream)))]
                           for _ in range(int(next(stream)))]
                    shown.append((int(block), int(kind), [] if kind == ABSENT else own))
                first += len(piece["Points"])
            shown.sort(key=lambda block: block[0])
            self.kind = np.array([kind for _, kind, _ in shown])
            self.faces = [own for _, _, own in shown]

    def held(self, block):
        return self.kind[block] >= FIXED

    def placed(self, scale):
        """Corners with displacements since the start enlarged."""
        return self.points + (scale - 1.0) * self.moved


class Contacts:
    """Contact points, and by pair of blocks what they add up to."""

    def __init__(self, path):
        with reading(path):
            parts = pieces(path)
            found = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
            self.points = found["Points"].reshape(-1, 3)
            self.state = np.atleast_1d(found["state"])  # 0: open, 1: stick, 2: slip
            self.failed = np.atleast_1d(found["failed"]) > 0  # bears its residual strength
            self.normal_force = np.atleast_1d(found["normal_force"])
            self.force_on_b = found["force_on_b"].reshape(-1, 3)
            self.normal = found["normal"].reshape(-1, 3)
            self.area = np.atleast_1d(found["area"])
            self.pair = np.column_stack([found["block_a"], found["block_b"]]).reshape(-1, 2)

    def joints(self):
        """For each pair that bears a force: blocks, centre of pressure (m), force on b (N), its normal
        and shear parts (N), area (m2), least and largest pressure of a point (Pa)."""
        result = []
        if not len(self.pair):
            return result
        order = np.lexsort(self.pair.T[::-1])
        cuts = np.flatnonzero(np.any(np.diff(self.pair[order], axis=0), axis=1)) + 1
        for rows in np.split(order, cuts):
            total = self.normal_force[rows].sum()
            if not total > 0:
                continue
            force = self.force_on_b[rows].sum(axis=0)
            normal = self.normal_force[rows] @ self.normal[rows]
            normal = normal / np.linalg.norm(normal)
            along = force @ normal
            pressure = self.normal_force[rows] / np.where(self.area[rows] > 0, self.area[rows], np.nan)
            result.append({"a": self.pair[rows[0], 0], "b": self.pair[rows[0], 1],
                           "centre": self.normal_force[rows] @ self.points[rows] / total,
                           "points": self.points[rows], "force": force, "normal": along,
                           "shear": np.linalg.norm(force - along * normal),
                           "area": self.area[rows].sum(), "pressure": pressure})
        return result
