"""What `quoin run --out` left, read back: history.csv, blocks_*.vtu and contacts_*.vtp."""
import contextlib
import csv
import functools
import json
import mmap
import pathlib
import re
import sys
import xml.etree.ElementTree as xml

import numpy as np

TYPES = {"Int8": "i1", "UInt8": "u1", "Int32": "<i4", "UInt32": "<u4", "Int64": "<i8",
         "UInt64": "<u8", "Float32": "<f4", "Float64": "<f8"}
RIGID, FIXED, ABSENT = 1, 2, 4  # solver::BlockKind: deformable below, prescribed between


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
    with open(path, "rb") as file:  # of the numbers only those are read that are looked at
        data = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    mark = re.search(rb'<AppendedData[^>]*encoding="raw"[^>]*>\s*_', data)
    text = data[:] if mark is None else data[:mark.start()] + b"</VTKFile>"
    root = xml.fromstring(text)
    head = np.dtype(TYPES[root.get("header_type", "UInt32")])
    found = {}
    for node in [*root.iter("DataArray"), *root.iter("Array")]:
        kind = np.dtype(TYPES.get(node.get("type"), "<f8"))
        if node.get("format") == "appended":
            at = mark.end() + int(node.get("offset"))
            size = int(np.frombuffer(data, head, 1, at)[0])
            if node.get("type") == "String":
                raw = data[at + head.itemsize:at + head.itemsize + size]
                found[node.get("Name")] = raw.decode("utf-8", "replace").split("\0")[:-1]
                continue
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


def common_faces(stream, ends, first):
    """[(cells, faces)]: cells whose faces name the same corners, counted from the first corner of each.
    `stream`: of all cells the number of faces, and of each face its size and corners; `ends`: by cell."""
    starts = np.concatenate([[0], ends[:-1]])
    found = []
    for length in np.unique(ends - starts):
        cells = np.flatnonzero(ends - starts == length)
        table = stream[starts[cells][:, None] + np.arange(length)]
        is_size, at = np.zeros(table.shape, dtype=bool), np.ones(len(cells), dtype=int)
        is_size[:, 0] = True
        for _ in range(table[:, 0].max()):
            inside = np.flatnonzero(at < length)
            is_size[inside, at[inside]] = True
            at[inside] += table[inside, at[inside]] + 1
        own = np.ascontiguousarray(np.where(is_size, table, table - first[cells][:, None]))
        _, one, group = np.unique(own.view(f"V{own.itemsize * length}").ravel(), return_index=True,
                                  return_inverse=True)
        order = np.argsort(group, kind="stable")
        for rows in np.split(order, np.cumsum(np.bincount(group))[:-1]):
            numbers = iter(own[one[group[rows[0]]]].tolist()[1:])
            found.append((cells[rows], [[next(numbers) for _ in range(size)] for size in numbers]))
    return found


class Blocks:
    """Corners now and at the start, faces, and what is known of each block, by block."""

    def __init__(self, path):
        with reading(path):
            found = pieces(path)
            self.points = np.concatenate([piece["Points"] for piece in found])
            self.moved = np.concatenate([piece["displacement"] for piece in found])
            block = np.concatenate([piece["block"] for piece in found])
            place = np.empty(len(block), dtype=int)
            place[np.argsort(block)] = np.arange(len(block))
            self.kind, self.speed = np.empty(len(block), dtype=int), np.empty(len(block))
            self.compression, self.first = np.empty(len(block)), np.empty(len(block), dtype=int)
            self.topologies, corners, cells = [], 0, 0  # [(blocks, faces by corner from the first)]
            for piece in found:
                own = place[cells:cells + len(piece["block"])]
                first = np.concatenate([[0], piece["offsets"][:-1]])
                self.kind[own], self.speed[own] = piece["kind"], piece["speed"]
                self.compression[own] = -piece["principal_stress"][:, 2]
                self.first[own] = corners + first
                self.topologies += [(own[rows], faces) for rows, faces in
                                    common_faces(piece["faces"], piece["faceoffsets"], first)]
                corners, cells = corners + len(piece["Points"]), cells + len(own)

    @functools.cached_property
    def faces(self):
        """Of each block, by corner; none of an absent one."""
        result = [[] for _ in self.kind]
        for rows, faces in self.topologies:
            for block in rows[self.kind[rows] != ABSENT]:
                first = int(self.first[block])
                result[block] = [[first + v for v in face] for face in faces]
        return result

    def held(self, block):
        return self.kind[block] >= FIXED

    def placed(self, scale):
        """Corners with displacements since the start enlarged."""
        return self.points + (scale - 1.0) * self.moved

    def polygons(self):
        """(corners one after the other, size of each polygon, its block), absent blocks left out."""
        corners, sizes, blocks = [], [], []
        for rows, faces in self.topologies:
            there = rows[self.kind[rows] != ABSENT]
            flat = np.concatenate(faces)
            corners.append((self.first[there][:, None] + flat).ravel())
            sizes.append(np.tile([len(face) for face in faces], len(there)))
            blocks.append(np.repeat(there, len(faces)))
        return tuple(np.concatenate(parts) for parts in (corners, sizes, blocks))

    def volumes_and_centroids(self):
        """m3 and m, by the tetrahedra from a corner of each block to its faces."""
        volumes, centroids = np.empty(len(self.kind)), np.empty((len(self.kind), 3))
        for rows, faces in self.topologies:
            fans = np.array([(face[0], face[i], face[i + 1]) for face in faces for i in range(1, len(face) - 1)])
            origins = self.points[self.first[rows]]
            corners = self.points[self.first[rows][:, None, None] + fans] - origins[:, None, None]
            parts = np.linalg.det(corners) / 6
            volumes[rows] = parts.sum(axis=1)
            centroids[rows] = origins + np.einsum("bt,btci->bi", parts, corners) / (4 * volumes[rows, None])
        return volumes, centroids

    def displacement(self):
        """Of each block's corners, the mean, m."""
        ends = np.append(np.sort(self.first)[1:], len(self.moved))
        order = np.argsort(self.first)
        sums = np.add.reduceat(self.moved, self.first[order], axis=0)
        result = np.empty((len(order), 3))
        result[order] = sums / (ends - self.first[order])[:, None]
        return result


def frame_labels(folder):
    """What each file of blocks.pvd shows: "start", or the stage, and whether it is that stage's end."""
    times = [time for time, _ in series(folder, "blocks")]
    stages = json.loads((pathlib.Path(folder) / "summary.json").read_text(encoding="utf-8"))["stages"]
    ends = {}
    with open(pathlib.Path(folder) / "blocks.csv", encoding="utf-8") as lines:
        next(lines)
        for line in lines:
            stage, time, _ = line.split(",", 2)
            ends[int(stage)] = float(time)
    labels, stage = ["start"], 0
    for time in times[1:]:
        if stage >= len(stages):
            break
        name = stages[stage]["name"] or f"stage {stage + 1}"
        static = stages[stage]["analysis"] != "dynamic"
        at_end = static or time >= ends.get(stage, np.inf) * (1 - 1e-9)
        name = f"end of {name}" if at_end and stages[stage]["done"] else name
        labels.append(name + (" (static)" if static else ""))
        stage += at_end
    return labels + [""] * (len(times) - len(labels))


def shown_times(folder):
    """The time of each file of blocks.pvd, s: there, ends of static stages stand a little apart; they take no time."""
    times = []
    for (time, _), label in zip(series(folder, "blocks"), frame_labels(folder)):
        times.append(times[-1] if label.endswith("(static)") else time)
    return times


def edge_stresses(folder):
    """{blocks of a joint: largest pressure at its edge without tension, Pa} of joints.csv at the end."""
    path = pathlib.Path(folder) / "joints.csv"
    with reading(path), open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
        return {(int(row["a"]), int(row["b"])): float(row["edge_stress"])
                for row in rows if row["stage"] == rows[-1]["stage"] and row["edge_stress"]}


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

    @functools.cached_property
    def joints(self):
        """For each pair that bears a force: blocks, centre of pressure (m), force on b (N), its normal
        and shear parts (N), area (m2), points (m), and the pressure of each (Pa)."""
        if not len(self.pair):
            return []
        order = np.lexsort(self.pair.T[::-1])
        pair, bears, points = self.pair[order], self.normal_force[order], self.points[order]
        cuts = np.flatnonzero(np.any(np.diff(pair, axis=0), axis=1)) + 1
        first = np.append(0, cuts)
        area, total, force, normal, centre = (np.add.reduceat(values, first) for values in (
            self.area[order], bears, self.force_on_b[order], bears[:, None] * self.normal[order], bears[:, None] * points))
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
        shear = np.linalg.norm(force - (force * normal).sum(axis=1)[:, None] * normal, axis=1)
        pressure = bears / np.where(self.area[order] > 0, self.area[order], np.nan)
        return [{"a": pair[first[i], 0], "b": pair[first[i], 1], "centre": centre[i] / total[i], "points": at, "force": force[i],
                 "normal": total[i], "direction": normal[i], "shear": shear[i], "area": area[i], "pressure": each}
                for i, (at, each) in enumerate(zip(np.split(points, cuts), np.split(pressure, cuts))) if total[i] > 0]


def largest_compression(blocks, contacts):
    """Of each block, Pa, of its mean stress. A rigid one has that of its contact forces: the sum over its contact points
    of arm from the centroid times force, over the volume (Love, Weber); the files do not say where loads, ties and fixed
    points act on it, and they have no part in it."""
    volumes, centroids = blocks.volumes_and_centroids()
    stresses = np.zeros((len(volumes), 3, 3))
    for side, sign in ((0, -1.0), (1, 1.0)):
        of = contacts.pair[:, side]
        arms = sign * (contacts.points - centroids[of])
        for i, j in np.ndindex(3, 3):
            stresses[:, i, j] += np.bincount(of, arms[:, i] * contacts.force_on_b[:, j], len(volumes)) / volumes
    of_forces = -np.linalg.eigvalsh(0.5 * (stresses + stresses.transpose(0, 2, 1)))[:, 0]
    return np.where(blocks.kind == RIGID, of_forces, blocks.compression)
