#pragma once
/// One time step: islands, their sub-steps, cuts.

#include "step/workspace.hpp"

namespace quoin::solver {

/// Moves the state by exactly options.time_step, in counted sub-steps where it must.
/// `best`: after a step that did not converge, the best attempt; else untouched.
StepReport advance(const CompiledScene& compiled, const StepOptions& options, State& state,
                   State& best, Workspace& work);

/// Energy in the springs of blocks that overlap at the start, J. Sets work.stored.
double initial_spring_energy(const CompiledScene& compiled, const StepOptions& options,
                             const State& state, Workspace& work);

}  // namespace quoin::solver
