#pragma once
/// How a static analysis goes: its pseudo-step, how far blocks have moved, its verdict.
///
/// A static step solves the equations of a dynamic one with zero velocity: inertia 2 M/tau2 holds a
/// block back in proportion to its displacement. Where there is equilibrium the displacement, and
/// with it the unbalance, goes to zero whatever tau; where there is none the block goes on moving.

#include <quoin/solver/simulation.hpp>
#include <span>

#include "scene/compiled_scene.hpp"

namespace quoin::solver {

struct EquilibriumSearch {
  double pseudo_step = 0.0;       ///< tau, s; 0: not begun
  double longest = 0.0;           ///< s, that it may grow to
  double unbalance = 0.0;         ///< of the last step
  std::vector<BlockState> start;  ///< where the analysis began
};

/// Gaps up to this are contacts of a block in a static step, m: it moves by at most half of it in
/// one.
double static_reach(const BlockModel& model);

/// tau of the first step: the block that the loads accelerate most would move by kStride of its
/// size. Loads that balance on each block have no sum to go by; then it is the block that their
/// sizes would accelerate most. Contacts are not asked: what they hold does not move.
void begin_search(const CompiledScene& compiled, const State& state, EquilibriumSearch& search);

/// Largest motion of one of these blocks from `from` to `to` (by block) beyond what their strains
/// explain, with its own turn and strain, by its size.
double stride(const CompiledScene& compiled, std::span<const int> blocks,
              std::span<const BlockState> from, std::span<const BlockState> to);
bool too_long(double stride);

/// After an accepted step: the next tau, and what `report` says of the search.
void judge(const CompiledScene& compiled, const StepOptions& options, double stride,
           const State& state, EquilibriumSearch& search, StepReport& report);

}  // namespace quoin::solver
