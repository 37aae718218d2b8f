#pragma once
/// The second-order cone of a contact, x_n >= |x_t|, its Jordan algebra, scaling and projection.
///
/// Vectors are (n, t1, t2). x ∘ y = (x·y, x_n y_t + y_n x_t); eigenvalues x_n ∓ |x_t|.
/// Sources: [Alizadeh & Goldfarb 2003] for the algebra; [Nesterov & Todd 1997] for the scaling;
/// [Fukushima, Luo & Tseng 2002] for the projection and its smoothing.

#include <quoin/solver/scene.hpp>

namespace quoin::solver {

Vector3 jordan_product(const Vector3& x, const Vector3& y);

/// z with x ∘ z = r; x inside the cone.
Vector3 jordan_quotient(const Vector3& r, const Vector3& x);

/// The scaling W of two points inside the cone: W y = W⁻¹ x.
struct ConeScaling {
  Matrix3 scale, inverse, squared;  ///< W, W⁻¹, W²
};
ConeScaling cone_scaling(const Vector3& x, const Vector3& y);

/// Largest share a >= 0 with x + a step in the cone; x inside. Infinite where the cone is never
/// left.
double share_in_cone(const Vector3& x, const Vector3& step);

Vector3 project_on_cone(const Vector3& z);

/// The projection with max(l, 0) of eigenvalues replaced by (l + sqrt(l² + 4 e²))/2, and its
/// derivative.
struct SmoothProjection {
  Vector3 value;
  Matrix3 derivative;
};
SmoothProjection project_smoothly(const Vector3& z, double smoothing);

}  // namespace quoin::solver
