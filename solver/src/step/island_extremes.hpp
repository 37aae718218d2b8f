#pragma once
/// What islands show where they stand. It is kept while an island does: a step looks at those alone
/// that were awake in it.

#include "step/workspace.hpp"

namespace quoin::solver {

/// After a step that was taken: of islands that were awake, and of those that the last search knows
/// otherwise than the one before.
void note_islands(const CompiledScene& compiled, const State& state, Workspace& work);

/// Of the whole scene.
Extremes extremes(const CompiledScene& compiled, const State& state, const Workspace& work);

/// What is known of all islands holds for the state and its contact points.
bool all_known(const Workspace& work);

}  // namespace quoin::solver
