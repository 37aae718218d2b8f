#pragma once
/// The plane in which two solids meet, as one of them sees it. Internal.

#include "numeric/plane.hpp"
#include "shape/solid.hpp"

namespace quoin::geometry {

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

}  // namespace quoin::geometry
