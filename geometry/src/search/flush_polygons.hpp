#pragma once
/// What two faces share (overlay_faces, clip.hpp) for four pairs of solids side by side, one in
/// each lane. Internal.

#include <array>
#include <span>

#include "search/flush_bricks.hpp"

namespace quoin::geometry {

/// One face of each of four pairs, and its contact plane in the shape's frame (LocalPlane).
struct PolygonSide {
  static constexpr int kMost = 12;                                         ///< corners
  std::array<std::array<const double*, FlushRow::kPairs>, kMost> corners;  ///< in order; behind the
                                                                           ///< last the first again
  std::array<int, FlushRow::kPairs> count;                                 ///< of corners
  FlushRow base[3], axis_u[3], axis_v[3], up[3];  ///< of the plane, in the shape's frame
  FlushRow shift[3];                              ///< along u, v and up
  FlushRow own[3];                                ///< normal of the face, in the shape's frame
  FlushRow slope[2];                              ///< of the face over the plane, along u and v

  void repeat_first(std::size_t lane) {
    for (auto& place : corners) place[lane] = place[0];
    count[lane] = count[0];
    for (const std::span<FlushRow> rows :
         {std::span<FlushRow>(base), {axis_u}, {axis_v}, {up}, {shift}, {own}, {slope}}) {
      for (FlushRow& row : rows) row.of[lane] = row.of[0];
    }
  }
};

struct PolygonQuestion {
  PolygonSide p, q;
  FlushRow rounding;  ///< border_rounding of each pair, m

  /// In a lane that is left over.
  void repeat_first(std::size_t lane) {
    p.repeat_first(lane);
    q.repeat_first(lane);
    rounding.of[lane] = rounding.of[0];
  }
};

/// A corner of the shared part of one pair, as FlushCorner.
struct PolygonCorner {
  double x, y, height_p, height_q, share;
  Feature feature_p, feature_q;
};

/// What is found of those pairs of which nothing is left to doubt: both faces are flat, none of
/// their corners is near a side of the other.
struct PolygonAnswer {
  unsigned solved = 0;  ///< one bit each
  FlushRow area, margin;
  std::array<int, FlushRow::kPairs> count{};
  std::array<std::array<PolygonCorner, 2 * PolygonSide::kMost>, FlushRow::kPairs> corners;
};

/// The same bits as overlay_faces has, whatever the machine. Corners are in no order.
void flush_polygons(const PolygonQuestion& question, PolygonAnswer& answer);

}  // namespace quoin::geometry
