#pragma once
/// How far a body may have come, for what was proved of it where it stood. Internal.

#include <cmath>
#include <quoin/geometry/body.hpp>

#include "numeric/error_bounds.hpp"

namespace quoin::geometry {

/// No point of a body comes farther from one placement to the other, m; nor does the largest
/// default tolerance grow by more than kTolerancePerMove of it. A point of the shape is origin + r
/// with |r| at most half the diameter: it moves by dt + dA origin + dA r.
inline double largest_move(const Shape& shape, const Placement& from, const Placement& to) {
  const double *a = from.linear.data(), *b = to.linear.data();
  const double *s = from.translation.data(), *t = to.translation.data();
  const Vector3& o = shape.origin();
  double turned = 0.0, moved = 0.0, terms = 0.0;  // squares; all that the moves are summed of
  for (int k = 0; k < 3; ++k) {
    const double x = b[k] - a[k], y = b[k + 3] - a[k + 3], z = b[k + 6] - a[k + 6];
    const double shift = t[k] - s[k], swing = x * o.x() + y * o.y() + z * o.z();
    turned += x * x + y * y + z * z;
    moved += (shift + swing) * (shift + swing);
    terms += std::abs(shift) + std::abs(x * o.x()) + std::abs(y * o.y()) + std::abs(z * o.z());
  }
  return std::sqrt(moved) + 0.5 * shape.diameter() * std::sqrt(turned) +
         kQueryRounding * kEpsilon * terms;
}

/// The same where each vertex of a shape has another place under the same placement. A point of the
/// hull is a mean of vertices, and so moves by no more than one of them.
inline double largest_move(const Shape& from, const Shape& to, const Placement& placement) {
  const double squared = (to.vertices() - from.vertices()).colwise().squaredNorm().maxCoeff();
  return std::sqrt(squared) * placement.linear.norm();
}

/// The sum of all moves of a body: `way` and one more, rounded up, and what the default tolerance
/// may grow meanwhile.
inline double longer_way(double way, double move) {
  return (way + (1.0 + kTolerancePerMove) * move) * (1.0 + 4 * kEpsilon);
}

}  // namespace quoin::geometry
