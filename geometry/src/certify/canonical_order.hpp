#pragma once
/// The order in which a pair is worked, whichever way round it was asked: swapping A and B then
/// gives the same bits. Internal.

#include <quoin/geometry/polyhedron.hpp>

namespace quoin::geometry {

/// True when q comes before p: fewer vertices, then smaller coordinates, first vertex first.
inline bool in_reverse_order(const Polyhedron& p, const Polyhedron& q) {
  if (p.vertex_count() != q.vertex_count()) return q.vertex_count() < p.vertex_count();
  const double* x = p.vertices().data();
  const double* y = q.vertices().data();
  for (int k = 0; k < 3 * p.vertex_count(); ++k) {
    if (x[k] != y[k]) return y[k] < x[k];
  }
  return false;
}

}  // namespace quoin::geometry
