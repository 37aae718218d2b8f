#include "shape/support.hpp"

#include <algorithm>

#include "shape/support_kernels.hpp"

namespace quoin::geometry {

Support support(const Solid& polyhedron, const Vector3& direction) {
  const Rows rows(polyhedron);
  const Vec3 local = rows.local(direction);
#ifdef QUOIN_WIDE_LANES
  if (has_avx512()) return support_512(rows, Wide512(local));
  if (has_avx2()) return support_256(rows, Wide256(local));
#endif
  return narrow_support(rows, local);
}

PairSupport support_pair(const Solid& p, const Solid& q, const Vector3& direction) {
  return {support(p, direction), support(q, -direction)};
}

void find_vertices_beyond(const Solid& polyhedron, const Vector3& direction, double value,
                          VertexSet& vertices) {
  vertices.clear();
  const Rows rows(polyhedron);
  const Vec3 local = rows.local(direction);
#ifdef QUOIN_WIDE_LANES
  if (has_avx512()) return beyond_512(rows, local, value, vertices);
  if (has_avx2()) return beyond_256(rows, local, value, vertices);
#endif
  narrow_beyond(rows, local, value, vertices);
}

int count_beyond(const Solid& polyhedron, const Vector3& direction, double value) {
  const Rows rows(polyhedron);
  const Vec3 local = rows.local(direction);
#ifdef QUOIN_WIDE_LANES
  if (has_avx512()) return count_512(rows, local, value);
  if (has_avx2()) return count_256(rows, local, value);
#endif
  return narrow_count(rows, local, value);
}

bool only_these_beyond(const Solid& polyhedron, const Vector3& direction, double value,
                       std::span<const int> set) {
  const Vec3 local = polyhedron.turned_back(direction);
  return count_beyond(polyhedron, direction, value) == static_cast<int>(set.size()) &&
         std::all_of(set.begin(), set.end(),
                     [&](int v) { return dot(row_offset(polyhedron, v), local) >= value; });
}

bool carried_alone(const Solid& polyhedron, const Vector3& direction, const Carriers& carriers,
                   Support& top) {
  const Rows rows(polyhedron);
#ifdef QUOIN_WIDE_LANES
  if (has_avx2()) return Scan256::carried_alone(rows, rows.local(direction), carriers, top);
#endif
  return PlainScan::carried_alone(rows, rows.local(direction), carriers, top);
}

}  // namespace quoin::geometry
