"""Data of COMPAS 1.x and 2.x and of trimesh, in and out, without either package."""
import json
import types
import unittest

import numpy as np
import quoin

LOWER, UPPER = quoin.Shape.box([0, 0, 0], [2, 1, 1]), quoin.Shape.box([0, 0, 1], [1, 1, 2])


def mesh_data(shape):
    return {"vertex": {str(i): dict(zip("xyz", map(float, v))) for i, v in enumerate(shape.vertices)},
            "face": {str(i): face.tolist() for i, face in enumerate(shape.faces)}}


def assembly(version):
    """As COMPAS writes it: an assembly of 1.x, a model of 2.x."""
    if version == 1:
        nodes = {"0": {"block": {"data": mesh_data(LOWER)}, "is_support": True},
                 "1": {"block": {"data": mesh_data(UPPER)}}}
        return {"data": {"graph": {"data": {"node": nodes, "edge": {}}}}}
    elements = {f"guid-{i}": {"data": {"geometry": {"data": mesh_data(shape)}, "is_support": i == 0}}
                for i, shape in enumerate((LOWER, UPPER))}
    return {"data": {"elements": elements, "graph": {"data": {"node": {
        str(i): {"element": f"guid-{i}"} for i in range(2)}, "edge": {}}}}}


class Graph:
    """What of compas.datastructures.Graph the adapter calls."""

    def __init__(self, edges):
        self.edges = {edge: {} for edge in edges}

    def nodes(self):
        return [0, 1]

    def has_edge(self, edge):
        return edge in self.edges

    def add_edge(self, u, v):
        self.edges[u, v] = {}

    def edge_attribute(self, edge, name, value):
        self.edges[edge][name] = value


class Compas(unittest.TestCase):
    def test_blocks_of_both_versions(self):
        for version in (1, 2):
            for source in (assembly(version), json.dumps(assembly(version)),
                           types.SimpleNamespace(to_jsonstring=lambda v=version: json.dumps(assembly(v)))):
                scene = quoin.adapters.scene_of(source, joint={"friction_angle_deg": 30})
                self.assertEqual([(b["name"], b["kind"]) for b in scene["blocks"]], [("0", "fixed"), ("1", "rigid")])
                self.assertEqual(quoin.equilibrium(scene).verdict, "admissible")
        with self.assertRaises(quoin.InputError):
            quoin.adapters.scene_of({"data": {}})

    def test_interfaces_with_forces(self):
        scene = quoin.adapters.scene_of(assembly(1), material={"density": 1000.0}, gravity=[1.0, 0, -10.0],
                                        joint={"friction_angle_deg": 30})
        simulation = quoin.Simulation(scene, analysis="static")
        simulation.run()
        for contacts in (simulation.contacts, quoin.equilibrium(scene).contacts):
            found = quoin.adapters.compas_interfaces(contacts, simulation.block_names)
            interface = found["0", "1"]
            x, y = (np.array(interface["frame"][axis]) for axis in ("xaxis", "yaxis"))
            z = np.cross(x, y)
            np.testing.assert_allclose(z, [0, 0, 1], atol=1e-12)
            total = sum((f["c_np"] - f["c_nn"]) * z + f["c_u"] * x + f["c_v"] * y for f in interface["forces"])
            np.testing.assert_allclose(total, [-1000.0, 0, 10000.0], atol=1e-2)  # on the upper block
            self.assertEqual((interface["type"], len(interface["points"])), ("face_face", 4))
        for edges, kept in (([], (0, 1)), ([(0, 1)], (0, 1)), ([(1, 0)], (1, 0))):
            graph = Graph(edges)
            quoin.adapters.set_compas_interfaces(types.SimpleNamespace(graph=graph), contacts, ["0", "1"],
                                                 make=types.SimpleNamespace)
            self.assertEqual(list(graph.edges), [kept])
            self.assertEqual(len(graph.edges[kept]["interfaces"][0].forces), 4)


class Meshes(unittest.TestCase):
    def test_there_and_back(self):
        vertices, triangles = quoin.adapters.mesh_of(quoin.Body(LOWER, (np.eye(3), [0, 0, 7])))
        self.assertEqual((vertices.shape, triangles.shape), ((8, 3), (12, 3)))
        points, cells = quoin.adapters.vtk_of(LOWER)
        self.assertEqual((points.shape, len(cells), set(cells[::5])), ((8, 3), 30, {4}))
        shape = quoin.adapters.shape_of(types.SimpleNamespace(vertices=vertices, faces=triangles))
        self.assertAlmostEqual(shape.volume, 2.0)
        self.assertEqual(len(shape.faces), 6)


if __name__ == "__main__":
    unittest.main()
