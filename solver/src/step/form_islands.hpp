#pragma once
/// The islands of a step, and which of the scene's contacts are whose.

#include "step/step_run.hpp"

namespace quoin::solver {

/// Makes the islands of blocks that the contacts found join. Those of the last step with the same
/// blocks stay, with what they remember. The source's methods know one island, the scene.
void form_islands(const StepRun& run);

/// All blocks as one island, which has not begun the step.
void form_whole_scene(const StepRun& run);

/// After the step: blocks of two islands that overlap make one island, which has not begun the
/// step. True when there are any.
bool join_islands_that_met(const StepRun& run);

/// Which islands have something to do, all but those that stood still in the last step and stand
/// under the same loads. All of them have then begun the step.
void wake_islands(const StepRun& run);

/// The islands that are not at rest.
void list_awake(const Workspace& work, Islands& islands);

/// These islands where the step begins; what a first try at it has left is taken back.
void start_islands(const StepRun& run, std::span<Island* const> islands);

/// Contacts of islands at rest stay, `added` come in for those of all others; both sorted by key.
void replace_awake(const StepRun& run, std::span<const Contact> added,
                   std::vector<Contact>& contacts);

/// The contacts of islands that are awake take the place of those that they had; sorted by key.
void take_contacts(const StepRun& run, std::vector<Contact>& contacts);

/// The points found at the end of the attempts take the place of those that their blocks had.
void take_found(const StepRun& run);

/// Nothing that acts on the island changes.
bool constant_loads(const CompiledScene& compiled, const IslandBlocks& island);

}  // namespace quoin::solver
