#pragma once
/// A vector of three plain numbers, which stay in registers where Eigen would pack two of them.
/// Sums are (x + y) + z, as everywhere. Internal.

#include <quoin/geometry/types.hpp>

#include "numeric/floating_point.hpp"

namespace quoin::geometry {

struct Vec3 {
  double x, y, z;
  Vec3() {}  // NOLINT: filled later
  Vec3(double x_in, double y_in, double z_in) : x(x_in), y(y_in), z(z_in) {}
  Vec3(const Vector3& v) : x(v[0]), y(v[1]), z(v[2]) {}  // NOLINT: meant to convert
  operator Vector3() const { return {x, y, z}; }         // NOLINT: the same
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(double factor, const Vec3& a) {
  return {factor * a.x, factor * a.y, factor * a.z};
}
inline Vec3 operator/(const Vec3& a, double divisor) {
  return {a.x / divisor, a.y / divisor, a.z / divisor};
}
inline double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double square(const Vec3& a) { return dot(a, a); }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// In plain code: Eigen's product sums in an order, and with fused steps, that hang on the flags.
inline Vec3 product(const Matrix3& matrix, const Vec3& v) {
  const double* m = matrix.data();
  return {dot(Vec3(m[0], m[3], m[6]), v), dot(Vec3(m[1], m[4], m[7]), v),
          dot(Vec3(m[2], m[5], m[8]), v)};
}
/// One zero only: -0 would tell the ways to an answer apart.
inline Vec3 one_zero(const Vec3& a) { return a + Vec3(0.0, 0.0, 0.0); }
inline Vec3 either(bool first, const Vec3& a, const Vec3& b) {
  return {first ? a.x : b.x, first ? a.y : b.y, first ? a.z : b.z};
}

}  // namespace quoin::geometry
