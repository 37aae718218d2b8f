#pragma once
/// Memory asked for before it is needed. Internal.

#include <algorithm>
#include "shape/solid.hpp"

namespace quoin::geometry {

/// Asks for the rows of a solid before they are needed: all of a small one, else the beginning.
/// Inline: a compiler drops the call of a function that does nothing else.
#if defined(__GNUC__)
[[gnu::always_inline]] inline void fetch(const double* values, int count) {
  constexpr int kLine = 8, kMost = 16 * kLine;  // doubles
  for (int k = 0; k < std::min(count, kMost); k += kLine) __builtin_prefetch(values + k);
}

[[gnu::always_inline]] inline void fetch(const Solid& polyhedron) {
  __builtin_prefetch(&polyhedron.topology());
  fetch(polyhedron.shape().offsets(), 3 * polyhedron.padded_count());
}

/// What a proof asks for besides.
[[gnu::always_inline]] inline void fetch_vertices(const Solid& polyhedron) {
  fetch(polyhedron.shape().vertices().data(), 3 * polyhedron.vertex_count());
}

/// What laying faces asks for besides.
[[gnu::always_inline]] inline void fetch_faces(const Solid& polyhedron) {
  fetch_vertices(polyhedron);
  fetch(polyhedron.shape().face_normals().data(), 3 * polyhedron.topology().face_count());
}
#else
inline void fetch(const double*, int) {}
inline void fetch(const Solid&) {}
inline void fetch_vertices(const Solid&) {}
inline void fetch_faces(const Solid&) {}
#endif

}  // namespace quoin::geometry
