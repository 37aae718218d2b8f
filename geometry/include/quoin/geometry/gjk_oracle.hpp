#pragma once
/// The questions of nearest_features put to libccd and FCL: an oracle of a target of its own,
/// quoin::gjk_oracle. It shares no code with the search and is never fed back into it.

#include <quoin/geometry/shape.hpp>

namespace quoin::geometry {

/// What a peer says of a pair. Only those members are set that it answers.
struct OracleAnswer {
  bool answered = false;              ///< false: it threw, failed, or the pair is not of its kind
  double gap = 0.0;                   ///< distance (> 0) or minus the depth, m
  Vector3 normal = Vector3::Zero();   ///< unit, from A to B (depth only)
  Vector3 point_a = Vector3::Zero();  ///< witness on A, m (distance only)
  Vector3 point_b = Vector3::Zero();  ///< witness on B, m (distance only)
};

/// Whether libccd's GJK finds the solids overlapping.
bool gjk_overlap(const Shape& a, const Shape& b);

/// Depth of an overlapping pair by libccd's GJK and EPA. tolerance: m, absolute.
OracleAnswer epa_depth(const Shape& a, const Shape& b, double tolerance = 1e-12);

/// Depth of an overlapping pair by libccd's Minkowski portal refinement (an upper bound of the
/// least translation, by its nature). tolerance: m, absolute.
OracleAnswer mpr_depth(const Shape& a, const Shape& b, double tolerance = 1e-12);

/// Distance of a separated pair by FCL's GJK over libccd's simplex. tolerance: m, absolute.
OracleAnswer gjk_distance(const Shape& a, const Shape& b, double tolerance = 1e-12);

}  // namespace quoin::geometry
