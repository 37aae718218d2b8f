"""Contacts of convex polyhedra, and a 3-D discontinuous deformation analysis on them.

SI units, radians, world frame. Normals are unit vectors from a to b; gap = (point_b - point_a)·normal, negative:
overlap. Names are those of the C++ interface. Arrays of contacts are structured numpy arrays, a row each.
Bad input raises InputError, a ValueError, with one line that names block, feature, value and limit.
"""
from . import adapters, plot
from ._quoin import (Bodies, Body, ContactFinder, Equilibrium, Impact, InputError, NearestFeatures, PairBatch,
                     PairContact, RayHit, Shape, Simulation, StepReport, __version__, contacts, contains, distance,
                     equilibrium, nearest, overlap, pair_contact, ray, run, shape_faults, split, time_of_impact)
from .scenes import Scene, limit, read
from .viewing import Page, Recording, view

#: What the numbers of structured arrays mean: fields type, kind_a and kind_b, status, event, mode.
CONTACT_TYPES = ("vertex-vertex", "vertex-edge", "vertex-face", "edge-edge-crossing", "edge-edge-parallel",
                 "edge-face", "face-face")
FEATURE_KINDS = ("vertex", "edge", "face")
PAIR_STATUSES = ("separated", "touching", "overlapping", "not-converged")
PAIR_EVENTS = ("begin", "persist", "end")
CONTACT_MODES = ("open", "stick", "slip")

__all__ = ["Bodies", "Body", "CONTACT_MODES", "CONTACT_TYPES", "ContactFinder", "Equilibrium", "FEATURE_KINDS",
           "Impact", "InputError", "NearestFeatures", "PAIR_EVENTS", "PAIR_STATUSES", "Page", "PairBatch",
           "PairContact", "RayHit", "Recording", "Scene", "Shape", "Simulation", "StepReport", "__version__",
           "adapters", "contacts", "contains", "distance", "equilibrium", "limit", "nearest", "overlap", "pair_contact",
           "plot", "ray", "read", "run", "shape_faults", "split", "time_of_impact", "view"]
