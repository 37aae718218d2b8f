#pragma once
/// A vector of three plain numbers, which stay in registers where Eigen would pack two of them.
/// Sums are (x + y) + z, as everywhere. Private to the room.

#include <quoin/geometry/polyhedron.hpp>

#include "branchless.hpp"

namespace quoin::geometry {

struct Triple {
  double x, y, z;
  Triple() {}  // NOLINT: filled later
  Triple(double x_in, double y_in, double z_in) : x(x_in), y(y_in), z(z_in) {}
  Triple(const Vector3& v) : x(v[0]), y(v[1]), z(v[2]) {}  // NOLINT: meant to convert
  operator Vector3() const { return {x, y, z}; }           // NOLINT: the same
};

inline Triple operator+(const Triple& a, const Triple& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Triple operator-(const Triple& a, const Triple& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Triple operator-(const Triple& a) { return {-a.x, -a.y, -a.z}; }
inline Triple operator*(double factor, const Triple& a) {
  return {factor * a.x, factor * a.y, factor * a.z};
}
inline Triple operator/(const Triple& a, double divisor) {
  return {a.x / divisor, a.y / divisor, a.z / divisor};
}
inline double dot(const Triple& a, const Triple& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double square(const Triple& a) { return dot(a, a); }
inline Triple cross(const Triple& a, const Triple& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// One zero only: -0 would tell the ways to an answer apart.
inline Triple one_zero(const Triple& a) { return a + Triple(0.0, 0.0, 0.0); }
inline Triple either(bool first, const Triple& a, const Triple& b) {
  return {first ? a.x : b.x, first ? a.y : b.y, first ? a.z : b.z};
}

inline Triple place(const Polyhedron& polyhedron, int vertex) {
  const double* p = polyhedron.vertices().data() + 3 * vertex;
  return {p[0], p[1], p[2]};
}
inline Triple face_normal(const Polyhedron& polyhedron, int face) {
  const double* p = polyhedron.face_normals().data() + 3 * face;
  return {p[0], p[1], p[2]};
}

}  // namespace quoin::geometry
