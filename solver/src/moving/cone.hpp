#pragma once
/// The second-order cone of a contact, x_n >= |x_t|, and the projection on it.
///
/// Vectors are (n, t1, t2); eigenvalues x_n ∓ |x_t|.   [Fukushima, Luo & Tseng 2002]

#include <quoin/solver/scene.hpp>

namespace quoin::solver {

inline Vector3 project_on_cone(const Vector3& z) {
  const double tangential = z.tail<2>().norm();
  if (z[0] >= tangential) return z;
  if (z[0] <= -tangential) return Vector3::Zero();
  const double size = 0.5 * (z[0] + tangential), along = size / tangential;
  return {size, along * z[1], along * z[2]};
}

/// The projection with max(l, 0) of eigenvalues replaced by (l + sqrt(l² + 4 e²))/2, and its
/// derivative; e may be zero.
struct SmoothProjection {
  Vector3 value;
  Matrix3 derivative;
};
SmoothProjection project_smoothly(const Vector3& z, double smoothing);

}  // namespace quoin::solver
