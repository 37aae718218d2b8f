#!/usr/bin/env python3
"""Writes the mesh files of this folder by other programs: VTK, meshio, assimp and ezdxf.

    tests/unit/meshes/make_meshes.py        # Debian: python3-vtk9 python3-meshio assimp-utils python3-ezdxf

Two boxes in each, 2 × 1 × 0.5 and 1 × 1 × 0.5, the second on the first so that they share an edge and a
part of a face. Names say who wrote them; the files are committed, this is run only to add one.
"""
import pathlib
import subprocess

import meshio
import numpy as np
import vtk
from ezdxf.addons.r12writer import r12writer

FOLDER = pathlib.Path(__file__).resolve().parent
BOXES = [(0, 2, 0, 1, 0, 0.5), (0, 1, 0, 1, 0.5, 1)]


def vtk_boxes(triangles):
    both = vtk.vtkAppendPolyData()
    for bounds in BOXES:
        box = vtk.vtkCubeSource()
        box.SetBounds(*bounds)
        box.Update()
        copy = vtk.vtkPolyData()
        copy.DeepCopy(box.GetOutput())
        both.AddInputData(copy)
    both.Update()
    if not triangles:
        return both
    divided = vtk.vtkTriangleFilter()
    divided.SetInputConnection(both.GetOutputPort())
    return divided


def by_vtk():
    for name, writer, triangles, setting in (
            ("vtk_ascii.stl", vtk.vtkSTLWriter(), True, "SetFileTypeToASCII"),
            ("vtk_binary.stl", vtk.vtkSTLWriter(), True, "SetFileTypeToBinary"),
            ("vtk_ascii.ply", vtk.vtkPLYWriter(), False, "SetFileTypeToASCII"),
            ("vtk_little_endian.ply", vtk.vtkPLYWriter(), False, "SetDataByteOrderToLittleEndian"),
            ("vtk_big_endian.ply", vtk.vtkPLYWriter(), False, "SetDataByteOrderToBigEndian"),
            ("vtk.obj", vtk.vtkOBJWriter(), False, None)):
        writer.SetFileName(str(FOLDER / name))
        boxes = vtk_boxes(triangles)
        writer.SetInputConnection(boxes.GetOutputPort())
        if setting:
            getattr(writer, setting)()
        writer.Write()


def by_meshio():
    points, quads = [], []
    for x0, x1, y0, y1, z0, z1 in BOXES:
        first = len(points)
        points += [(x, y, z) for z in (z0, z1) for y in (y0, y1) for x in (x0, x1)]
        quads += [[first + i for i in face] for face in
                  ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6))]
    points, quads = np.array(points, dtype=float), np.array(quads)
    triangles = np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    for name, cells, options in (
            ("meshio.off", ("triangle", triangles), {}),
            ("meshio.obj", ("quad", quads), {}),
            ("meshio_ascii.stl", ("triangle", triangles), {"binary": False}),
            ("meshio_binary.stl", ("triangle", triangles), {"binary": True}),
            ("meshio_ascii.ply", ("quad", quads), {"binary": False}),
            ("meshio_binary.ply", ("quad", quads), {"binary": True})):
        meshio.write(FOLDER / name, meshio.Mesh(points, [cells]), **options)


def by_assimp():
    for name, kind in (("assimp.obj", "obj"), ("assimp.ply", "ply"), ("assimp_binary.ply", "plyb"),
                       ("assimp.stl", "stl"), ("assimp_binary.stl", "stlb")):
        subprocess.run(["assimp", "export", FOLDER / "meshio.obj", FOLDER / name, f"-f{kind}"],
                       check=True, stdout=subprocess.DEVNULL)


def by_ezdxf():
    with r12writer(FOLDER / "ezdxf.dxf") as dxf:
        for x0, x1, y0, y1, z0, z1 in BOXES:
            corners = [(x, y, z) for z in (z0, z1) for y in (y0, y1) for x in (x0, x1)]
            for face in ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6)):
                dxf.add_3dface([corners[i] for i in face])


by_vtk()
by_meshio()
by_assimp()
by_ezdxf()
for left in FOLDER.glob("*.mtl"):
    left.unlink()
