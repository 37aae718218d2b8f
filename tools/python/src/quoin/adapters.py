"""Blocks and contacts of other packages, by their data alone: none of them is imported.

COMPAS: assemblies (1.x) and models (2.x), by file, JSON text, dict or object; results as interfaces with the
attributes that compas_assembly, compas_cra and compas_dem read. trimesh: anything with `vertices` and `faces`.
VTK: vtk_of() in memory; files by Simulation.to_vtk().
"""
import json
import os
import pathlib
import tempfile

import numpy as np

from . import _quoin
from .scenes import Scene


def shape_of(mesh, *, coordinate_rounding=0.0):
    """The Shape of a convex mesh: an object with `vertices` (n, 3), m, and `faces`, such as trimesh.Trimesh."""
    return _quoin.Shape.from_faces(np.asarray(mesh.vertices, dtype=float), [np.asarray(face) for face in mesh.faces],
                                   coordinate_rounding=coordinate_rounding)


def mesh_of(solid):
    """(vertices (n, 3), triangles (m, 3)) of a Shape or a Body, as trimesh.Trimesh(*mesh_of(solid)) takes them."""
    shape = solid.shape if isinstance(solid, _quoin.Body) else solid
    triangles = [(face[0], face[i], face[i + 1]) for face in shape.faces for i in range(1, len(face) - 1)]
    return np.array(solid.vertices), np.array(triangles)


def vtk_of(solid):
    """(points (n, 3), cells (m,)) of a Shape or a Body: its polygons as size, indices, size, ..., as VTK has them and
    pyvista.PolyData(*vtk_of(solid)) takes them."""
    shape = solid.shape if isinstance(solid, _quoin.Body) else solid
    return np.array(solid.vertices), np.concatenate([[len(face), *face] for face in shape.faces])


def _is_json(text):
    return text.lstrip()[:1] in ("{", "[")


def _text(source):
    if hasattr(source, "to_jsonstring"):
        return source.to_jsonstring()
    return source if isinstance(source, str) else json.dumps(source)


def scene_of(source, *, kind="rigid", material=None, **members):
    """A Scene of the blocks of a mesh file (COMPAS JSON, OBJ, STL, PLY, OFF), a COMPAS object, dict or JSON text.

    Blocks have the names of the file, m; supports are fixed. material: {"density": ..., ...}; members: of the Scene.
    """
    if isinstance(source, os.PathLike) or isinstance(source, str) and not _is_json(source):
        found = _quoin._read_meshes(str(source), "")
    else:
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "compas.json"
            path.write_text(_text(source), encoding="utf-8")
            found = _quoin._read_meshes(str(path), "compas")
    blocks = []
    for name, vertices, faces, is_support in found:
        shape = {"type": "polyhedron", "vertices": vertices, "faces": faces}
        own = {"kind": "fixed"} if is_support else {"kind": kind, "material": "stone"}
        blocks.append({"name": name, **own, "shape": shape})
    scene = Scene(blocks=blocks, materials={"stone": material or {"density": 2000.0}}, **members)
    if "stages" not in scene:
        scene.setdefault("end_time", 1.0)
    return scene


def _frame(points, normal):
    """Point, x axis and y axis of a frame whose z axis is the normal."""
    x = np.eye(3)[np.argmin(np.abs(normal))]
    x = x - (x @ normal) * normal
    x /= np.linalg.norm(x)
    return points.mean(axis=0), x, np.cross(normal, x)


def compas_interfaces(contacts, names):
    """Interfaces of COMPAS: a dict for each pair of blocks in contact, by (name of a, name of b).

    contacts: of a Simulation or an Equilibrium; names: of the blocks, as Simulation.block_names. Each dict holds type,
    size (m2), points, frame (point, xaxis, yaxis; its z axis runs from a to b) and forces, one a point: c_np
    (compression), c_nn (tension), c_u and c_v (on b, along the frame's axes), N.
    """
    from .plot import force_on_b
    contacts = contacts[contacts["a"] >= 0]  # held points have one block
    force = force_on_b(contacts)
    interfaces = {}
    pairs = np.stack([contacts["a"], contacts["b"]], axis=1)
    for a, b in np.unique(pairs, axis=0):
        own = (pairs == (a, b)).all(axis=1)
        points, normal = contacts["point"][own], contacts["normal"][own][0]
        origin, x, y = _frame(points, normal)
        pushes = force[own] @ normal
        forces = [{"c_np": max(float(n), 0.0), "c_nn": max(-float(n), 0.0), "c_u": float(f @ x), "c_v": float(f @ y)}
                  for n, f in zip(pushes, force[own])]
        area = float(contacts["area"][own].sum()) if "area" in contacts.dtype.names else 0.0
        kind = "face_face" if len(points) > 2 else "edge_edge" if len(points) == 2 else "vertex_face"
        interfaces[names[a], names[b]] = {
            "type": kind, "size": area, "points": points.tolist(), "forces": forces,
            "frame": {"point": origin.tolist(), "xaxis": x.tolist(), "yaxis": y.tolist()}}
    return interfaces


def set_compas_interfaces(assembly, contacts, names, make=dict):
    """Puts compas_interfaces() on the edges of an assembly or a model: attribute "interfaces", a list.

    Edges are those of assembly.graph; nodes are named as in the JSON from which the blocks came. make(**interface):
    the caller's class, such as compas_assembly.datastructures.Interface; default: a dict.
    """
    graph = assembly.graph
    nodes = {str(node): node for node in graph.nodes()}
    for (a, b), interface in compas_interfaces(contacts, names).items():
        edge = nodes[a], nodes[b]
        if not graph.has_edge(edge):
            if graph.has_edge(edge[::-1]):  # as COMPAS has it, from b to a: the force on a, along the same axes
                edge = edge[::-1]
            else:
                graph.add_edge(*edge)
        graph.edge_attribute(edge, "interfaces", [make(**interface)])
