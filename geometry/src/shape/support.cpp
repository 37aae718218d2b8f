#include "shape/support.hpp"

#include <algorithm>

#include "simd/support_kernels.hpp"

namespace quoin::geometry {

Support support(const Polyhedron& polyhedron, const Vector3& direction) {
  const Rows rows(polyhedron);
#ifdef QUOIN_WIDE_LANES
  if (has_avx512()) return support_512(rows, Wide512(direction));
  if (has_avx2()) return support_256(rows, Wide256(direction));
#endif
  return narrow_support(rows, direction);
}

PairSupport support_pair(const Polyhedron& p, const Polyhedron& q, const Vector3& direction) {
  return {support(p, direction), support(q, -direction)};
}

void find_vertices_beyond(const Polyhedron& polyhedron, const Vector3& direction, double value,
                          VertexSet& vertices) {
  vertices.clear();
  const Rows rows(polyhedron);
#ifdef QUOIN_WIDE_LANES
  if (has_avx512()) return beyond_512(rows, direction, value, vertices);
  if (has_avx2()) return beyond_256(rows, direction, value, vertices);
#endif
  narrow_beyond(rows, direction, value, vertices);
}

int count_beyond(const Polyhedron& polyhedron, const Vector3& direction, double value) {
  const Rows rows(polyhedron);
#ifdef QUOIN_WIDE_LANES
  if (has_avx512()) return count_512(rows, direction, value);
  if (has_avx2()) return count_256(rows, direction, value);
#endif
  return narrow_count(rows, direction, value);
}

bool only_these_beyond(const Polyhedron& polyhedron, const Vector3& direction, double value,
                       std::span<const int> set) {
  return count_beyond(polyhedron, direction, value) == static_cast<int>(set.size()) &&
         std::all_of(set.begin(), set.end(),
                     [&](int v) { return along(offset(polyhedron, v), direction) >= value; });
}

bool carried_alone(const Polyhedron& polyhedron, const Vector3& direction, const Carriers& carriers,
                   Support& top) {
  const Rows rows(polyhedron);
#ifdef QUOIN_WIDE_LANES
  if (has_avx2()) return Scan256::carried_alone(rows, direction, carriers, top);
#endif
  return PlainScan::carried_alone(rows, direction, carriers, top);
}

}  // namespace quoin::geometry
