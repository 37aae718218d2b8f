#pragma once
/// What a step says of itself.

#include "step/workspace.hpp"

namespace quoin::solver {

/// Adds what the attempt took to the island's count.
void count_attempt(Island& island);

/// Of the islands that were awake: counts of the one that took most, and the worst of the other
/// numbers.
void report_islands(std::span<Island* const> islands, StepReport& report);

/// Contacts of the last attempt whose force the next iteration would change most.
FightingContacts fighting(const StepRun& run, const Island& island);

/// After the step: contacts, strains, speeds of the state, and flags.
void report_end(const CompiledScene& compiled, const StepOptions& options, const State& state,
                Workspace& work, StepReport& report);

}  // namespace quoin::solver
