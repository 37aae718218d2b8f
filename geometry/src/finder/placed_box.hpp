#pragma once
/// Placements as they come in: whether they are such, and the boxes of bodies in the world.

#include <cstring>
#include <quoin/geometry/body.hpp>
#include <quoin/geometry/build.hpp>
#include <string>

#include "numeric/numbers.hpp"

namespace quoin::geometry {

/// Throws InputError naming `body`, the number and the limit for a placement that is none.
void refuse_placement(const Placement& placement, int body);

/// Throws InputError naming `body` unless all twelve numbers are finite, none is larger than
/// kLargestCoordinate, and the determinant is positive.
inline void require_placement(const Placement& placement, int body) {
  const Matrix3& m = placement.linear;
  const double sum = m.cwiseAbs().sum() + placement.translation.cwiseAbs().sum();
  const double determinant = m.col(0).dot(m.col(1).cross(m.col(2)));
  if (!(sum <= kLargestCoordinate && determinant > 0.0)) refuse_placement(placement, body);
}

/// To the bit.
inline bool same_placement(const Placement& x, const Placement& y) {
  static_assert(sizeof(Placement) == 12 * sizeof(double));
  return std::memcmp(&x, &y, sizeof(Placement)) == 0;
}

/// Contains the body's solid in spite of rounding, m.
Box placed_box(const Shape& shape, const Placement& placement);

}  // namespace quoin::geometry
