#pragma once
/// All that is promised of nearest_features and append_contact_points for any pair, put to the
/// test.

#include <quoin/geometry/contact_point.hpp>
#include <string>
#include <vector>

#include "support/exact_arbiter.hpp"
#include "support/families.hpp"

namespace quoin::tests {

/// What one pair showed.
struct PairVerdict {
  std::vector<std::string> faults;  ///< empty: everything held
  double gap_error = 0.0;           ///< |gap - exact gap|, m
  double allowed_error = 0.0;       ///< 1e-12 of the gap + 16 eps of the larger diameter, m
  ExactGap exact;
  geometry::NearestFeatures nearest;
};

/// Gap against the exact arbiter, and everything of check_answer.
PairVerdict check_against_exact(const SolidPair& pair);

/// What can be said of an answer without knowing the right one: finite, unit normal, witnesses on
/// their solids, certificate as claimed and closed, status as defined; its contact points likewise.
std::vector<std::string> check_answer(const SolidPair& pair,
                                      const geometry::NearestFeatures& nearest);

/// Swap, power-of-two scale, shift, turn, renumbering, hints: the same answer where it is unique.
std::vector<std::string> check_symmetries(const SolidPair& pair,
                                          const geometry::NearestFeatures& nearest, Random& random);

}  // namespace quoin::tests
