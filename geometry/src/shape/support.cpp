#include "shape/support.hpp"

#include <algorithm>

namespace quoin::geometry {

PairSupport support_pair(const Solid& p, const Solid& q, const Vector3& direction) {
  return {support(p, direction), support(q, -direction)};
}

bool only_these_beyond(const Solid& polyhedron, const Vector3& direction, double value,
                       std::span<const int> set) {
  const Vec3 local = polyhedron.turned_back(direction);
  return count_beyond(polyhedron, direction, value) == static_cast<int>(set.size()) &&
         std::all_of(set.begin(), set.end(),
                     [&](int v) { return dot(row_offset(polyhedron, v), local) >= value; });
}

}  // namespace quoin::geometry
