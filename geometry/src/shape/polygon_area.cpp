#include "shape/polygon_area.hpp"

#include <limits>

namespace quoin::geometry {

WideVector wide_area(const Eigen::Ref<const Points>& vertices, std::span<const int> polygon) {
  const Vector3 first = vertices.col(polygon[0]);
  WideVector area;
  WideVector side = wide_difference(vertices.col(polygon[1]), first);
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    const WideVector next = wide_difference(vertices.col(polygon[k]), first);
    area = area + cross(side, next);
    side = next;
  }
  return area;
}

Vector3 polygon_normal(const Eigen::Ref<const Points>& vertices, std::span<const int> polygon) {
  return wide_area(vertices, polygon).rounded();
}

RoughArea rough_area(const Eigen::Ref<const Points>& vertices, std::span<const int> polygon) {
  const Vector3 first = vertices.col(polygon[0]);
  RoughArea rough;
  double lengths = 0.0;
  Vector3 side = vertices.col(polygon[1]) - first;
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    const Vector3 next = vertices.col(polygon[k]) - first;
    rough.area += side.cross(next);
    lengths += side.norm() * next.norm();
    side = next;
  }
  // Of a product 4 eps: its differences, products and their difference; of a sum an eps a term.
  const double roundings = 4.0 + static_cast<double>(polygon.size());
  rough.norm = rough.area.norm();
  rough.error = 4.0 * roundings * std::numeric_limits<double>::epsilon() * lengths;
  return rough;
}

bool is_wider(const Eigen::Ref<const Points>& vertices, std::span<const int> polygon,
              double width) {
  const std::size_t count = polygon.size();
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3 a = vertices.col(polygon[k]);
    const Vector3 side = vertices.col(polygon[(k + 1) % count]) - a;
    const double length = side.norm();
    bool wide = false;
    for (std::size_t m = 0; m < count && !wide; ++m) {  // first the vertices across
      const Vector3 x = vertices.col(polygon[(k + 2 + m) % count]) - a;
      wide = (length > 0.0 ? side.cross(x).norm() / length : x.norm()) > width;
    }
    if (!wide) return false;
  }
  return true;
}

}  // namespace quoin::geometry
