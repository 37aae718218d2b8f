#pragma once
/// What lists of pairs are held to. Internal.

#include <quoin/geometry/pair_batch.hpp>

#include "finder/placed_box.hpp"

namespace quoin::geometry {

/// Throws InputError for a pair that does not name two of so many bodies.
void check_pairs(std::span<const BlockPair> pairs, int count);

/// Throws InputError for a placement that is none, of a body that one of the pairs names: what
/// nobody asks for is not looked at. `name(i)`: for the message.
template <class Name>
void check_placements(std::span<const BlockPair> pairs, const Body* bodies, const Name& name) {
  int last = -1;
  for (const BlockPair& pair : pairs) {
    if (pair.a != last) require_placement(bodies[pair.a].placement(), name(pair.a));
    last = pair.a;
    require_placement(bodies[pair.b].placement(), name(pair.b));
  }
}

}  // namespace quoin::geometry
