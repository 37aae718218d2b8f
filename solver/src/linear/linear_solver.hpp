#pragma once
/// Solution of K x = f for a sparse matrix of blocks.

#include <quoin/solver/simulation.hpp>

#include "linear/distributed_solver.hpp"
#include "linear/multifrontal.hpp"

namespace quoin::solver {

/// What iterations have spent.
struct SolveCount {
  int iterations = 0;
  int solves = 0;  ///< right-hand sides
  int factorizations = 0;
  void count(const SolveCount& more) {
    iterations += more.iterations;
    solves += more.solves;
    factorizations += more.factorizations;
  }
};

/// Eliminates; of several processes, what is large goes to all of them. See solver/README.md,
/// "Linear systems".
class LinearSolver {
 public:
  /// Eliminates, until choose() says otherwise. `watch`, where there is one, is looked at during
  /// factorize(), which then throws StepStopped.
  explicit LinearSolver(const Slots& slots, StepWatch* watch = nullptr)
      : slots_(&slots), elimination_(slots, watch) {}

  /// From the next matrix on; counts start at zero. `distributed`, where there is one, solves what
  /// Automatic does not eliminate; it must outlive the use of this object.
  void choose(LinearSolverKind kind, DistributedSolver* distributed = nullptr) {
    kind_ = kind;
    distributed_ = distributed;
    counts_ = {};
  }

  /// From the next matrix on.
  void use(const Threads& threads) { elimination_.use(threads); }

  /// False when it is singular to working accuracy, or symmetric, eliminated and not positive
  /// definite.
  bool factorize(const BlockSystem& system);

  /// False where iterations of several processes do not converge and elimination fails, too:
  /// `solution` is then of no use.
  bool solve(const BlockVector& right, BlockVector& solution);

  /// Ratio of the largest to the smallest pivot: a lower estimate of the condition number; 0 where
  /// the matrix was not eliminated.
  double condition_estimate() const;

  const LinearSolverCounts& counts() const { return counts_; }  ///< since choose()

 private:
  bool is_large(const BlockSystem& system);

  const Slots* slots_;
  LinearSolverKind kind_ = LinearSolverKind::Elimination;
  Multifrontal elimination_;
  DistributedSolver* distributed_ = nullptr;
  bool shared_ = false;  ///< the present matrix is distributed_'s
  LinearSolverCounts counts_;
};

}  // namespace quoin::solver
