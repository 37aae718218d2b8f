#pragma once
/// Vector area and width of a polygon given by its vertices in order: columns of 3 × n points, in
/// any one unit of length. Internal to the narrow phase.

#include <quoin/geometry/types.hpp>
#include <span>

#include "numeric/double_double.hpp"

namespace quoin::geometry {

/// Twice the vector area of a polygon (by the right hand along its vertices), summed in
/// double-double: right also for slivers.
WideVector wide_area(const Eigen::Ref<const Points>& vertices, std::span<const int> polygon);
/// The same, rounded.
Vector3 polygon_normal(const Eigen::Ref<const Points>& vertices, std::span<const int> polygon);

/// The same in plain doubles, and how far it may be off at most.
struct RoughArea {
  Vector3 area = Vector3::Zero();
  double norm = 0.0, error = 0.0;

  /// Does x reach farther than `length` along the exact vector, beyond doubt?
  bool surely_exceeds(const Vector3& x, double length) const {
    return area.dot(x) > 2.0 * length * norm + 4.0 * error * x.norm();
  }
};
RoughArea rough_area(const Eigen::Ref<const Points>& vertices, std::span<const int> polygon);

/// Is the least distance between two parallel lines that hold a polygon, one of them along a side,
/// more than `width`?
bool is_wider(const Eigen::Ref<const Points>& vertices, std::span<const int> polygon, double width);

}  // namespace quoin::geometry
