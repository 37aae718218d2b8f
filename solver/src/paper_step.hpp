#pragma once
/// One (sub-)step by the source's own method: Algorithm 1 of [Beyabanaki 2009], or its penalty
/// method.

#include "advance.hpp"

namespace quoin::solver {

/// ContactMethod::Paper and ContactMethod::Penalty.
bool is_paper_method(ContactMethod method);

/// Solves for the increments of [time, time + dt] with contacts work.contacts; the outcome is
/// work.attempt. Normals and T(x) are those of the start of the step, v' = 2D/dt - v.
void attempt_paper_step(const CompiledScene& compiled, const StepOptions& options,
                        const State& state, double time_step, Workspace& work);

}  // namespace quoin::solver
