#pragma once
/// The search in double-double: slow, and right where doubles cannot decide. Internal.

#include "numeric/double_double.hpp"
#include "shape/support.hpp"

namespace quoin::geometry {

/// The corners q_j - p_i that carry an optimum, at most four, and the unit normal from P to Q that
/// they define.
struct ActiveFeatures {
  std::array<int, 4> p{}, q{};
  int corners = 0;
  Vector3 normal = Vector3::UnitX();
  double gap = 0.0;  ///< m
  int iterations = 0;
  bool converged = false;
  bool overlapping = false;  ///< the solids share a point, within rounding
};

/// The vertex farthest along a direction.
int wide_support(const Solid& polyhedron, const WideVector& direction);

/// Iterative nearest-feature search of two separated solids. Returns `overlapping`, with the
/// corners around the shared point, when they are not separated by more than the rounding of
/// double-double.
/// `start`: corners to start from; none: those that look at the other solid.
ActiveFeatures exact_nearest(const Solid& p, const Solid& q, const ActiveFeatures& start,
                             int max_iterations);

}  // namespace quoin::geometry
