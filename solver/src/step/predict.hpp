#pragma once
/// Where the blocks are expected at the end of a sub-step: the first guess of its solution.

#include "contact/contact_jacobian.hpp"
#include "step/sub_step.hpp"

namespace quoin::solver {

/// What is known of the last accepted sub-step.
struct LastSubStep {
  std::vector<double> length;  ///< by slot of CompiledScene::slots, s; 0: none
  BlockVector velocity;        ///< at its start, likewise
  std::vector<char> hit;  ///< by block: an impact passed through it, or through the last attempt
  /// By block: ContactSolver::crowd() of its island; 0 where that kept its modes.
  std::vector<char> crowded;
};

/// All vectors of `poses` for so many blocks.
void resize(std::size_t blocks, StepPoses& poses);

/// Blocks without unknowns: where they are, and where their motion takes them.
void place_idle(const CompiledScene& compiled, std::span<const BlockState> state,
                std::span<const BlockState> end, std::span<const Vector12> prescribed_increments,
                StepPoses& poses);

/// What a block of a dynamic sub-step sets out with: without strain rate where its strain is held.
BlockState start_state(const SubStep& step, const StepPoses& poses, std::size_t block);

/// Force of a load in the sub-step, N. Water presses where the velocities at its start bring the
/// block in half of it: where it stands at the start, what floats would bob higher and higher.
Vector3 force(const SubStep& step, const StepPoses& poses, const PointForce& load);

/// Of the island's blocks, at the start of the sub-step.
void set_start(const SubStep& step, StepPoses& poses);

/// Of the island's blocks: they go on with their velocity, and with the acceleration of the last
/// sub-step where that was as long and no impact.
void predict(const SubStep& step, const LastSubStep& last, StepPoses& poses);

/// Of the island's blocks: the poses that their increments lead to.
void set_end(const SubStep& step, StepPoses& poses);

}  // namespace quoin::solver
