#pragma once
/// Which contact of one list is which contact of the list before.

#include <quoin/geometry/contact_point.hpp>
#include <span>

namespace quoin::geometry {

/// A feature in 32 bits, in the same order; feature indices have at most 30.
struct PackedFeature {
  PackedFeature() = default;
  explicit PackedFeature(const Feature& feature)
      : bits(static_cast<std::uint32_t>(feature.kind) << 30 |
             static_cast<std::uint32_t>(feature.index)) {}
  auto operator<=>(const PackedFeature&) const = default;

  std::uint32_t bits = 0;
};

/// A contact point as it is remembered: its features and its place as seen from body a, m. Lengths
/// in a deformed frame are off by its strain.
struct TrackedPoint {
  PackedFeature feature_a, feature_b;
  Vector3 place = Vector3::Zero();
};

/// `frame`: of body a; `place`: in the world.
inline TrackedPoint tracked(const ContactKey& key, const Vector3& place, const Placement& frame) {
  return {PackedFeature(key.feature_a), PackedFeature(key.feature_b),
          frame.linear.transpose() * (place - frame.translation)};
}

/// Tells for each point of a pair which one it was before. Keeps its memory.
class PairTracking {
 public:
  /// Fills `previous`, one a point of `now`, with the index of the same features in `before` or of
  /// the nearest point within `reach` (m) that no features claim, or -1. Both lists are of one pair
  /// and sorted by features.
  void match(std::span<const TrackedPoint> now, std::span<const TrackedPoint> before, double reach,
             std::span<int> previous);

 private:
  /// A point without a namesake.
  struct Single {
    int index;
    Vector3 place;
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
