#pragma once
/// The plane in which two solids meet. Internal.

#include "shape/solid.hpp"

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

/// A contact plane in the frame of a shape: what its vertices less a base are laid into.
struct LocalPlane {
  Vec3 base, axis_u, axis_v, normal;
  double shift_u, shift_v, shift_height;  ///< of the base, m
  LocalPlane(const Solid& solid, const ContactPlane& plane)
      : base(solid.body() != nullptr ? solid.shape().origin() : plane.origin),
        axis_u(solid.turned_back(plane.axis_u)),
        axis_v(solid.turned_back(plane.axis_v)),
        normal(solid.turned_back(plane.normal)) {
    const Vec3 from(solid.body() != nullptr ? Vector3(solid.origin() - plane.origin)
                                            : Vector3(Vector3::Zero()));
    shift_u = dot(plane.axis_u, from);
    shift_v = dot(plane.axis_v, from);
    shift_height = dot(plane.normal, from);
  }
  Vector2 place(const Vec3& vertex) const {
    const Vec3 offset = vertex - base;
    return {dot(axis_u, offset) + shift_u, dot(axis_v, offset) + shift_v};
  }
  double height(const Vec3& vertex) const { return dot(normal, vertex - base) + shift_height; }
};

/// Twice the area of the triangle (0, a, b), positive where b lies to the left of a.
inline double cross2(const Vector2& a, const Vector2& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace quoin::geometry
