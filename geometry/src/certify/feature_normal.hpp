#pragma once
/// The normal that two support sets define, in closed form: it depends on the sets alone, not on
/// how the search came to them. Internal.

#include "shape/solid.hpp"

#include "shape/support.hpp"

namespace quoin::geometry {

/// What fixes the normal: the vertices within rounding of the support planes, and a face label
/// where all vertices of one are among them.
struct ContactSets {
  VertexSet p, q;
  int face_p = -1, face_q = -1;
  bool operator==(const ContactSets& other) const {
    return std::equal(p.begin(), p.end(), other.p.begin(), other.p.end()) &&
           std::equal(q.begin(), q.end(), other.q.begin(), other.q.end());
  }
};

/// Face label of which every vertex is in the set, or -1; the one that faces most along `outward`.
int covered_face(const Solid& polyhedron, const VertexSet& set, const Vector3& outward);

/// A face label that has all of the vertices (at least three), or -1.
int common_face(const Topology& topology, std::span<const int> vertices);

/// What the closed form of a pair of sets came to.
struct FeatureNormal {
  bool found = false;
  Vector3 normal = Vector3::UnitX();  ///< unit, from P to Q, within a few units in the last place
  bool joined = false;   ///< the shortest line between the two features lies within both
  bool crossed = false;  ///< two crossed edges that are joined, at `share` of the way along P's
  double share = 0.0;
  double from_ends = kInfinity;  ///< squared distance of the feet on edges from the ends, m2
  double across = 0.0;  ///< how far the shorter of two crossed edges reaches across the other, m
};

/// Vertices and edges: across the shortest line; a face, two crossed edges: their own plane.
/// `guess` tells the side. Not found where the sets are of no simple kind or the line has no
/// length.
FeatureNormal feature_normal(const Solid& p, const Solid& q, const ContactSets& sets,
                             const Vector3& guess, double rounding);

}  // namespace quoin::geometry
