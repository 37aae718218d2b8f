#pragma once
/// Nearest features of pairs that have been checked. Internal.

#include <quoin/geometry/distance_batch.hpp>

namespace quoin::geometry {

/// update_nearest_features() on the caller's thread, of input that has been checked.
void answer_pairs(std::span<const Body> bodies, std::span<const BlockPair> pairs,
                  std::span<NearestFeatures> answers, const SearchOptions& options);

}  // namespace quoin::geometry
