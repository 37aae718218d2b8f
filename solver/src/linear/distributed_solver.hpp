#pragma once
/// Linear systems that several processes solve together.

#include <quoin/solver/simulation.hpp>

#include "block/block_system.hpp"

namespace quoin::solver {

/// Holds one matrix at a time. All processes take the same steps: they call the same functions in
/// the same order with the same bits, and get the same bits back.
class DistributedSolver {
 public:
  virtual ~DistributedSolver() = default;

  /// `kind`: Elimination or Multigrid. False where the matrix is singular to working accuracy, or
  /// symmetric, eliminated and not positive definite.
  virtual bool factorize(const BlockSystem& system, const Slots& slots, LinearSolverKind kind) = 0;

  /// Iterations end at a residual of 1e-8 of `right`; where they do not reach it the matrix is
  /// eliminated. False where that fails, too. `counts`: what it took is added.
  virtual bool solve(const BlockVector& right, BlockVector& solution,
                     LinearSolverCounts& counts) = 0;
};

}  // namespace quoin::solver
