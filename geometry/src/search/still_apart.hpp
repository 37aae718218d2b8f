#pragma once
/// Last step's plane once more, for pairs that need nothing but to be known as apart. Internal.

#include "numeric/error_bounds.hpp"
#include "shape/support.hpp"

namespace quoin::geometry {

/// How much farther than `gap` the plane of a unit normal keeps two bodies apart, at least, m; not
/// positive: it may not. One scan of either; differences, offsets and sums have less than 32
/// roundings of the lengths in `size`.
inline double apart_beyond(const Body& a, const Body& b, const Vector3& normal, double gap) {
  const Vec3 between = Vec3(b.placement().translation) - Vec3(a.placement().translation);
  const Vec3 origins = Vec3(b.turned_origin()) - Vec3(a.turned_origin());
  const Solid solid_a(a, Vector3::Zero()), solid_b(b, Vector3::Zero());
  const PairSupport reach = support_pair(solid_a, solid_b, normal);
  const auto size_of = [](const Vec3& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); };
  const double size = size_of(between) + size_of(a.turned_origin()) + size_of(b.turned_origin()) +
                      solid_a.diameter() + solid_b.diameter() + gap;
  return dot(between + origins, normal) - reach.p.value - reach.q.value -
         (gap + kQueryRounding * kEpsilon * size);
}

}  // namespace quoin::geometry
