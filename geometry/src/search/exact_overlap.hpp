#pragma once
/// The least translation that parts two solids which share a point, decided in double-double; and
/// all directions in which it is as short. Internal.

#include "search/exact_search.hpp"

namespace quoin::geometry {

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
