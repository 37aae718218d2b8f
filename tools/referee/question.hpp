#pragma once
/// What the libraries are asked: a pair of solids, or one of its steps when it moves.

#include <memory>

#include "described_solid.hpp"
#include "referee/pairs/solids.hpp"

namespace quoin::referee {

struct DescribedPair {
  DescribedSolid a, b;
  /// default_tolerance of the two shapes, m; 0 where quoin refuses a solid.
  double contact_length = 0.0;
};

/// Questions about the same `solids` are steps of a motion.
struct Question {
  SolidPair pair;
  std::shared_ptr<const DescribedPair> solids;

  explicit Question(SolidPair pair);
};

/// B moving on steadily by its placement, and turning about its middle: a step is at most `amount`
/// of its size and as many radians.
class SteadyMotion {
 public:
  SteadyMotion(const Solid& start, double amount, Random& random);
  geometry::Placement at(int step) const;

 private:
  geometry::Placement start_;
  geometry::Vector3 middle_, axis_, velocity_;
  double turn_;  ///< rad a step
};

}  // namespace quoin::referee
