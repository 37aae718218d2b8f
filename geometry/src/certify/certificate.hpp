#pragma once
/// The ordinary answers: solids apart that meet in a vertex and a vertex, an edge or a face, or in
/// two crossed edges, and overlaps whose least translation is across a vertex and a face or two
/// crossed edges, all beyond doubt. Straight code for each; whatever is left open here goes the
/// general way and comes to the same bits there. The lengths below which there is doubt. Internal.

#include <algorithm>
#include <cmath>
#include <quoin/geometry/nearest_features.hpp>

#include "certify/feature_normal.hpp"
#include "numeric/error_bounds.hpp"
#include "shape/solid.hpp"

namespace quoin::geometry {

/// Lengths that decide, m.
struct Lengths {
  double contact = 0.0;   // the tolerance of features and status
  double rounding = 0.0;  // what the support functions and normals of doubles may be off
  double place = 0.0;     // what the rounding of coordinates leaves of a place in the world
  double widest = 0.0;    // vertices deeper than this below the support plane are of no interest
  bool uneven = false;    // the rounding of the larger solid would show on the smaller one
};

/// Of two faces most often all other vertices lie so far below (of the smaller diameter): what the
/// contact points will ask for. Only speed hangs on it.
constexpr double kFarBelow = 1.0 / 16;

inline double default_tolerance(const Solid& a, const Solid& b) {
  return std::max(
      kDefaultTolerance * std::min(a.diameter(), b.diameter()),
      kLeastTolerance * kEpsilon * std::max(a.largest_coordinate(), b.largest_coordinate()));
}

/// Inline: of shapes in their own frames nothing is asked of bodies.
inline Lengths lengths(const Solid& p, const Solid& q, double tolerance) {
  Lengths length;
  length.contact = tolerance > 0.0 ? tolerance : default_tolerance(p, q);
  const double larger = std::max(p.diameter(), q.diameter());
  length.rounding = kRounding * kEpsilon * larger;
  length.uneven = larger > kUneven * std::min(p.diameter(), q.diameter());
  const double coordinate = std::max(p.largest_coordinate(), q.largest_coordinate());
  length.place = std::max(length.rounding, kPlaceRounding * kEpsilon * coordinate);
  length.widest = std::max({length.contact, length.place, kClearAbove * length.rounding});
  return length;
}

/// What may carry the plane on one side: a vertex, the two ends of an edge (ascending), or a face.
struct Carrier {
  FeatureKind kind = FeatureKind::Vertex;
  std::array<int, 2> vertices{};
  int face = -1;
};

/// What is known beforehand of solids that overlap.
struct Overlap {
  Vector3 normal;      // of the plane that is to be the answer, within rounding
  double least = 0.0;  // a gap above this is proved to be the answer, m
};

/// Touching: within the tolerance of contact.
inline PairStatus status_of(double gap, double tolerance) {
  if (std::abs(gap) <= tolerance) return PairStatus::Touching;
  return gap > 0.0 ? PairStatus::Separated : PairStatus::Overlapping;
}

/// Nearer than that several planes may be as good.
inline bool clearly_apart(double gap, double rounding) { return gap > kApart * rounding; }

/// Rounding times the larger diameter, m2: a line turned by the one lifts what lies the other away
/// by this over its own length.
inline double turning(double rounding) { return rounding * (rounding / (kRounding * kEpsilon)); }

/// A plane that rounding may turn: by how much it lifts a vertex, and the tolerance of features, m.
struct Turned {
  double lift, contact;
};

/// Do no more vertices than these lie within what a turn lifts of the support planes, and none so
/// near to the tolerance below them? Otherwise another one may carry a plane as good, or count as
/// near or not, but for rounding.
bool carry_turned(const Solid& a, const Solid& b, const std::array<int, 2>& counts,
                  const Vector3& normal, const Turned& turned);

/// How far inside the border of a facet the foot of the origin must lie (m), so that no other plane
/// is better than an overlap of -gap along its normal: the known inner point (the difference of the
/// vertex means) must lie deep enough. Infinite: no way is enough. See geometry/README.md, "Shallow
/// overlap".
inline double shallow_margin(const Vec3& inner, const Vec3& normal, double gap, double rounding) {
  const double depth =
      -gap * (1.0 + kAloneShare) + kAlone * rounding;  // by so much the only one, too
  const double down = dot(inner, normal), below = down - depth;
  if (!(below > 0.0)) return kInfinity;
  const Vec3 beside = inner - down * normal;
  const double aside = square(beside);
  return depth * (std::sqrt(aside) + std::sqrt(aside + below * (down + depth))) / below;
}

/// Proves for an overlap that no other plane is better. `margin()`: how far inside, m.
template <class Margin>
bool proves_shallow(const Solid& p, const Solid& q, const Vector3& normal, double gap,
                    double rounding, const Margin& margin) {
  const Vec3 inner = Vec3(q.vertex_mean()) - Vec3(p.vertex_mean());
  const double needed = shallow_margin(inner, normal, gap, rounding);
  return needed < kInfinity && margin() >= needed;
}

/// The same of two faces that share a polygon wider than the tolerance, or that they are apart.
template <class Margin>
bool proves_faces(const Solid& p, const Solid& q, const Vector3& normal, double gap,
                  double rounding, const Margin& margin) {
  if (clearly_apart(gap, rounding)) return margin() >= rounding;
  return proves_shallow(p, q, normal, gap, rounding, margin);
}

enum class Trial {
  Proved,    ///< the answer is complete
  Refuted,   ///< the carriers do not carry the plane alone, or do not show that it is the best
  Undecided  ///< not ordinary, or too close to call
};

/// Tries two carriers; fills all of the answer but `iterations`. `overlap`: what a search has
/// shown of it; null for solids apart and shallow overlaps. Swapping A and B changes no bit.
Trial certify(const Solid& a, const Solid& b, const Carrier& by_a, const Carrier& by_b,
              const Lengths& length, const Overlap* overlap, NearestFeatures& answer);

/// The same with what a hint names.
Trial certify_hint(const Solid& a, const Solid& b, const FeatureHint& hint, const Lengths& length,
                   NearestFeatures& answer);

/// The carrier of the first three corners where the search ended; false: none of the three kinds.
inline bool corner_carrier(const Solid& polyhedron, std::span<const int> corners,
                           Carrier& carrier) {
  const int u = corners[0], v = corners[1], w = corners[2];
  const int low = std::min(std::min(u, v), w), high = std::max(std::max(u, v), w);
  const int middle = u + v + w - low - high;
  carrier = {low == high ? FeatureKind::Vertex : FeatureKind::Edge, {low, high}, -1};
  if (low == middle || middle == high) return true;
  carrier = {FeatureKind::Face, {}, common_face(polyhedron.topology(), corners.first(3))};
  return carrier.face >= 0;
}

/// The carrier that a hint names for one solid; false: none of the three kinds. Without branches on
/// what differs from pair to pair.
inline bool hinted_carrier(const Shape& shape, const std::array<int, 4>& vertices, int face,
                           Carrier& carrier) {
  const auto below = [](int k, int count) {
    return static_cast<int>(static_cast<unsigned>(k) < static_cast<unsigned>(count));
  };
  const int count = shape.vertex_count(), v = vertices[0], w = vertices[1];
  const int has_face = below(face, shape.topology().face_count());
  const int more = static_cast<int>(w > v);
  carrier.kind = static_cast<FeatureKind>(2 * has_face | (more & ~has_face));
  carrier.vertices = {v, w};
  carrier.face = face;
  const int few = static_cast<int>(vertices[2] < 0) & static_cast<int>(w < count);
  return (below(v, count) & (has_face | few)) != 0;
}

}  // namespace quoin::geometry
