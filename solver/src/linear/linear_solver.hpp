#pragma once
/// Solution of K x = f for a sparse matrix of blocks, by elimination or by iterations.

#include <quoin/solver/simulation.hpp>

#include "distributed/distributed_solver.hpp"
#include "linear/krylov.hpp"

namespace quoin::solver {

/// Chooses between elimination and multigrid for each matrix; see solver/README.md, "Linear
/// systems". Keeps the memory of the one that solved the last matrix.
class LinearSolver {
 public:
  /// Eliminates, until choose() says otherwise. `watch`, where there is one, is looked at during
  /// factorize(), which then throws StepStopped.
  explicit LinearSolver(const Slots& slots, StepWatch* watch = nullptr)
      : slots_(&slots), watch_(watch), elimination_(slots, watch) {
    forget();
  }

  /// From the next matrix on; counts start at zero. `distributed`, where there is one, solves what
  /// Automatic does not eliminate; it must outlive the use of this object. Where it is of several
  /// processes each gives the rows of its own blocks alone, and what is not distributed is gathered
  /// on all of them.
  void choose(LinearSolverKind kind, DistributedSolver* distributed = nullptr) {
    kind_ = kind;
    distributed_ = distributed;
    agreement_ = Agreement(distributed);
    counts_ = {};
  }

  /// Nothing of earlier matrices is used from here on but what hangs on the pattern alone: what
  /// follows is the same to the bit whatever was solved before.
  void forget();

  /// From the next matrix on.
  void use(const Threads& threads) {
    threads_ = threads;
    elimination_.use(threads);
  }

  /// False when it is singular to working accuracy, or symmetric, eliminated and not positive
  /// definite.
  bool factorize(const BlockSystem& system) { return factorize(system, nullptr); }
  /// The same of a matrix that, where it is not symmetric, is solved once, for `only`: that takes
  /// half the memory.
  bool factorize(const BlockSystem& system, const BlockVector& only) {
    return factorize(system, &only);
  }

  /// Iterations end at a residual of 1e-8 of `right`; where they do not reach it the matrix is
  /// eliminated. False where that fails, too: `solution` is then of no use.
  bool solve(const BlockVector& right, BlockVector& solution);

  /// Ratio of the largest to the smallest pivot: a lower estimate of the condition number; 0 where
  /// the matrix was not eliminated.
  double condition_estimate() const;

  const LinearSolverCounts& counts() const { return counts_; }  ///< since choose()

 private:
  bool factorize(const BlockSystem& system, const BlockVector* only);
  bool factorize_here(const BlockSystem& system, const BlockVector* only);
  void gather_pairs(const BlockSystem& own);
  void gather_blocks(const BlockSystem& own);
  bool eliminate(const BlockSystem& system, const BlockVector* only);
  template <int n>
  bool prepare(RigidMultigrid<n>& multigrid);
  template <int n>
  struct Iterations {
    RigidMultigrid<n> multigrid;
    MinimalResidual<n> krylov;
    Blocks<n> right, solution;
  };
  template <int n>
  bool iterate(Iterations<n>& with, const BlockVector& right, BlockVector& solution);
  int most_iterations(double complexity) const;
  void pay(int iterations, double complexity);
  bool wants_multigrid(const BlockSystem& system);
  bool iterates(const BlockSystem& system);
  void release_multigrid();
  void release_values();
  bool distributes(const BlockSystem& system);

  const Slots* slots_;
  StepWatch* watch_;
  LinearSolverKind kind_ = LinearSolverKind::Elimination;
  Multifrontal elimination_;
  DistributedSolver* distributed_ = nullptr;
  Agreement agreement_;
  BlockSystem whole_;    ///< of several processes: gathered
  bool shared_ = false;  ///< the present matrix is distributed_'s
  Threads threads_;
  Iterations<6> rigid_;
  Iterations<12> deformable_;
  std::vector<Frame> frames_;   ///< of the present matrix
  bool once_ = false;           ///< the present matrix is solved once
  bool iterates_ = false;       ///< it is the multigrid's
  bool has_multigrid_ = false;  ///< there is memory of it
  bool prepared_ = false;       ///< the hierarchy is of this matrix or an earlier one
  bool lagging_ = false;        ///< of an earlier one
  int fresh_iterations_ = 0;    ///< of the first solution with a new hierarchy
  double work_ = 0.0;           ///< of an elimination, multiplications a block
  double credit_ = 0.0;         ///< eliminations that iterations may take longer than they save
  bool saves_ = false;          ///< the present matrix's elimination, where iterations converge
  LinearSolverCounts counts_;
};

}  // namespace quoin::solver
