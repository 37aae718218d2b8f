#pragma once
/// Polygons in rows, as kernels in plain code. See kernels/kernels.hpp. Internal.

#include "polygon/polygon_rows.hpp"

#include <algorithm>

#include "numeric/floating_point.hpp"

namespace quoin::geometry {
namespace {

inline void narrow_corners(const double* vertices, const LocalPlane& plane, PolygonRows& rows) {
  for (int k = 0; k < rows.count; ++k) {
    const double* const v = vertices + 3 * rows.vertex[k];
    const Vec3 vertex(v[0], v[1], v[2]);
    const Vector2 place = plane.place(vertex);
    rows.x[k] = place.x();
    rows.y[k] = place.y();
    rows.height[k] = plane.height(vertex);
  }
}

inline void lay_narrow(const double* vertices, const LocalPlane& plane, PolygonRows& rows) {
  narrow_corners(vertices, plane, rows);
  find_sides(rows);
}

inline void narrow_masks(const PolygonRows& corners, const PolygonRows& sides, double rounding,
                         SideMasks& masks) {
  std::fill(masks.inside, masks.inside + corners.count, 0);
  std::fill(masks.outside, masks.outside + corners.count, 0);
  masks.margin = kInfinity;
  for (int j = 0; j < sides.count; ++j) {
    const double slack = rounding * sides.length[j];
    double greatest = -kInfinity;
    for (int i = 0; i < corners.count; ++i) {
      const double inside = sides.side_x[j] * (corners.y[i] - sides.y[j]) -
                            sides.side_y[j] * (corners.x[i] - sides.x[j]);
      masks.inside[i] |= static_cast<std::uint64_t>(inside > slack) << j;
      masks.outside[i] |= static_cast<std::uint64_t>(inside < -slack) << j;
      greatest = std::max(greatest, inside);
    }
    masks.margin = std::min(masks.margin, sides.length[j] > 0.0 ? greatest / sides.length[j] : 0.0);
  }
}

}  // namespace
}  // namespace quoin::geometry
