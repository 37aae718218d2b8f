#pragma once
/// Islands on the solver's threads.

#include <functional>

#include "step/step_run.hpp"

namespace quoin::solver {

/// Does `task` once for each island, on several threads where there is enough to do. A task writes
/// to its island and to its blocks alone, so that any number of threads gives the same bits. The
/// time by phase is that of all islands, one after the other.
void side_by_side(const StepRun& run, std::span<Island* const> islands,
                  const std::function<void(Island&)>& task);

}  // namespace quoin::solver
