#include "moving/cone.hpp"

#include <algorithm>
#include <cmath>

namespace quoin::solver {

Vector3 project_on_cone(const Vector3& z) {
  const double tangential = z.tail<2>().norm();
  if (z[0] >= tangential) return z;
  if (z[0] <= -tangential) return Vector3::Zero();
  const double size = 0.5 * (z[0] + tangential);
  Vector3 result;
  result << size, size / tangential * z.tail<2>();
  return result;
}

SmoothProjection project_smoothly(const Vector3& z, double smoothing) {
  const double tangential = z.tail<2>().norm();
  const double low = z[0] - tangential, high = z[0] + tangential;
  const auto value = [smoothing](double l) {
    const double root = std::hypot(l, 2.0 * smoothing);
    // For l < 0 the sum cancels: its conjugate does not.
    return l >= 0.0 ? 0.5 * (l + root) : 2.0 * smoothing * smoothing / (root - l);
  };
  const auto slope = [smoothing](double l) {
    const double root = std::hypot(l, 2.0 * smoothing);
    return root > 0.0 ? 0.5 * (1.0 + l / root) : 0.5;
  };
  const double p_low = value(low), p_high = value(high), s_low = slope(low), s_high = slope(high);
  Eigen::Vector2d along(1.0, 0.0);
  if (tangential > 0.0) along = z.tail<2>() / tangential;
  const double mean = 0.5 * (s_low + s_high), half = 0.5 * (s_high - s_low);
  const double size = std::max(std::abs(z[0]), smoothing);
  const double across = tangential > 1e-8 * size ? (p_high - p_low) / (2.0 * tangential) : mean;
  SmoothProjection result;
  result.value << 0.5 * (p_low + p_high), 0.5 * (p_high - p_low) * along;
  result.derivative << mean, half * along.transpose(), half * along,
      across * Eigen::Matrix2d::Identity() + (mean - across) * along * along.transpose();
  return result;
}

}  // namespace quoin::solver
