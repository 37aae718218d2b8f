#pragma once
/// Contact points of the blocks where they stand, or where an attempt takes them.

#include "step/workspace.hpp"

namespace quoin::solver {

/// Of a vertex, at most, m/s.
double vertex_speed(const BlockModel& model, const BlockState& block);

/// Of the smaller of two blocks, m.
double pair_size(const CompiledScene& compiled, int a, int b);

/// A joint that has dilated is closed at a gap, and has not forgotten it when it comes down from a
/// hop that is small against the blocks: the largest of these gaps, m.
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
  /// `of_block`: memory, which must outlive this object.
  Reach(const CompiledScene& compiled, const StepOptions& options, const SearchedState& state,
        std::vector<double>& of_block);
  double of_pair(int a, int b) const;  ///< m
  double largest() const;              ///< of all pairs, m

 private:
  const CompiledScene& compiled_;
  std::vector<double>& of_block_;  ///< m
  double opening_ = 0.0;           ///< m
};

/// By themselves or by a motion.
std::vector<int> blocks_that_can_move(const CompiledScene& compiled);

/// Contacts within the reach of their pair. `moved`: blocks that do not stand where the last search
/// had them. `found` is sorted by key, places in the frames of the reference shapes.
geometry::FindCounts find(const CompiledScene& compiled, const SearchedState& state,
                          const Reach& reach, std::span<const int> moved, Workspace& work,
                          std::vector<geometry::ContactPoint>& found);

/// Finds the contacts of the state at the start of a run, or after it was changed from outside: no
/// block is then known to be at rest.
void detect(const CompiledScene& compiled, const StepOptions& options, const State& state,
            Workspace& work);

}  // namespace quoin::solver
