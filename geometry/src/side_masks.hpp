#pragma once
/// Which corners of one polygon lie on which side of the sides of another. Private to the room.

#include <cstdint>

namespace quoin::geometry {

/// A convex polygon's corners and sides as flat rows; rows are filled up to a multiple of 8 with
/// corner 0. m
struct PolygonRows {
  static constexpr int kMost = 64;
  int count = 0;
  alignas(64) double x[kMost];
  alignas(64) double y[kMost];
  double side_x[kMost], side_y[kMost], length[kMost];
};

/// Corners of the other polygon (one bit each) that lie inside a side or outside it, by more than
/// some length, and the greatest of how far they lie inside times the side's length, m2.
struct SideMask {
  std::uint64_t inside, outside;
  double greatest;
};

/// One mask for each side. The same bits whatever the machine.
void find_side_masks(const PolygonRows& sides, const PolygonRows& points, double rounding,
                     SideMask* masks);

}  // namespace quoin::geometry
