#pragma once
/// What lists of pairs are held to. Internal.

#include <algorithm>
#include <array>
#include <bit>
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

/// Bodies met on the way through a list of pairs, as many as there is room for: each stands where
/// the last digits of its index say, until another one takes that place.
class MetBodies {
 public:
  explicit MetBodies(std::size_t pairs) : last_(std::bit_ceil(std::clamp(pairs, kFew, kMost)) - 1) {
    std::fill_n(places_.begin(), last_ + 1, -1);
  }
  /// False: it has been met. A body that lost its place is new again.
  bool is_new(int body) {
    int& place = places_[static_cast<std::size_t>(body) & last_];
    if (place == body) return false;
    place = body;
    return true;
  }

 private:
  // Pairs go by their first body: of a grid the partners stand in a few runs, each less than a
  // layer wide, and of 40 x 40 a layer they all find room.
  static constexpr std::size_t kFew = 16, kMost = 2048;
  std::size_t last_;
  std::array<int, kMost> places_;
};

/// Calls `check(body)` for the bodies that pairs name, about once each: what nobody asks for is not
/// looked at, and a body has more pairs than one as a rule.
template <class Check>
void check_bodies(std::span<const BlockPair> pairs, const Check& check) {
  MetBodies met(pairs.size());
  int last = -1;
  for (const BlockPair& pair : pairs) {
    if (pair.a != last && met.is_new(pair.a)) check(pair.a);
    last = pair.a;
    if (met.is_new(pair.b)) check(pair.b);
  }
}

/// Throws InputError for a placement that is none, of a body that one of the pairs names.
/// `name(i)`: for the message.
template <class Name>
void check_placements(std::span<const BlockPair> pairs, const Body* bodies, const Name& name) {
  check_bodies(pairs, [&](int i) { require_placement(bodies[i].placement(), name(i)); });
}

}  // namespace quoin::geometry
