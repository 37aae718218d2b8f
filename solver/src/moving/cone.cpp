#include "moving/cone.hpp"

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

}  // namespace

SmoothProjection project_smoothly(const Vector3& z, double smoothing) {
  const double tangential = z.tail<2>().norm();
  const double low = z[0] - tangential, high = z[0] + tangential;
  const auto [p_low, s_low] = smoothly_positive(low, smoothing);
  const auto [p_high, s_high] = smoothly_positive(high, smoothing);
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
