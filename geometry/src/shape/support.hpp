#pragma once
/// Support functions of a polyhedron: how far it reaches along a direction, and with which
/// vertices. Directions are turned into the shape's frame, offsets are those of its rows, from
/// Shape::origin(); the sums are ((x·dx + y·dy) + z·dz) in every variant. The widest
/// instructions of the machine are chosen at run time; all variants give the same bits.

#include "numeric/small_vector.hpp"
#include "shape/solid.hpp"

namespace quoin::geometry {

using VertexSet = SmallVector<int, 32>;

struct Support {
  int vertex = 0;      ///< the lowest index among the greatest
  double value = 0.0;  ///< its offset · direction, m
};

/// The vertex farthest along `direction` (any length).
Support support(const Solid& polyhedron, const Vector3& direction);

/// Vertex of P farthest along a direction and of Q farthest against it, in one pass.
struct PairSupport {
  Support p;
  Support q;  ///< value: of offset · (-direction), m
};
PairSupport support_pair(const Solid& p, const Solid& q, const Vector3& direction);

/// Vertices whose offset · direction is at least `value`, ascending.
void find_vertices_beyond(const Solid& polyhedron, const Vector3& direction, double value,
                          VertexSet& vertices);

/// Those within two depths of the support plane (m; the first is the greater), and its support.
Support find_top(const Solid& polyhedron, const Vector3& direction,
                 const std::array<double, 2>& depths, VertexSet& deep, VertexSet& shallow);

/// Is `set` (ascending) just the vertices whose offset · direction is at least `value`?
bool only_these_beyond(const Solid& polyhedron, const Vector3& direction, double value,
                       std::span<const int> set);

/// Vertices (ascending) that are to carry a support plane: all of them at most `flat` below it, all
/// others more than `clear`. m
struct Carriers {
  std::span<const int> set;
  double flat = 0.0, clear = 0.0;
};

/// Do they? Then `top` is the support.
bool carried_alone(const Solid& polyhedron, const Vector3& direction, const Carriers& carriers,
                   Support& top);

/// In the order of sums of the scans.
inline double along(const Vector3& x, const Vector3& d) {
  return x.x() * d.x() + x.y() * d.y() + x.z() * d.z();
}

/// Offset of a vertex in the shape's frame, as the scans read it.
inline Vec3 row_offset(const Solid& solid, int v) {
  const double* p = solid.shape().offsets() + v;
  const int rows = solid.padded_count();
  return {p[0], p[rows], p[2 * rows]};
}

}  // namespace quoin::geometry
