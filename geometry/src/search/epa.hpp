#pragma once
/// Least overlap, by growing a polytope inside the set of differences. Internal.

#include "search/nearest_feature_search.hpp"

namespace quoin::geometry {

/// From the last simplex of nearest_feature_search. Unclear where doubles do not settle it.
SearchResult expand_polytope(const Solid& p, const Solid& q, const SearchResult& start,
                             double rounding);

}  // namespace quoin::geometry
