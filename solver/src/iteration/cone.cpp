#include "iteration/cone.hpp"

#include <algorithm>
#include <cmath>

namespace quoin::solver {

namespace {

/// (l + sqrt(l² + 4e²))/2 and its derivative.
struct Positive {
  double value, slope;
};

Positive smoothly_positive(double l, double e) {
  const double root = e == 0.0 ? std::abs(l) : std::sqrt(l * l + 4.0 * e * e);
  if (root == 0.0) return {0.0, 0.5};
  // For l < 0 the sum cancels: its conjugate does not.
  const double value = l >= 0.0 ? 0.5 * (l + root) : 2.0 * e * e / (root - l);
  return {value, 0.5 * (1.0 + l / root)};
}

/// z / max(|z|, limit) times the limit: its derivatives by both.
struct SmoothDisc {
  Eigen::Vector2d value = Eigen::Vector2d::Zero(), by_limit = Eigen::Vector2d::Zero();
  Eigen::Matrix2d by_z = Eigen::Matrix2d::Zero();
};

SmoothDisc project_on_disc(const Eigen::Vector2d& z, double limit, double smoothing) {
  const double size = z.norm();
  const auto [beyond, slope] = smoothly_positive(size - limit, smoothing);
  const double larger = limit + beyond;
  if (!(larger > 0.0)) return {};
  const double share = limit / larger;
  SmoothDisc disc{share * z, (beyond + slope * limit) / (larger * larger) * z,
                  share * Eigen::Matrix2d::Identity()};
  if (size > 0.0) disc.by_z -= (share * slope / (larger * size)) * z * z.transpose();
  return disc;
}

/// Of all but the cone.
SmoothProjection project_by_parts(const Admissible& forces, const Vector3& z, double smoothing) {
  SmoothProjection result{z, Matrix3::Identity()};
  const auto [positive, slope] = smoothly_positive(z[0], smoothing);
  if (!forces.pulls) {
    result.value[0] = positive;
    result.derivative(0, 0) = slope;
  }
  if (forces.shear == Admissible::Shear::All) return result;
  const bool pulled = forces.pulls && forces.friction > 0.0;
  const Positive shear =
      pulled ? smoothly_positive(forces.friction * z[0] + forces.cohesion, smoothing)
             : Positive{forces.friction * positive + forces.cohesion, slope};
  const SmoothDisc disc = project_on_disc(z.tail<2>(), shear.value, smoothing);
  result.value.tail<2>() = disc.value;
  result.derivative.bottomRightCorner<2, 2>() = disc.by_z;
  result.derivative.bottomLeftCorner<2, 1>() = forces.friction * shear.slope * disc.by_limit;
  return result;
}

SmoothProjection project_on_cone(const Vector3& z, double smoothing) {
  const double tangential = std::sqrt(z[1] * z[1] + z[2] * z[2]);
  const auto [p_low, s_low] = smoothly_positive(z[0] - tangential, smoothing);
  const auto [p_high, s_high] = smoothly_positive(z[0] + tangential, smoothing);
  const double t1 = tangential > 0.0 ? z[1] / tangential : 1.0;
  const double t2 = tangential > 0.0 ? z[2] / tangential : 0.0;
  const double mean = 0.5 * (s_low + s_high), half = 0.5 * (s_high - s_low);
  const double size = std::max(std::abs(z[0]), smoothing);
  const double across = tangential > 1e-8 * size ? (p_high - p_low) / (2.0 * tangential) : mean;
  const double turn = mean - across, shear = 0.5 * (p_high - p_low);
  SmoothProjection result;
  result.value << 0.5 * (p_low + p_high), shear * t1, shear * t2;
  result.derivative << mean, half * t1, half * t2,         //
      half * t1, across + turn * t1 * t1, turn * t1 * t2,  //
      half * t2, turn * t2 * t1, across + turn * t2 * t2;
  return result;
}

}  // namespace

Vector3 project_by_parts(const Admissible& forces, const Vector3& z) {
  Vector3 force = z;
  if (!forces.pulls) force[0] = std::max(z[0], 0.0);
  const double limit = forces.shear_limit(force[0]), tangential = z.tail<2>().norm();
  if (forces.shear == Admissible::Shear::Disc && tangential > limit)
    force.tail<2>() *= limit / tangential;
  return force;
}

SmoothProjection project_smoothly(const Admissible& forces, const Vector3& z, double smoothing) {
  return forces.shear == Admissible::Shear::Cone ? project_on_cone(z, smoothing)
                                                 : project_by_parts(forces, z, smoothing);
}

}  // namespace quoin::solver
