#pragma once
/// Which contact of one list is which contact of the list before.

#include <quoin/geometry/contact_point.hpp>
#include <span>

namespace quoin::geometry {

/// A contact point as it is remembered: its features and its place in a frame that is the same in
/// both lists, m.
struct TrackedPoint {
  Feature feature_a, feature_b;
  Vector3 place = Vector3::Zero();
};

/// The points of one pair of bodies and those that it had before, both sorted by features: fills
/// `previous` with the index of the same features before, or of the nearest one within `reach` (m) that
/// no features claim, or -1. Keeps its memory.
class PairTracking {
 public:
  void match(std::span<const TrackedPoint> now, std::span<const TrackedPoint> before, double reach,
             std::span<int> previous);

 private:
  struct Offer {
    double squared_distance;  // m2
    int now;
    int before;
  };
  void hand_over(std::span<const TrackedPoint> now, std::span<const TrackedPoint> before,
                 double reach, std::span<int> previous);

  std::vector<int> young_, old_;  // without a namesake
  std::vector<Offer> offers_;
};

}  // namespace quoin::geometry
