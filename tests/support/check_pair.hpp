#pragma once
/// All that is promised of an answer for any pair, put to the test.

#include <quoin/geometry/contact_point.hpp>
#include <string>
#include <vector>

#include "support/trial.hpp"

namespace quoin::tests {

/// What one pair showed.
struct PairVerdict {
  std::vector<Fault> faults;   ///< empty: everything held
  bool answered = false;       ///< false: refused (rightly, if there are no faults)
  double gap_error = 0.0;      ///< |gap - exact gap|, m
  double allowed_error = 0.0;  ///< m, see Trial
  ExactGap exact;
  geometry::PairContact contact;
};

/// The answer for a pair against the exact arbiter: gap, normal, certificate, witnesses, status,
/// contact points (check_contact).
PairVerdict check_against_exact(const SolidPair& pair);

/// The same, and then asked in other ways: swapped, scaled by a power of two, from hints, with its
/// points in one call (the same to the bit); shifted, turned, renumbered, mirrored (the same within
/// rounding, and no more refused than before).
PairVerdict check_pair(const SolidPair& pair, Random& random);

}  // namespace quoin::tests
