#include "polygon/polygon_rows.hpp"

#include <algorithm>
#include <cmath>

namespace quoin::geometry {

void find_sides(PolygonRows& rows) {
  for (int k = rows.count; k < rows.filled(); ++k) {
    rows.x[k] = rows.x[0];
    rows.y[k] = rows.y[0];
    rows.height[k] = rows.height[0];
    rows.side_x[k] = rows.side_y[k] = rows.length[k] = 0.0;
  }
  double low = rows.height[0], high = low;
  for (int k = 0; k < rows.count; ++k) {
    rows.side_x[k] = rows.x[k + 1] - rows.x[k];
    rows.side_y[k] = rows.y[k + 1] - rows.y[k];
    rows.length[k] = std::sqrt(rows.side_x[k] * rows.side_x[k] + rows.side_y[k] * rows.side_y[k]);
    low = std::min(low, rows.height[k]);
    high = std::max(high, rows.height[k]);
  }
  rows.low = low + 0.0;
  rows.high = high + 0.0;
}

}  // namespace quoin::geometry
