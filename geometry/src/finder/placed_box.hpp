#pragma once
/// Placements as they come in: whether they are such, and the boxes of bodies in the world.

#include <cstring>
#include <quoin/geometry/body.hpp>
#include <quoin/geometry/build.hpp>
#include <string>

#include <quoin/geometry/pair_batch.hpp>
#include "numeric/numbers.hpp"

namespace quoin::geometry {

/// Throws InputError naming `body`, the number and the limit for a placement that is none.
void refuse_placement(const Placement& placement, int body);

/// Throws InputError naming `body` unless all twelve numbers are finite, none is larger than
/// kLargestCoordinate, and the determinant is positive.
inline void require_placement(const Placement& placement, int body) {
  const Matrix3& m = placement.linear;
  const double sum = m.cwiseAbs().sum() + placement.translation.cwiseAbs().sum();
  const double determinant = m.col(0).dot(m.col(1).cross(m.col(2)));
  if (!(sum <= kLargestCoordinate && determinant > 0.0)) refuse_placement(placement, body);
}

/// To the bit.
inline bool same_placement(const Placement& x, const Placement& y) {
  static_assert(sizeof(Placement) == 12 * sizeof(double));
  return std::memcmp(&x, &y, sizeof(Placement)) == 0;
}

/// Contains the body's solid in spite of rounding, m.
Box placed_box(const Shape& shape, const Placement& placement);

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
