#pragma once
/// K D = F of an island's blocks alone, by its slots.

#include "contact/contact_jacobian.hpp"
#include "step/sub_step.hpp"

namespace quoin::solver {

/// Where it changes from one linearisation to the next, that is F alone.
struct BlockTerms {
  BlockSystem base;                ///< K, and the pairs that contacts couple
  SquareBlocks compliance;         ///< inverse of each diagonal block
  std::vector<StepScheme> scheme;  ///< of each diagonal block: what it was made with
  BlockVector force;               ///< F
  BlockVector free_increment;      ///< of the first linearisation, where a contact may close
};

/// K and its inverse; blocks whose poses.deforms is 0 move rigidly. `terms`: of these blocks, made
/// anew where the scheme is another one.
void set_matrices(const SubStep& step, const StepPoses& poses, BlockTerms& terms);

/// F of inertia, stress, gravity and loads.
void set_force(const SubStep& step, const StepPoses& poses, BlockTerms& terms);

}  // namespace quoin::solver
