#pragma once
/// All that the next step depends on, as bytes of this build.

#include <iosfwd>

#include "step/workspace.hpp"

namespace quoin::solver {

/// The state, what Workspace hands from one step to the next, and what a change of the scene leaves
/// behind: where points are held, depths that do not count. Not the finder: its memory changes the
/// speed, never the answer.
void write_checkpoint(std::ostream& out, const CompiledScene& compiled, const State& state,
                      const Workspace& work);

/// Into those of the same scene. Throws InputError when it is of other blocks (shape, placement,
/// kind or material) or another build, damaged or cut short; all are then half read.
void read_checkpoint(std::istream& in, CompiledScene& compiled, State& state, Workspace& work);

}  // namespace quoin::solver
