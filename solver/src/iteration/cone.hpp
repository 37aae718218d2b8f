#pragma once
/// Forces that a contact can bear, and the projection on them.
///
/// Vectors are (n, t1, t2), compression positive.

#include <algorithm>
#include <quoin/solver/scene.hpp>

namespace quoin::solver {

/// Coulomb's law without cohesion, in units in which friction is one, is the second-order cone
/// x_n >= |x_t|. Other contacts have a range of x_n, and a limit of |x_t| that goes with it.
struct Admissible {
  enum class Shear : char {
    Cone,
    Disc,  ///< |x_t| <= friction x_n + cohesion, or 0
    All    ///< no limit
  };
  Shear shear = Shear::Cone;
  bool pulls = false;  ///< x_n of any sign, as of a bond; else x_n >= 0
  double friction = 0.0, cohesion = 0.0;

  double shear_limit(double normal_force) const {
    return std::max(friction * (pulls ? normal_force : std::max(normal_force, 0.0)) + cohesion,
                    0.0);
  }
};

/// y of a contact's force x and its motion u: x is the projection of x - y. By the cone friction
/// would go with its normal, and lift what slides. [De Saxcé & Feng 1998]
inline Vector3 corrected(const Admissible& forces, const Vector3& u) {
  const double slip = forces.shear == Admissible::Shear::Cone ? u.tail<2>().norm() : 0.0;
  return {u[0] + slip, u[1], u[2]};
}

inline Vector3 project_on(const Admissible& forces, const Vector3& z) {
  const double tangential = z.tail<2>().norm();
  if (forces.shear != Admissible::Shear::Cone) {
    Vector3 force = z;
    if (!forces.pulls) force[0] = std::max(z[0], 0.0);
    const double limit = forces.shear_limit(force[0]);
    if (forces.shear == Admissible::Shear::Disc && tangential > limit)
      force.tail<2>() *= limit / tangential;
    return force;
  }
  if (z[0] >= tangential) return z;
  if (z[0] <= -tangential) return Vector3::Zero();
  const double size = 0.5 * (z[0] + tangential), along = size / tangential;
  return {size, along * z[1], along * z[2]};
}

/// The projection with each max(l, 0) replaced by (l + sqrt(l² + 4 e²))/2, and its derivative; e
/// may be zero. Of the cone these are its eigenvalues x_n ∓ |x_t| [Fukushima, Luo & Tseng 2002].
struct SmoothProjection {
  Vector3 value;
  Matrix3 derivative;
};
SmoothProjection project_smoothly(const Admissible& forces, const Vector3& z, double smoothing);

}  // namespace quoin::solver
