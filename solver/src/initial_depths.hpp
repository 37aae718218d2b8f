#pragma once
/// Overlap of blocks as they are laid that counts as touching (InitialOverlap::Zero).

#include <span>

#include "contact/contact_history.hpp"

namespace quoin::solver {

/// Remembers where pairs overlapped when they were laid and how deep, and takes that depth off
/// contact points found later: the point on A is moved in below A's surface by the depth, so that
/// gap, force and lever all belong to the surface as it stood then. A point of a pair that
/// overlapped has the depth of that pair's remembered point with the same key, else of the nearest
/// one on A. Places are in the frames of the reference shapes.
struct InitialDepths {
  struct Entry {
    geometry::ContactKey key;
    Vector3 place = Vector3::Zero();  ///< on A, in the frame of its reference shape, m
    double depth = 0.0;               ///< m, 0 where the pair did not overlap
  };
  std::vector<Entry> entries{};  ///< sorted by key

  bool empty() const { return entries.empty(); }
  /// Of the pairs with a block that is `laid` (by block): what was remembered of them is forgotten.
  /// `found`: sorted by key. Pairs without overlap are not remembered.
  void remember(std::span<const geometry::ContactPoint> found, std::span<const char> laid);
  /// `found`: as a search found them where `blocks` stand, sorted by key.
  void take_off(std::span<const BlockModel> models, std::span<const BlockState> blocks,
                std::vector<geometry::ContactPoint>& found) const;
};

}  // namespace quoin::solver
