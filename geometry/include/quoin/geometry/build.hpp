#pragma once
/// Polyhedra from plain data, checked on the way in. Every function throws InputError naming the
/// feature, the value and the limit when the data does not make a convex solid.

#include <quoin/geometry/polyhedron.hpp>
#include <string>

namespace quoin::geometry {

/// Axis-aligned box between two corners, m.
Polyhedron make_box(const Vector3& min, const Vector3& max);

/// Prism: a convex polygon (3 × n, planar, m) swept along `sweep` (m).
Polyhedron make_prism(const Eigen::Ref<const Points>& polygon, const Vector3& sweep);

/// A convex hull and where its vertices stood in the input.
struct Hull {
  Polyhedron polyhedron;
  std::vector<int> input_index;  ///< hull vertex -> column of the input
};

/// Convex hull of points (3 × n, m). Coplanar triangles are merged to polygons.
Hull make_hull(const Eigen::Ref<const Points>& points);

/// Polyhedron by vertices (3 × n, m) and faces (polygons or triangles, either orientation
/// throughout); checked: finite, closed, convex, planar within tolerance, no duplicate points,
/// non-zero volume. Coplanar neighbours are merged to polygons; unused vertices are refused.
Polyhedron make_polyhedron(const Eigen::Ref<const Points>& vertices,
                           const std::vector<std::vector<int>>& faces);

}  // namespace quoin::geometry
