#pragma once
/// Islands: groups of blocks with unknowns that contacts join. Blocks without unknowns join none.
///
/// A step solves each island by itself: its iterations, the softness of its contacts, its cuts, its
/// restitution, its strain held in an impact, its tolerances. What an island does in a step depends
/// on its own blocks, on the contacts found for them, and on blocks without unknowns, and on
/// nothing else.

#include <memory>
#include <optional>

#include "step/entrance_plane.hpp"
#include "step/step_attempt.hpp"
#include "step/step_flags.hpp"

namespace quoin::solver {

/// What an island's step took, and what its last attempt came to.
struct IslandCount {
  int sub_steps = 0, iterations = 0, solves = 0, factorizations = 0;
  int proximal_newton_attempts = 0;
  double residual = 0.0, condition = 0.0, unbalance = 0.0, stiffest_omega_dt = 0.0;
  double rounding = 0.0;       ///< of a gap, m
  double energy_growth = 0.0;  ///< largest of its sub-steps, J; may be negative
  StepFlag turn{.kind = FlagKind::Turn, .limit = kLargestTurn};
  StepFlag impacts{.kind = FlagKind::Impacts, .limit = kGapBetweenImpacts};
};

/// Of an island's blocks where they stand, J.
struct EnergySums {
  double kinetic = 0.0, strain = 0.0, contact = 0.0;
};

/// Contacts or contact points of an island: a list of its own, or the scene's where all of that is
/// the island's.
template <class Item>
class IslandList {
 public:
  IslandList() = default;
  IslandList(IslandList&&) = default;  // no copies: they would read the list of the other
  IslandList& operator=(IslandList&&) = default;

  void clear() {
    own_.clear();
    items_ = own_;
  }
  void push_back(const Item& item) {
    own_.push_back(item);
    items_ = own_;
  }
  /// Reads `scene`, which must stay as it is meanwhile.
  void refer_to(std::span<const Item> scene) {
    own_.clear();
    items_ = scene;
  }
  bool refers_to(std::span<const Item> scene) const {
    return !scene.empty() && items_.data() == scene.data();
  }
  /// `list` is its own from here on; the memory of the one that it had is handed back.
  void exchange(std::vector<Item>& list) {
    own_.swap(list);
    items_ = own_;
  }

  std::size_t size() const { return items_.size(); }
  auto begin() const { return items_.begin(); }
  auto end() const { return items_.end(); }

 private:
  std::vector<Item> own_;
  std::span<const Item> items_;
};

struct Island {
  Island(IslandBlocks island_blocks, StepWatch* watch)
      : blocks(std::move(island_blocks)), memory(blocks.slots, watch) {}
  Island(const Island&) = delete;  // `memory` knows where the slots are
  Island& operator=(const Island&) = delete;
  const std::vector<int>& own() const { return blocks.slots.block_of_slot; }  ///< ascending

  /// Of the step up to the end of the attempt. `before`: mean until the attempt began.
  template <typename Force>
  Force mean(const Force& before, const Force& now) const {
    return now + done / (done + length) * (before - now);
  }

  const IslandBlocks blocks;
  bool begun = false;    ///< its step, or it has none to take
  bool at_rest = false;  ///< nothing moved in the last step and no load changes: no need to try

  double time = 0.0;                         ///< where it stands, s
  double done = 0.0;                         ///< of the step, s
  double length = 0.0;                       ///< of the next attempt, s
  bool parted = false;                       ///< this step, before an impact
  double length_after = 0.0;                 ///< of the attempt after that part, s; 0: no part
  IslandList<geometry::ContactPoint> found;  ///< where it stands
  double reach = 0.0;                        ///< the largest reach of a pair there, m
  IslandList<Contact> history;               ///< as the last accepted sub-step left them
  std::size_t contacts_before = 0;           ///< of the state, when the step began
  std::size_t found_before = 0;              ///< likewise: points found
  std::vector<BodyContact> contacts;         ///< that the attempt holds
  std::vector<int> previous;                 ///< memory of carry_over()
  std::vector<PassingPair> passing;          ///< pairs that the attempt leaves out

  IslandList<geometry::ContactPoint> found_end;   ///< at the end of the attempt
  double reach_end = 0.0;                         ///< likewise
  std::optional<geometry::ContactPoint> missing;  ///< one of found_end that no attempt held
  bool solved = false;                            ///< the attempt, with all contacts
  bool sound = true;    ///< its end can be gone on with: finite, and no block squeezed flat
  bool still = false;   ///< nothing moved in the sub-step, and no load on it changes
  IslandCount count;    ///< of this step
  long searched = -1;   ///< Workspace::search_epoch of the last search for it
  long known = -1;      ///< likewise: `found`, `history` and `extremes` are those of the state
  Extremes extremes;    ///< where it stands
  double stride = 0.0;  ///< static: of the step, by block size
  EnergyLedger energy;  ///< work and losses of this step
  long summed = -1;     ///< Workspace::search_epoch when `sums` were made; they hold while at rest
  EnergySums sums;
  AttemptMemory memory;
  Attempt attempt;
};

using Islands = std::vector<Island*>;

/// The island of a contact; -1: it is none's, or between two.
inline int island_of(const geometry::ContactPoint& point, std::span<const int> island_of_block) {
  const int a = island_of_block[static_cast<std::size_t>(point.key.a)];
  const int b = island_of_block[static_cast<std::size_t>(point.key.b)];
  if (a < 0) return b;
  return b < 0 || b == a ? a : -1;
}

}  // namespace quoin::solver
