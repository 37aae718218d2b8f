#pragma once
/// The search in doubles: fast, and told by the caller's proof when it was not good enough.
/// Internal.

#include "search/exact_search.hpp"

namespace quoin::geometry {

enum class SearchOutcome {
  Separated,
  Overlapping,
  Touching,  ///< several planes part the solids within rounding; the normal is their mean
  Unclear
};

struct SearchResult {
  SearchOutcome outcome = SearchOutcome::Unclear;
  Vector3 normal = Vector3::UnitX();  ///< unit, from P to Q, within the rounding of the search
  double bound = 0.0;  ///< the gap is at most this (separated) or at most minus the depth proved, m
  std::array<int, 4> p{}, q{};  ///< corners of the last simplex
  int corners = 0;
  int iterations = 0;
};

/// The same with P and Q exchanged.
inline SearchResult swapped(SearchResult result) {
  result.normal = -result.normal;
  std::swap(result.p, result.q);
  return result;
}

/// Nearest features of separated solids, starting along `direction`. Overlapping: the solids share
/// a point; the normal is then the last one tried.
SearchResult nearest_feature_search(const Solid& p, const Solid& q, const Vector3& direction,
                                    double rounding);

/// From the last simplex of nearest_feature_search. Unclear where doubles do not settle it.
SearchResult expand_polytope(const Solid& p, const Solid& q, const SearchResult& start,
                             double rounding);

/// Of two solids with the faces of a brick (Topology::brick) that overlap: the least over the 15
/// directions of their faces and pairs of edges. Unclear where another direction comes near it, or
/// a solid is no parallelepiped; the normal is then that of the face that parts the two most, zero
/// where opposite faces of either are not parallel within rounding. Touching where several
/// directions have none within rounding.
/// See geometry/README.md, "Least overlap".
SearchResult box_sat(const Solid& p, const Solid& q, double rounding);

}  // namespace quoin::geometry
