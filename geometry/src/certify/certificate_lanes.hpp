#pragma once
/// certify_hint (certificate.hpp) for four pairs of bodies side by side, one in each lane.
/// Internal.

#include <array>

#include "certify/certificate.hpp"

namespace quoin::geometry {

/// Four pairs whose hints name features of the same kinds.
struct HintedPairs {
  static constexpr std::size_t kPairs = 4;
  FeatureKind kind_a = FeatureKind::Vertex, kind_b = FeatureKind::Vertex;
  std::array<const Body*, kPairs> a, b;
  std::array<NearestFeatures*, kPairs> answers;  ///< with the hints
};

/// Completes the answers that are proved, in the world, to the bits of nearest_features; one bit
/// each. Others are left as they are: refuted, or of a kind that is seldom or not beyond doubt.
unsigned certify_hints(const HintedPairs& pairs, double tolerance);

}  // namespace quoin::geometry
