#pragma once
/// Bricks that touch along an edge of each, within some noise: less than the size of the edges by
/// far, more than rounding. Internal.

#include "certify/candidate.hpp"

namespace quoin::geometry {

/// The answer of two bricks whose nearest edges are nearly parallel and beside each other, if a
/// plane is proved to be the best. `across`: of the faces that part them most. See
/// geometry/README.md, "Touching edges".
bool touching_edges(const Solid& p, const Solid& q, const Lengths& length, const Vector3& across,
                    Optimum& optimum);

}  // namespace quoin::geometry
