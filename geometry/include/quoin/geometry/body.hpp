#pragma once
/// A shape and where it stands.

#include <quoin/geometry/polyhedron.hpp>

namespace quoin::geometry {

/// x = translation + linear X, from a shape's own frame (X) into the world (x). `linear` is a
/// rotation or, of a deforming block, R (I + eps); its determinant is positive.
struct Placement {
  Matrix3 linear = Matrix3::Identity();
  Vector3 translation = Vector3::Zero();  ///< m
};

/// The image of a shape's solid under the twelve numbers of a placement as given. It refers to the
/// shape, which must outlive it, and stores no vertices.
class Body {
 public:
  Body(const Polyhedron& shape) : shape_(&shape) {}  // NOLINT: a shape stands in its own frame
  Body(const Polyhedron& shape, const Placement& placement)
      : shape_(&shape), placement_(placement) {}

  const Polyhedron& shape() const { return *shape_; }
  const Placement& placement() const { return placement_; }
  /// Place of a vertex in the world, m.
  Vector3 vertex(int v) const {
    return placement_.translation + placement_.linear * shape_->vertex(v);
  }

 private:
  const Polyhedron* shape_;
  Placement placement_;
};

}  // namespace quoin::geometry
