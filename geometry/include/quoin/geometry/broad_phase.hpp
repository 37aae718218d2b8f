#pragma once
/// Which pairs of blocks may touch. The only user of FCL.

#include <memory>
#include <quoin/geometry/pair_batch.hpp>
#include <span>
#include <vector>

namespace quoin::geometry {

/// Whether so few boxes are tried pair by pair, without a tree.
bool tries_all_pairs(std::size_t boxes);

enum class BoxUse : char { Moving, Idle };  ///< no pair of two idle boxes is ever a candidate

/// Keeps a tree of boxes between calls. It stores boxes in single precision, rounded outward, as
/// seen from the first one. Calls throw InputError once it was moved from, and for a reach that is
/// negative or not finite.
class BroadPhase {
 public:
  BroadPhase();
  ~BroadPhase();
  BroadPhase(BroadPhase&&) noexcept;
  BroadPhase& operator=(BroadPhase&&) noexcept;

  /// Box number `i` is new or has another place; i <= size(), the next one is appended. `reach`: of
  /// its own, m.
  void set(int i, const Box& box, BoxUse use = BoxUse::Moving, double reach = 0.0);
  /// Box number `i` meets nothing until it is set again.
  void remove(int i);

  int size() const;

  /// All pairs with boxes at most `reach` (m), or the reach of one of the two, apart, and few
  /// others whose boxes are so but for the rounding to single precision; ascending.
  const std::vector<BlockPair>& find_candidates(double reach);

  /// Of these, the pairs with one of some boxes, in any order; costs what these boxes and those set
  /// since the last call cost, not what all do.
  const std::vector<BlockPair>& find_candidates_of(std::span<const int> boxes, double reach);

  /// Numbers of all boxes that meet a box, ascending, into `found`. `reach` (m): that of the next
  /// find_candidates(), if the tree is to be kept.
  void find_in_box(const Box& box, double reach, std::vector<int>& found);

  /// A box and where a ray enters it, in units of its direction.
  struct Entry {
    double s = 0.0;
    int box = 0;
  };
  /// The boxes that the points origin + s direction, 0 <= s <= length, meet, nearest entry first,
  /// and few others that are within rounding; s is that of the box with its room in the tree, and
  /// so never too late.
  void find_on_ray(const Vector3& origin, const Vector3& direction, double length, double reach,
                   std::vector<Entry>& found);

  /// The same of just these boxes, in the place of all others, and none that rounding makes a
  /// candidate; `idle` is empty or one flag a box.
  const std::vector<BlockPair>& find_candidates(std::span<const Box> boxes, double reach,
                                                std::span<const char> idle = {});

 private:
  struct Tree;
  Tree& tree() const;
  void require_box(int i, int end) const;
  std::unique_ptr<Tree> tree_;
};

}  // namespace quoin::geometry
