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

/// What is searched.
struct SearchedState {
  std::span<const BlockState> blocks;
  std::span<const int> moved;  ///< blocks that do not stand where the last search had them
  double opening = 0.0;        ///< largest_opening() of all contacts, m
  double time = 0.0;           ///< s
};

/// By themselves or by a motion.
std::vector<int> blocks_that_can_move(const CompiledScene& compiled);

/// Sets work.reach. `found` is sorted by key, places in the frames of the reference shapes.
geometry::FindCounts find(const CompiledScene& compiled, const StepOptions& options,
                          const SearchedState& state, Workspace& work,
                          std::vector<geometry::ContactPoint>& found);

/// Finds the contacts of the state at the start of a run, or after it was changed from outside.
void detect(const CompiledScene& compiled, const StepOptions& options, const State& state,
            Workspace& work);

}  // namespace quoin::solver
