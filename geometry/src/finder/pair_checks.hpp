#pragma once
/// What lists of pairs are held to. Internal.

#include <quoin/geometry/pair_batch.hpp>

namespace quoin::geometry {

/// Throws InputError for a pair that does not name two of so many bodies.
void check_pairs(std::span<const BlockPair> pairs, int count);

}  // namespace quoin::geometry
