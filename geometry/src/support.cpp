#include "support.hpp"

namespace quoin::geometry {

Support support(const Polyhedron& polyhedron, const Vector3& direction) {
  const int rows = polyhedron.padded_count();
  const double* x = polyhedron.offsets();
  const double* y = x + rows;
  const double* z = y + rows;
  Support best{0, x[0] * direction.x() + y[0] * direction.y() + z[0] * direction.z()};
  for (int v = 1; v < polyhedron.vertex_count(); ++v) {
    const double value = x[v] * direction.x() + y[v] * direction.y() + z[v] * direction.z();
    if (value > best.value) best = {v, value};
  }
  return best;
}

void find_vertices_beyond(const Polyhedron& polyhedron, const Vector3& direction, double value,
                          VertexSet& vertices) {
  const int rows = polyhedron.padded_count();
  const double* x = polyhedron.offsets();
  const double* y = x + rows;
  const double* z = y + rows;
  vertices.clear();
  for (int v = 0; v < polyhedron.vertex_count(); ++v) {
    if (x[v] * direction.x() + y[v] * direction.y() + z[v] * direction.z() >= value) {
      vertices.push_back(v);
    }
  }
}

}  // namespace quoin::geometry
