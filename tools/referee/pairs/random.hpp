#pragma once
/// Random numbers that are the same on every machine: std::mt19937_64 and our own distributions.

#include <cmath>
#include <cstdint>
#include <quoin/geometry/types.hpp>
#include <random>

namespace quoin::referee {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  std::uint64_t bits() { return engine_(); }

  /// In [low, high).
  double uniform(double low = 0.0, double high = 1.0) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }

  /// In [low, high], both possible.
  int integer(int low, int high) {
    const auto count = static_cast<std::uint64_t>(high - low) + 1;
    return low + static_cast<int>(engine_() % count);
  }

  /// Between low and high, evenly in the logarithm.
  double log_uniform(double low, double high) {
    return std::exp(uniform(std::log(low), std::log(high)));
  }

  bool chance(double probability) { return uniform() < probability; }

  /// Evenly on the unit sphere.
  geometry::Vector3 direction() {
    for (;;) {
      const geometry::Vector3 point(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
      const double length = point.norm();
      if (length > 0.1 && length <= 1.0) return point / length;
    }
  }

  /// Evenly in [low, high)^3.
  geometry::Vector3 point(double low, double high) {
    const double x = uniform(low, high), y = uniform(low, high), z = uniform(low, high);
    return {x, y, z};
  }

  /// Evenly over all rotations (a unit quaternion turned into a matrix).
  geometry::Matrix3 rotation() {
    double q[4], length = 0.0;
    do {
      length = 0.0;
      for (double& c : q) {
        c = uniform(-1, 1);
        length += c * c;
      }
    } while (length > 1.0 || length < 0.01);
    for (double& c : q) c /= std::sqrt(length);
    const auto [w, x, y, z] = q;
    geometry::Matrix3 r;
    r << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),   //
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
    return r;
  }

 private:
  std::mt19937_64 engine_;
};

/// Rotation by `angle` (rad) about a unit axis.
inline geometry::Matrix3 rotation_about(const geometry::Vector3& axis, double angle) {
  geometry::Matrix3 cross;
  cross << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  const double half = std::sin(0.5 * angle);
  return geometry::Matrix3::Identity() + std::sin(angle) * cross + 2 * half * half * cross * cross;
}

}  // namespace quoin::referee
