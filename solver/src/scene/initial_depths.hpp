#pragma once
/// Gaps of blocks as they are laid that count as none: overlap that is to count as touching
/// (InitialOverlap::Zero), and what the rounding of the coordinates leaves between joined faces.

#include <span>

#include "contact/contact_history.hpp"
#include "scene/compiled_scene.hpp"

namespace quoin::solver {

/// Remembers where pairs overlapped when they were laid and how deep, and takes that depth off
/// contact points found later: the point on A is moved in below A's surface by the depth, so that
/// gap, force and lever all belong to the surface as it stood then. A point of a pair that
/// overlapped has the depth of that pair's remembered point with the same key, else of the nearest
/// one on A. Places are in the frames of the reference shapes.
///
/// Stones that fill a vault 1e6 m from the origin are rounded to 1e-10 m, and no placement of
/// rigid ones would be free of overlap: forces would grow without limit. So where a pair is laid
/// with gaps of either sign within BlockModel::coordinate_rounding of its blocks or
/// Scene::coordinate_rounding, gaps that small are zero from then on, in every scene.
struct InitialDepths {
  struct Entry {
    geometry::ContactKey key;
    Vector3 place = Vector3::Zero();  ///< on A, in the frame of its reference shape, m
    double depth = 0.0;               ///< m, 0 where the pair did not overlap
  };
  std::vector<Entry> entries{};  ///< sorted by key

  bool empty() const { return entries.empty(); }
  /// Of the pairs that are laid (`laid`, by block: Laying): what was remembered of them is
  /// forgotten.
  /// `found`: sorted by key. Pairs with nothing to take off are not remembered.
  /// True where any were.
  bool remember(const CompiledScene& compiled, std::span<const geometry::ContactPoint> found,
                std::span<const char> laid);
  /// `found`: as a search found them where `blocks` stand, sorted by key.
  void take_off(const CompiledScene& compiled, std::span<const BlockState> blocks,
                std::vector<geometry::ContactPoint>& found) const;
};

}  // namespace quoin::solver
