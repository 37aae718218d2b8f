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

struct LeastOverlap {
  Vector3 normal = Vector3::UnitX();  ///< unit, from P to Q
  double gap = 0.0;                   ///< minus the least translation, m
  bool converged = false;             ///< proved; else the best that was found
  int directions = 0;                 ///< of different planes that have the same overlap
  bool middle = false;  ///< touching: the normal is the mean of the planes between them
  int iterations = 0;
};

/// `start`: where the search found that the solids share a point. Allocates nothing; about 447 kB
/// of stack. Method: geometry/README.md, "Least overlap, exactly".
LeastOverlap exact_overlap(const Solid& p, const Solid& q, const ActiveFeatures& start);

}  // namespace quoin::geometry
