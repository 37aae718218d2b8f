#pragma once
/// Forces that a contact can bear, and the projection on them.
///
/// Vectors are (n, t1, t2), compression positive.

#include <algorithm>
#include <cmath>
#include <limits>
#include <quoin/solver/scene.hpp>

#include "base/matrix_values.hpp"

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

/// Of all but the cone.
Vector3 project_by_parts(const Admissible& forces, const Vector3& z);

inline Vector3 project_on(const Admissible& forces, const Vector3& z) {
  if (forces.shear != Admissible::Shear::Cone) return project_by_parts(forces, z);
  const double tangential = z.tail<2>().norm();
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

// The Jordan algebra of the second-order cone x_n >= |x_t|, and Nesterov and Todd's scaling of
// interior point methods on it.   [Vandenberghe 2010, section 4]

/// x_n² - |x_t|², positive inside.
inline double determinant(const Vector3& x) {
  const double tangential = x.tail<2>().norm();
  return (x[0] - tangential) * (x[0] + tangential);
}

/// x o y
inline Vector3 product(const Vector3& x, const Vector3& y) {
  Vector3 result = x[0] * y + y[0] * x;
  result[0] = x.dot(y);
  return result;
}

/// u with l o u = r.
inline Vector3 quotient(const Vector3& l, const Vector3& r) {
  Vector3 u;
  u[0] = (l[0] * r[0] - l.tail<2>().dot(r.tail<2>())) / determinant(l);
  u.tail<2>() = (r.tail<2>() - u[0] * l.tail<2>()) / l[0];
  return u;
}

/// Likewise of numbers, in place of cones.
inline double product(double x, double y) { return x * y; }
inline double quotient(double l, double r) { return r / l; }

/// Longest alpha with x + alpha d in the cone; infinite: all are.
inline double longest(const Vector3& x, const Vector3& d) {
  const double a = determinant(d), b = x[0] * d[0] - x.tail<2>().dot(d.tail<2>());
  const double c = determinant(x), root = b * b - a * c;
  double alpha = d[0] < 0.0 ? -x[0] / d[0] : std::numeric_limits<double>::infinity();
  if (!(root >= 0.0)) return alpha;
  const double q = -(b + std::copysign(std::sqrt(root), b));
  for (const double t : {q / a, c / q})
    if (t > 0.0) alpha = std::min(alpha, t);  // not of NaN
  return alpha;
}

/// Likewise with v not negative.
inline double longest(double v, double d) {
  return d < 0.0 ? -v / d : std::numeric_limits<double>::infinity();
}

/// W, symmetric, with W z = W⁻¹ s for s and z inside.
struct ConeScaling {
  double eta = 1.0;
  Vector3 w = Vector3::UnitX();
};

inline ConeScaling cone_scaling(const Vector3& s, const Vector3& z) {
  constexpr double kInside = 1e-300;  // of what rounding has put on the rim
  const double det_s = std::sqrt(std::max(determinant(s), kInside));
  const double det_z = std::sqrt(std::max(determinant(z), kInside));
  const Vector3 s1 = s / det_s, z1 = z / det_z;
  const double gamma = std::sqrt(0.5 * (1.0 + s1.dot(z1)));
  return {std::sqrt(det_s / det_z), (s1 + Vector3(z1[0], -z1[1], -z1[2])) / (2.0 * gamma)};
}

/// W v, or W⁻¹ v where `sign` is negative.
inline Vector3 scaled(const ConeScaling& scaling, const Vector3& v, double sign) {
  const Vector3& w = scaling.w;
  const double along = w.tail<2>().dot(v.tail<2>());
  Vector3 result;
  result[0] = w[0] * v[0] + sign * along;
  result.tail<2>() = v.tail<2>() + (sign * v[0] + along / (1.0 + w[0])) * w.tail<2>();
  return sign > 0.0 ? Vector3(scaling.eta * result) : Vector3(result / scaling.eta);
}

/// W W v, or W⁻¹ W⁻¹ v.
inline Vector3 scaled_twice(const ConeScaling& scaling, const Vector3& v, double sign) {
  Vector3 w = scaling.w;
  w.tail<2>() *= sign;
  const double along = 2.0 * w.dot(v);
  const Vector3 result(along * w[0] - v[0], along * w[1] + v[1], along * w[2] + v[2]);
  const double squared = scaling.eta * scaling.eta;
  return sign > 0.0 ? Vector3(squared * result) : Vector3(result / squared);
}

/// Likewise of numbers, where W is `w[0]`.
inline double scaled(const ConeScaling& scaling, double v, double sign) {
  return sign > 0.0 ? v * scaling.w[0] : v / scaling.w[0];
}
inline double scaled_twice(const ConeScaling& scaling, double v, double sign) {
  const double squared = scaling.w[0] * scaling.w[0];
  return sign > 0.0 ? v * squared : v / squared;
}

/// W, or W⁻¹.
inline Matrix3 matrix(const ConeScaling& scaling, double sign) {
  Matrix3 result;
  for (int i = 0; i < 3; ++i) result.col(i) = scaled(scaling, Vector3::Unit(i), sign);
  return result;
}

}  // namespace quoin::solver
