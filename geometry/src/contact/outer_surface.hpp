#pragma once
/// The surface of a solid over places of a contact plane, and whether it is that of its labels.
/// Internal.

#include "polygon/contact_plane.hpp"
#include "shape/support.hpp"

namespace quoin::geometry {

/// The hull's surface on the side that faces the other solid, where it is near its support plane.
class OuterSurface {
 public:
  /// `outward` is +1 for P, -1 for Q. Of use over places where the solid reaches to within `depth`
  /// (m) of its support plane; a place up to kBesideBorder times `rounding` (m) beside the
  /// solid counts as on it, as it does on the border of a polygon. No farther: that, and the
  /// rounding of the points themselves, is what is promised of them.
  OuterSurface(const Solid& solid, const ContactPlane& plane, double outward, double depth,
               double rounding);
  /// Height over a place along the normal of the plane; `otherwise` where it is not known. m
  ///
  /// A triangle of vertices over the place lies in the solid, and one of them in its surface: the
  /// height is the greatest of all. From a triangle of the topology's surface, which of moved
  /// vertices need not be convex, it goes on as the simplex method does: a vertex enters while that
  /// raises the height.
  double height(const Vector2& place, double otherwise) const;

 private:
  using Triangle = std::array<int, 3>;  // of `places_`, counter-clockwise
  struct Cover {
    bool found = false;
    double height = 0.0;  // times outward
  };
  bool faces(const Triangle& triangle) const;  // the other solid, and not too steeply
  Cover cover(const Triangle& triangle, const Vector2& place) const;
  Cover cover_side(const Triangle& triangle, const std::array<Vector2, 3>& step) const;
  double needle_height(const Triangle& triangle, const std::array<Vector2, 3>& step) const;
  bool raise(Triangle& triangle, const Vector2& place, double& height) const;
  const Vector2& at(int i) const { return places_[static_cast<std::size_t>(i)]; }

  double outward_, rounding_;
  SmallVector<Vector2, 32> places_;
  SmallVector<double, 32> heights_;  // times outward
  SmallVector<Triangle, 32> triangles_;
  SmallVector<int, 32> corners_;  // of the triangles
};

}  // namespace quoin::geometry
