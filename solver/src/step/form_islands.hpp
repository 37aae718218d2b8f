#pragma once
/// The islands of a step, and which of the scene's contacts are whose.

#include "step/step_run.hpp"

namespace quoin::solver {

using Islands = std::vector<Island*>;

/// Makes the islands of blocks that these contacts join. Those of the last step with the same
/// blocks stay, with what they remember. The source's methods know one island, the scene.
void form_islands(const StepRun& run, std::span<const geometry::ContactPoint> found);

/// After form_islands(): those that have something to do, which is all but those that stood still
/// in the last step and stand under the same loads.
Islands awake(const StepRun& run);
/// The same, later in the step.
Islands awake_islands(const Workspace& work);

/// These islands where the step begins; what a first try at it has left is taken back.
void start_islands(const StepRun& run, std::span<Island* const> islands);

/// After the step: blocks of two islands that overlap make one island, which has not begun the
/// step. `joins`: contacts that made the islands so far; in and out. Returns the new islands.
Islands join_islands_that_met(const StepRun& run, std::vector<geometry::ContactPoint>& joins);

/// All blocks as one island, which has not begun the step.
Islands whole_scene(const StepRun& run);

/// The contacts of islands that are awake take the place of those that they had; sorted by key.
void take_contacts(const StepRun& run, std::vector<Contact>& contacts);

/// Nothing that acts on the island changes.
bool constant_loads(const CompiledScene& compiled, const IslandBlocks& island);

}  // namespace quoin::solver
