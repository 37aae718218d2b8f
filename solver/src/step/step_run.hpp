#pragma once
/// A step while it is taken.

#include "step/workspace.hpp"

namespace quoin::solver {

struct StepRun {
  const CompiledScene& compiled;
  const StepOptions& options;
  const State& state;        ///< before the step
  const StepMemory& before;  ///< likewise
  Workspace& work;
  StepReport& report;
};

/// The next attempt of an island.
inline SubStep sub_step(const StepRun& run, const Island& island) {
  return {run.compiled,           run.options,         island.blocks,
          run.work.slot_of_block, run.work.now.blocks, island.time,
          island.length,          run.work.now.ties,   run.work.now.quiet_forces};
}

}  // namespace quoin::solver
