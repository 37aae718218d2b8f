#pragma once
/// Overlap of the start that counts as touching (InitialOverlap::Zero).

#include <span>

#include "contact/contact_history.hpp"

namespace quoin::solver {

/// Remembers where pairs overlapped at the start and how deep, and takes that depth off contact
/// points found later: the point on A is moved in below A's surface by the depth, so that gap,
/// force and lever all belong to the surface as it stood at the start. A point of a pair that
/// overlapped at the start has the depth of that pair's start point with the same key, else of the
/// nearest one on A.
class InitialDepths {
 public:
  /// `found`: the points of the start in the frames of the reference shapes, sorted by key. Pairs
  /// without overlap are not remembered.
  explicit InitialDepths(std::span<const geometry::ContactPoint> found);
  InitialDepths() = default;

  bool empty() const { return entries_.empty(); }
  /// `found`: as a search found them at `state`, sorted by key.
  void take_off(std::span<const BlockModel> models, const State& state,
                std::vector<geometry::ContactPoint>& found) const;

 private:
  struct Entry {
    geometry::ContactKey key;
    Vector3 place = Vector3::Zero();  ///< on A, in the frame of its reference shape, m
    double depth = 0.0;               ///< m, 0 where the pair did not overlap
  };
  std::vector<Entry> entries_;  ///< sorted by key
};

}  // namespace quoin::solver
