#pragma once
/// The answer that doubles could not decide. Internal.

#include "certify/candidate.hpp"
#include "certify/canonical_order.hpp"
#include "search/nearest_feature_search.hpp"

namespace quoin::geometry {

/// In double-double. `known`: where the search in doubles has come to.
void exact_answer(const CanonicalPair& pair, int max_iterations, const SearchResult& known,
                  Optimum& optimum);

}  // namespace quoin::geometry
