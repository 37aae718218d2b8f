#pragma once
/// Least overlap, by growing a polytope inside the set of differences. Private to the room.

#include "fast_search.hpp"

namespace quoin::geometry {

/// From the last simplex of fast_nearest. Unclear where doubles do not settle it.
FastResult fast_overlap(const Polyhedron& p, const Polyhedron& q, const FastResult& start,
                        double rounding);

}  // namespace quoin::geometry
