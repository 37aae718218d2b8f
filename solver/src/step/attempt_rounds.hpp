#pragma once
/// Attempts at the same sub-step for several islands, each with all its contacts.

#include <functional>

#include "step/workspace.hpp"

namespace quoin::solver {

/// Does `task` once for each island, on several threads where there is enough to do. A task writes
/// to its island and to its blocks alone, so that any number of threads gives the same bits. The
/// time by phase is that of all islands, one after the other.
void side_by_side(const StepRun& run, std::span<Island* const> islands,
                  const std::function<void(Island&)>& task);

/// Whether a block can be gone on with: finite, not too far away, and not squeezed flat.
bool is_sound(const BlockState& block);

/// Contacts of the island where it stands, with their history.
void begin(const StepRun& run, Island& island);

/// Tries the next sub-step of islands that stand at one time and try one length; sets
/// Island::solved. An island tries again with the contacts that it missed and without those that
/// were none.
void attempt(const StepRun& run, std::span<Island* const> islands);

}  // namespace quoin::solver
