#pragma once
/// A shape cut in two by a plane.

#include <optional>
#include <quoin/geometry/shape.hpp>

namespace quoin::geometry {

/// All x with normal · (x − point) = 0, in the shape's own frame. Above is where the normal points.
struct Plane {
  Vector3 point = Vector3::Zero();    ///< m
  Vector3 normal = Vector3::UnitZ();  ///< not zero; need not be a unit vector
};

struct SplitPart {
  Shape shape;
  std::vector<int> old_faces;  ///< of each face of the part: the face of the old shape that it is a
                               ///< part of, -1: it lies in the plane
};

/// No part on a side where the shape has nothing thicker than its label length.
struct Split {
  std::optional<SplitPart> below, above;
};

/// Cuts a shape by a plane, in its own frame. A place where the plane crosses an edge is computed
/// once: both parts have the same doubles there, and so have two shapes that share the edge's ends.
/// Vertices within rounding of the plane lie on it. The volumes of the parts sum to the shape's
/// within 1e-12 of it, and the surface times the rounding of coordinates (16 eps of the largest)
/// and what labels are off their planes. Where a part would be thinner than make_shape() takes, the
/// other part is the whole shape, unchanged. Linear in the vertices but for sorting the cut edges.
/// Throws InputError for a plane that is not finite or a normal of zero.
Split split(const Shape& shape, const Plane& plane);

}  // namespace quoin::geometry
