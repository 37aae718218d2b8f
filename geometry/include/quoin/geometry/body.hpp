#pragma once
/// A shape and where it stands.

#include <quoin/geometry/shape.hpp>

namespace quoin::geometry {

/// x = translation + linear X, from a shape's own frame (X) into the world (x). `linear` is a
/// rotation or, of a deforming block, R (I + eps); its determinant is positive.
struct Placement {
  Matrix3 linear = Matrix3::Identity();
  Vector3 translation = Vector3::Zero();  ///< m
};

/// The image of a shape's solid under the twelve numbers of a placement as given. It refers to the
/// shape, which must outlive it, and stores no vertices: moving it writes these numbers and what
/// follows from them. The shape's vertices must not be set anew while a body refers to it.
class Body {
 public:
  Body(const Shape& shape);  // NOLINT: a shape stands in its own frame
  Body(const Shape& shape, const Placement& placement);

  void move(const Placement& placement);

  const Shape& shape() const { return *shape_; }
  const Placement& placement() const { return placement_; }
  /// Place of a vertex in the world, rounded, m.
  Vector3 vertex(int v) const {
    return placement_.translation + placement_.linear * shape_->vertex(v);
  }
  Points vertices() const;  ///< of all, 3 × vertex_count, m
  Box box() const;          ///< of these places

  /// Image of the shape's origin(), rounded, m.
  Vector3 centre() const { return placement_.translation + turned_origin_; }
  /// linear · origin() as an unevaluated sum, m. With the translation apart from it, the way from
  /// one centre to another is right to its own last place and the same wherever the bodies stand.
  const Vector3& turned_origin() const { return turned_origin_; }
  const Vector3& turned_origin_rest() const { return turned_origin_rest_; }
  /// Turns normals: linear for a rotation, else its matrix of cofactors.
  const Matrix3& cofactors() const { return cofactors_; }
  /// False: `linear` is the identity.
  bool is_turned() const { return turned_; }
  /// Whether the vertices of the shape are its places. Two such bodies are answered as the shapes.
  bool stands_in_own_frame() const { return !turned_ && placement_.translation == Vector3::Zero(); }
  /// A rotation within rounding: lengths and normals keep their length.
  bool is_rigid() const { return rigid_; }
  /// No two points come to lie farther apart than this times their distance in the shape's frame.
  double stretch() const { return stretch_; }

 private:
  const Shape* shape_;
  Placement placement_;
  Vector3 turned_origin_, turned_origin_rest_ = Vector3::Zero();
  Matrix3 cofactors_ = Matrix3::Identity();
  double stretch_ = 1.0;
  bool turned_ = false, rigid_ = true;
};

}  // namespace quoin::geometry
