#pragma once
/// The plane in which two solids meet. Internal.

#include <quoin/geometry/types.hpp>

namespace quoin::geometry {

using Vector2 = Eigen::Vector2d;

/// The plane in which patches of P and Q are compared: `normal` from P to Q, origin at a vertex of
/// P.
struct ContactPlane {
  Vector3 origin, normal, axis_u, axis_v;
  ContactPlane() {}  // NOLINT: filled later
  ContactPlane(const Vector3& origin_in, const Vector3& normal_in);
  Vector2 place(const Vector3& x) const {
    const Vector3 step = x - origin;
    return {axis_u.dot(step), axis_v.dot(step)};
  }
  double height(const Vector3& x) const { return normal.dot(x - origin); }
  Vector3 point(const Vector2& place, double height) const {
    return origin + axis_u * place.x() + axis_v * place.y() + normal * height;
  }
};

}  // namespace quoin::geometry
