#pragma once
/// Face labels: which facets of a convex surface count as one polygon, and which vertices are its
/// corners. Internal to the narrow phase. Coordinates in any unit in which the largest one is about
/// 1.

#include <quoin/geometry/shape.hpp>
#include <vector>

namespace quoin::geometry {

using Faces = std::vector<std::vector<int>>;

/// The facets of an exact hull: triangles that are exactly coplanar joined to one polygon, vertices
/// that are exactly no corner named by none. They hang on the set of points alone, not on how its
/// hull was cut into triangles (which name every vertex).
Faces exact_facets(const Eigen::Ref<const Points>& vertices,
                   std::span<const std::array<int, 3>> triangles);

struct FaceLabels {
  Faces faces;                       ///< corners, counter-clockwise from outside
  std::vector<HostedVertex> hosted;  ///< all vertices that are no corners
};

/// Labels the cells (convex polygons that make a closed surface) as faces. Vertices that no cell
/// names lie below it.
///
/// Cells are joined while all their vertices lie within `length` below a common plane and their
/// union is convex within `length`; seeds are taken by area. A corner is a vertex where three faces
/// meet, or two along a border that is off its chord by more than `length`. A face with fewer than
/// three corners, or narrower than `length`, joins the neighbour with which it shares most of its
/// border. Every vertex of the cells lies within `length` of the middle plane of its face. Where no
/// closed surface comes out (solids hardly thicker than `length`), a sixteenth of `length` is
/// tried, and so on down to 0, which leaves the cells as they are.
FaceLabels label_faces(const Eigen::Ref<const Points>& vertices, const Faces& cells, double length);

}  // namespace quoin::geometry
