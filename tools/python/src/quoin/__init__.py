"""Contacts of convex polyhedra, and a 3-D discontinuous deformation analysis on them.

SI units, radians, world frame. Normals are unit vectors from a to b; gap = (point_b - point_a)·normal, negative:
overlap. Names are those of the C++ interface. Arrays of contacts are structured numpy arrays, a row each.
Bad input raises InputError, a ValueError, with one line that names block, feature, value and limit.
"""
from ._quoin import (Bodies, Body, ContactFinder, InputError, NearestFeatures, PairBatch, PairContact, RayHit, Shape,
                     __version__, contacts, contains, distance, nearest, overlap, pair_contact, ray)

#: What the numbers of structured arrays mean: fields type, kind_a and kind_b, status, event.
CONTACT_TYPES = ("vertex-vertex", "vertex-edge", "vertex-face", "edge-edge-crossing", "edge-edge-parallel",
                 "edge-face", "face-face")
FEATURE_KINDS = ("vertex", "edge", "face")
PAIR_STATUSES = ("separated", "touching", "overlapping", "not-converged")
PAIR_EVENTS = ("begin", "persist", "end")

__all__ = ["Bodies", "Body", "CONTACT_TYPES", "ContactFinder", "FEATURE_KINDS", "InputError", "NearestFeatures",
           "PAIR_EVENTS", "PAIR_STATUSES", "PairBatch", "PairContact", "RayHit", "Shape", "__version__", "contacts",
           "contains", "distance", "nearest", "overlap", "pair_contact", "ray"]
