#pragma once
/// Which contact of one list is which contact of the list before.

#include <quoin/geometry/contact_point.hpp>
#include <span>

namespace quoin::geometry {

/// A contact point as it is remembered: its features and its place in the world, m.
struct TrackedPoint {
  Feature feature_a, feature_b;
  Vector3 place = Vector3::Zero();
};

/// The points of one pair at one time, sorted by features, and the placement of body a.
struct TrackedPair {
  std::span<const TrackedPoint> points;
  const Placement& frame;
};

/// Tells for each point of a pair which one it was before. Keeps its memory.
class PairTracking {
 public:
  /// Fills `previous`, one a point of `now`, with the index of the same features in `before` or, as
  /// seen from body a, of the nearest point within `reach` (m) that no features claim, or -1.
  void match(const TrackedPair& now, const TrackedPair& before, double reach,
             std::span<int> previous);

 private:
  /// A point without a namesake.
  struct Single {
    int index;
    Vector3 place;  // as seen from body a; lengths in a deformed frame are off by its strain
  };
  struct Offer {
    double squared_distance;  // m2
    int now;
    int before;
  };
  void hand_over(double reach, std::span<int> previous);

  std::vector<Single> young_, old_;
  std::vector<Offer> offers_;
};

}  // namespace quoin::geometry
