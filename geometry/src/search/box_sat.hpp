#pragma once
/// Least overlap of two bricks. Internal.

#include "search/nearest_feature_search.hpp"

namespace quoin::geometry {

/// Of two solids with the faces of a brick (Topology::brick) that overlap: the least over the 15
/// directions of their faces and pairs of edges. Unclear where another direction comes near it, or
/// a solid is no parallelepiped; the normal is then that of the face that parts the two most, zero
/// where opposite faces of either are not parallel within rounding. Touching where several
/// directions have none within rounding.
/// See geometry/README.md, "Least overlap".
SearchResult box_sat(const Solid& p, const Solid& q, double rounding);

}  // namespace quoin::geometry
