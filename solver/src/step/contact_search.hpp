#pragma once
/// Contact points of the blocks where they stand, or where an attempt takes them.

#include "base/rounding.hpp"
#include "step/workspace.hpp"

namespace quoin::solver {

/// Of a vertex, at most, m/s.
double vertex_speed(const BlockModel& model, const BlockState& block);

/// Of the smaller of two blocks, m.
double pair_size(const CompiledScene& compiled, int a, int b);

/// An overlap by less than this is none, m. `size`: of the smaller block, m.
inline double overlap_limit(double size) { return kRelativeRounding * size; }

/// Of pair_size(): blocks that come nearer by more in a step may jump over each other.
inline constexpr double kFarthest = 0.5;

/// A joint that has dilated is closed at a gap, and has not forgotten it when it comes down from a
/// hop that is small against the blocks; a bond holds where it is stretched. The largest of these
/// gaps, m.
double largest_opening(const CompiledScene& compiled, std::span<const Contact> contacts);

/// Blocks as they are searched for contacts.
struct SearchedState {
  std::span<const BlockState> blocks;
  double opening = 0.0;  ///< largest_opening() of all contacts, m
  double time = 0.0;     ///< s
};

/// Gaps up to which contacts of a pair are watched: twice what a vertex of the two can move in a
/// step (paper, section 3), and never less than a hair of the smaller block.
class Reach {
 public:
  /// `known`: reaches of the last search, which are kept of all blocks but those that have `moved`,
  /// unless a step of all blocks may be another. It must outlive this object.
  Reach(const CompiledScene& compiled, const StepOptions& options, const SearchedState& state,
        std::span<const int> moved, KnownReaches& known);
  double of_pair(int a, int b) const;  ///< m
  /// Of the search, so that no pair has less than of_pair(), m: of all pairs, and of those of a
  /// block.
  double of_all() const;
  double of_block(int block) const;
  double largest() const;               ///< of all pairs, m
  bool is_new() const { return new_; }  ///< of all blocks, not of those that moved alone

 private:
  void look_at(const StepOptions& options, const SearchedState& state, int block);

  const CompiledScene& compiled_;
  KnownReaches& known_;
  bool new_ = false;
};

/// Of the pairs of these points, m; 0: there are none.
double largest_reach(const Reach& reach, std::span<const geometry::ContactPoint> points);

/// By themselves or by a motion.
std::vector<int> blocks_that_can_move(const CompiledScene& compiled);

/// Contacts within the reach of their pair, of all blocks or of those that moved alone. `moved`:
/// blocks that do not stand where the last search had them. `found` is sorted by key, places in the
/// frames of the reference shapes.
geometry::FindCounts find(const CompiledScene& compiled, const SearchedState& state,
                          const Reach& reach, std::span<const int> moved, Searched searched,
                          Workspace& work, std::vector<geometry::ContactPoint>& found);

/// Finds the contacts of the state at the start of a run, or after it was changed from outside: no
/// block is then known to be at rest.
void detect(const CompiledScene& compiled, const StepOptions& options, const State& state,
            Workspace& work);

}  // namespace quoin::solver
