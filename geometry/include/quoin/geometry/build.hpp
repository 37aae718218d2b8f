#pragma once
/// Polyhedra from plain data, checked on the way in. Every function throws InputError naming the
/// feature, the value and the limit when the data does not make a convex solid.

#include <quoin/geometry/polyhedron.hpp>
#include <string>

namespace quoin::geometry {

inline constexpr int kMostHullPoints = 100000;  ///< points that make_hull takes
inline constexpr int kMostVertices = 10000;     ///< vertices that one polyhedron may have
inline constexpr double kLargestCoordinate =
    1e30;  ///< m; far beyond it products of six lengths overflow
inline constexpr double kSmallestExtent = 1e-30;  ///< m, of a solid; far below it they vanish
/// How far a face given may be off its plane, and a vertex beyond it, as a share of the diameter.
inline constexpr double kFlatness = 1e-6;

/// Axis-aligned box between two corners, m. Vertex i + 2 j + 4 k stands at corner (i, j, k).
Polyhedron make_box(const Vector3& min, const Vector3& max);

/// Prism: a convex polygon (3 × n, planar, either direction, m) swept along `sweep` (m). Vertices:
/// the polygon's, then the swept ones in the same order.
Polyhedron make_prism(const Eigen::Ref<const Points>& polygon, const Vector3& sweep);

/// A convex hull and where its vertices stood in the input.
struct Hull {
  Polyhedron polyhedron;
  std::vector<int> input_index;  ///< hull vertex -> column of the input, ascending
};

/// Exact convex hull of points (3 × n, m). Triangles that are coplanar within 1e-9 of the diameter
/// or 16 eps of the largest coordinate are labelled as one polygon. Points that are not corners of
/// the hull are left out. Refused: fewer than 4 or more than kMostHullPoints points, NaN or
/// infinity, equal points, points in one plane (thinner than the same tolerance).
Hull make_hull(const Eigen::Ref<const Points>& points);

/// Polyhedron by vertices (3 × n, m) and faces (polygons or triangles, either orientation
/// throughout: inside-out is turned round); checked: finite, closed, convex and planar within
/// kFlatness, no equal points, non-zero volume, no unused vertex. Coplanar neighbours are merged to
/// polygons as in make_hull. The solid is the convex hull of the vertices; all of them are kept.
Polyhedron make_polyhedron(const Eigen::Ref<const Points>& vertices,
                           const std::vector<std::vector<int>>& faces);

}  // namespace quoin::geometry
