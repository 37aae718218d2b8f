#pragma once
/// All that the next step depends on, as bytes of this build.

#include <iosfwd>

#include "step/workspace.hpp"

namespace quoin::solver {

/// The state, and what Workspace hands from one step to the next. Not the finder: its memory
/// changes the speed, never the answer.
void write_checkpoint(std::ostream& out, const CompiledScene& compiled, const State& state,
                      const Workspace& work);

/// Into a state and workspace of the same scene. Throws InputError when it is of other blocks
/// (shape, placement, kind or material) or another build, damaged or cut short; both are then half
/// read.
void read_checkpoint(std::istream& in, const CompiledScene& compiled, State& state,
                     Workspace& work);

/// What a change of the scene leaves behind beside that: where points are held, depths that do not
/// count.
void write_setting(std::ostream& out, const CompiledScene& compiled, const Workspace& work);
void read_setting(std::istream& in, CompiledScene& compiled, Workspace& work);

}  // namespace quoin::solver
