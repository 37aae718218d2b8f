#pragma once
/// Volume, centroid and second moments of a polyhedron, exact by simplex integration.

#include <quoin/geometry/body.hpp>

namespace quoin::geometry {

struct MassProperties {
  double volume = 0.0;                      ///< m3
  Vector3 centroid = Vector3::Zero();       ///< m
  Matrix3 second_moment = Matrix3::Zero();  ///< integral (x-c)(x-c)^T dV about the centroid, m5
};

MassProperties mass_properties(const Shape& polyhedron);
MassProperties mass_properties(const Body& body);  ///< in the world

}  // namespace quoin::geometry
