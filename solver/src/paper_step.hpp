#pragma once
/// One (sub-)step by the source's own method: Algorithm 1 of [Beyabanaki 2009], or its penalty
/// method.

#include "paper_open_close.hpp"
#include "step/step_attempt.hpp"

namespace quoin::solver {

struct PaperMemory {
  PaperMemory(const Slots& slots, StepWatch* watch) : open_close(slots, watch) {}
  BlockSystem base;
  BlockVector force;
  PaperOpenClose open_close;
  PhaseClock clock;
};

/// Solves for the increments of all blocks with these contacts. Normals and T(x) are those of the
/// start of the step, v' = 2D/dt - v.
void attempt_paper_step(const SubStep& step, std::span<const BodyContact> contacts,
                        PaperMemory& memory, BlocksAtEnd& blocks, Attempt& attempt);

}  // namespace quoin::solver
