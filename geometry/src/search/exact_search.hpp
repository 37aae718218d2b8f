#pragma once
/// The search in double-double: slow, and right where doubles cannot decide. Internal.

#include "numeric/double_double.hpp"
#include "shape/support.hpp"

namespace quoin::geometry {

/// The features that carry an optimum: up to three vertices of P and of Q (together at most four),
/// and the unit normal from P to Q that they define.
struct ActiveFeatures {
  std::array<int, 3> p{}, q{};
  int p_count = 0, q_count = 0;
  Vector3 normal = Vector3::UnitX();
  double gap = 0.0;  ///< m
  int iterations = 0;
  bool converged = false;
  bool overlapping = false;  ///< found by least overlap (then gap <= 0 up to rounding)
  bool several = false;      ///< other directions have the same overlap
  bool middle = false;       ///< touching: the normal is the mean of the planes between them
};

/// Iterative nearest-feature search of two separated solids. Returns `overlapping` with nothing
/// else set when they are not separated by more than the rounding of double-double.
ActiveFeatures exact_nearest(const Solid& p, const Solid& q, int max_iterations);

/// The same among given vertices only, from the first of each. Sets must not be empty.
ActiveFeatures exact_nearest_among(const Solid& p, const Solid& q, const VertexSet& set_p,
                                   const VertexSet& set_q);

/// Least overlap by trying every face and every pair of edges of the exact hulls. Allocates.
ActiveFeatures exhaustive_overlap(const Solid& p, const Solid& q);

}  // namespace quoin::geometry
