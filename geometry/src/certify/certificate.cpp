#include "certify/certificate.hpp"

#include <algorithm>

#include "certify/feature_normal.hpp"
#include "numeric/error_bounds.hpp"

namespace quoin::geometry {

double default_tolerance(const Solid& a, const Solid& b) {
  return std::max(
      kDefaultTolerance * std::min(a.diameter(), b.diameter()),
      kLeastTolerance * kEpsilon * std::max(a.largest_coordinate(), b.largest_coordinate()));
}

double default_tolerance(const Shape& a, const Shape& b) {
  return default_tolerance(Solid(a), Solid(b));
}

double default_tolerance(const Body& a, const Body& b) {
  return default_tolerance(Solid(a, Vector3::Zero()), Solid(b, Vector3::Zero()));
}

Lengths lengths(const Solid& p, const Solid& q, double tolerance) {
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

bool carry_turned(const Solid& a, const Solid& b, const std::array<int, 2>& counts,
                  const Vector3& normal, double depth) {
  const PairSupport both = support_pair(a, b, normal);
  return count_beyond(a, normal, both.p.value - depth) == counts[0] &&
         count_beyond(b, -normal, both.q.value - depth) == counts[1];
}

bool corner_carrier(const Solid& polyhedron, std::span<const int> corners, Carrier& carrier) {
  const int u = corners[0], v = corners[1], w = corners[2];
  const int low = std::min(std::min(u, v), w), high = std::max(std::max(u, v), w);
  const int middle = u + v + w - low - high;
  carrier = {low == high ? FeatureKind::Vertex : FeatureKind::Edge, {low, high}, -1};
  if (low == middle || middle == high) return true;
  carrier = {FeatureKind::Face, {}, common_face(polyhedron.topology(), corners.first(3))};
  return carrier.face >= 0;
}

}  // namespace quoin::geometry
