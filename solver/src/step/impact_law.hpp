#pragma once
/// Velocities at the end of a sub-step: restitution at closing contacts, rest at sticking ones.
/// [Moreau 1988]; the impulses replace the contact forces of the step, so that momentum is kept.

#include "step/step_attempt.hpp"

namespace quoin::solver {

/// After positions were solved with `contacts`. Changes the velocities of blocks.end and what
/// `attempt` says of the solution and of the impact's loss.
void attempt_velocities(const SubStep& step, std::span<const BodyContact> contacts,
                        AttemptMemory& memory, BlocksAtEnd& blocks, Attempt& attempt);

}  // namespace quoin::solver
