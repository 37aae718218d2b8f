#pragma once
/// Two convex polygons as flat rows, and which corners of one lie on which side of the sides of the
/// other. Private to the room.

#include <cstdint>

namespace quoin::geometry {

/// A convex polygon in the contact plane, counter-clockwise seen against the normal. m
struct PolygonRows {
  static constexpr int kMost = 63;  ///< corners: one bit each
  static constexpr int kRoom = 72;  ///< places are filled with corner 0 from `count` to `filled()`
  int count = 0;
  alignas(64) double x[kRoom], y[kRoom];
  alignas(64) double side_x[kRoom], side_y[kRoom], length[kRoom];  ///< from corner k to the next
  double height[kRoom];                                            ///< of corner k along the normal
  int vertex[kRoom], edge[kRoom];       ///< corner k; to the next, -1: none of the topology
  int face = 0;                         ///< that names points on it
  double slope_x = 0.0, slope_y = 0.0;  ///< of its surface
  double low = 0.0, high = 0.0;         ///< least and greatest height
  PolygonRows() {}                      // NOLINT: the rows are filled later
  int filled() const { return (count + 7) / 8 * 8 + 1; }
  /// Once all corners are laid; the parts of the normal of its surface in the contact plane and
  /// across it.
  void set_surface(double normal_u, double normal_v, double across);
  int next(int k) const { return k + 1 < count ? k + 1 : 0; }
};

/// The corners of one polygon against the sides of another (one bit each): which they lie inside
/// and outside of, by more than some length.
struct SideMasks {
  std::uint64_t inside[PolygonRows::kRoom], outside[PolygonRows::kRoom];
  double margin;  ///< least over the sides of how far the corners reach inside, m
  SideMasks() {}  // NOLINT: filled later
};

/// Both polygons against each other: `of_p` are P's corners and Q's sides. Fills the rows of sides,
/// too. The same bits whatever the machine.
void find_side_masks(PolygonRows& p, PolygonRows& q, double rounding, SideMasks& of_p,
                     SideMasks& of_q);

}  // namespace quoin::geometry
