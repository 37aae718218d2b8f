#pragma once
/// A plane in space, places in it, and their convex hull. Internal.

#include <quoin/geometry/types.hpp>
#include <span>

#include "numeric/small_vector.hpp"

namespace quoin::geometry {

using Vector2 = Eigen::Vector2d;

/// The plane in which patches of P and Q are compared, `normal` from P to Q and the origin at a
/// vertex of P, or the plane of a face.
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

/// Twice the area of the triangle (0, a, b), positive where b lies to the left of a.
inline double cross2(const Vector2& a, const Vector2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Indices of the convex hull of places, counter-clockwise (monotone chain, [Andrew 1979]).
void hull_order(std::span<const Vector2> places, SmallVector<int, 32>& order);

}  // namespace quoin::geometry
