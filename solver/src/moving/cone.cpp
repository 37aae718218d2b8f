#include "moving/cone.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace quoin::solver {
namespace {

/// As a product of eigenvalues: the difference of squares cancels near the cone's boundary.
double determinant(const Vector3& x) {
  const double tangential = x.tail<2>().norm();
  return (x[0] - tangential) * (x[0] + tangential);
}

}  // namespace

Vector3 jordan_product(const Vector3& x, const Vector3& y) {
  Vector3 result;
  result << x.dot(y), x[0] * y.tail<2>() + y[0] * x.tail<2>();
  return result;
}

Vector3 jordan_quotient(const Vector3& r, const Vector3& x) {
  Vector3 result;
  result[0] = (x[0] * r[0] - x.tail<2>().dot(r.tail<2>())) / determinant(x);
  result.tail<2>() = (r.tail<2>() - result[0] * x.tail<2>()) / x[0];
  return result;
}

ConeScaling cone_scaling(const Vector3& x, const Vector3& y) {
  const double det_x = determinant(x), det_y = determinant(y);
  const Vector3 unit_x = x / std::sqrt(det_x);
  Vector3 mirrored = y / std::sqrt(det_y);
  const double gamma = std::sqrt(0.5 * (1.0 + unit_x.dot(mirrored)));
  mirrored.tail<2>() *= -1.0;
  const Vector3 w = (unit_x + mirrored) / (2.0 * gamma);
  const double size = std::pow(det_x / det_y, 0.25);
  const Eigen::Matrix2d inner =
      Eigen::Matrix2d::Identity() + w.tail<2>() * w.tail<2>().transpose() / (1.0 + w[0]);
  ConeScaling result;
  result.scale << w[0], w.tail<2>().transpose(), w.tail<2>(), inner;
  result.inverse << w[0], -w.tail<2>().transpose(), -w.tail<2>(), inner;
  result.squared = 2.0 * w * w.transpose();
  result.squared.diagonal() += Vector3(-1.0, 1.0, 1.0);
  result.scale *= size;
  result.inverse /= size;
  result.squared *= size * size;
  return result;
}

double share_in_cone(const Vector3& x, const Vector3& step) {
  const double a = determinant(step), c = determinant(x);
  const double b = x[0] * step[0] - x.tail<2>().dot(step.tail<2>());
  const double discriminant = b * b - a * c;
  if (discriminant < 0.0) return std::numeric_limits<double>::infinity();
  const double below = std::sqrt(discriminant) - b;
  return below > 0.0 ? c / below : std::numeric_limits<double>::infinity();
}

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
