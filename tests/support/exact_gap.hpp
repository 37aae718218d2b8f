#pragma once
/// The arbiter's gap of two bodies.

#include <quoin/geometry/body.hpp>

#include "referee/pairs/exact_arbiter.hpp"

namespace quoin::tests {

/// m; exact but for the last rounding.
inline double exact_gap(const geometry::Body& a, const geometry::Body& b) {
  const auto points = [](const geometry::Body& body) {
    return referee::PlacedPoints{body.shape().vertices(), body.placement()};
  };
  return static_cast<double>(referee::ExactPair(points(a), points(b)).gap().gap);
}

}  // namespace quoin::tests
