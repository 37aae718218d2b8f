#pragma once
/// Convex polygons in the contact plane as flat rows, and which corners of one lie on which side of
/// the sides of another. Internal.

#include <cstdint>
#include "shape/solid.hpp"

#include "polygon/contact_plane.hpp"

namespace quoin::geometry {

/// A convex polygon, counter-clockwise seen against the normal. m
struct PolygonRows {
  static constexpr int kMost = 63;  ///< corners: one bit each
  static constexpr int kRoom = 72;  ///< rows are filled with corner 0 from `count` to `filled()`
  int count = 0;
  int face = 0;                    ///< that names points on it
  int vertex[kRoom], edge[kRoom];  ///< corner k; from it to the next, -1: none of the topology
  alignas(64) double x[kRoom], y[kRoom], height[kRoom];            ///< height along the normal
  alignas(64) double side_x[kRoom], side_y[kRoom], length[kRoom];  ///< from corner k to the next
  double low = 0.0, high = 0.0;                                    ///< least and greatest height
  double slope_x = 0.0, slope_y = 0.0;                             ///< of its surface
  PolygonRows() {}  // NOLINT: the rows are filled later
  int filled() const { return (count + 7) / 8 * 8 + 1; }
  int next(int k) const { return k + 1 < count ? k + 1 : 0; }
};

/// Lays vertices of a polyhedron: `vertex` and `count` are given.
void lay_corners(const Solid& polyhedron, const ContactPlane& plane, PolygonRows& rows);

/// The rest, where places and heights are given.
void find_sides(PolygonRows& rows);

/// The corners of one polygon against the sides of another (one bit each): which they lie inside
/// and outside of, by more than some length.
struct SideMasks {
  std::uint64_t inside[PolygonRows::kRoom], outside[PolygonRows::kRoom];
  double margin;  ///< least over the sides of how far the corners reach inside, m
  SideMasks() {}  // NOLINT: filled later
};

/// Both polygons against each other: `of_p` are P's corners and Q's sides. The same bits whatever
/// the machine.
void find_side_masks(const PolygonRows& p, const PolygonRows& q, double rounding, SideMasks& of_p,
                     SideMasks& of_q);

}  // namespace quoin::geometry
