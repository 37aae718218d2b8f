#pragma once
/// What lists of pairs are held to. Internal.

#include <quoin/geometry/pair_batch.hpp>

#include "finder/placed_box.hpp"

namespace quoin::geometry {

/// Throws InputError for pair i of a list, saying that it does not name two of so many bodies.
[[noreturn]] void refuse_pair(std::size_t i, const BlockPair& pair, int count);

/// Throws InputError for a pair that does not name two of so many bodies.
inline void check_pair(std::size_t i, const BlockPair& pair, int count) {
  const auto [a, b] = pair;
  if (!(a >= 0 && b >= 0 && a < count && b < count && a != b)) refuse_pair(i, pair, count);
}
void check_pairs(std::span<const BlockPair> pairs, int count);

/// Throws InputError for names that do not ascend.
void check_names(std::span<const int> names);

/// Throws InputError for a placement that is none, of a body that one of the pairs names.
/// `name(i)`: for the message.
template <class Name>
void check_placements(std::span<const BlockPair> pairs, const Body* bodies, const Name& name) {
  for (const BlockPair& pair : pairs)
    for (const int i : {pair.a, pair.b}) require_placement(bodies[i].placement(), name(i));
}

}  // namespace quoin::geometry
