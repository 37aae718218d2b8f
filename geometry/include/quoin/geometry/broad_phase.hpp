#pragma once
/// Which pairs of blocks may touch. The one door to FCL.

#include <memory>
#include <quoin/geometry/types.hpp>
#include <span>
#include <vector>

namespace quoin::geometry {

/// Two blocks whose boxes, grown by reach/2, overlap. a < b.
struct BlockPair {
  int a = 0;
  int b = 0;
  auto operator<=>(const BlockPair&) const = default;
};

/// Whether so few boxes are tried pair by pair, without a tree.
bool tries_all_pairs(std::size_t boxes);

/// Keeps a tree of boxes between calls.
class BroadPhase {
 public:
  BroadPhase();
  ~BroadPhase();
  BroadPhase(BroadPhase&&) noexcept;
  BroadPhase& operator=(BroadPhase&&) noexcept;

  /// All pairs with boxes at most `reach` (m) apart, ascending; pairs of two idle blocks left out.
  /// `idle` is empty or one flag a box.
  const std::vector<BlockPair>& find_candidates(std::span<const Box> boxes, double reach,
                                                std::span<const char> idle = {});

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace quoin::geometry
