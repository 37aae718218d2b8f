#pragma once
/// The second-order cone of a contact, x_n >= |x_t|, and the projection on it.
///
/// Vectors are (n, t1, t2); eigenvalues x_n ∓ |x_t|.   [Fukushima, Luo & Tseng 2002]

#include <quoin/solver/scene.hpp>

namespace quoin::solver {

Vector3 project_on_cone(const Vector3& z);

/// The projection with max(l, 0) of eigenvalues replaced by (l + sqrt(l² + 4 e²))/2, and its
/// derivative; e may be zero.
struct SmoothProjection {
  Vector3 value;
  Matrix3 derivative;
};
SmoothProjection project_smoothly(const Vector3& z, double smoothing);

}  // namespace quoin::solver
