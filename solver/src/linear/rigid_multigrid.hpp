#pragma once
/// Multigrid for tangents of blocks in contact, by smoothed aggregation. The coarse unknowns are
/// the six motions of a group of blocks as one rigid body, which strain no joint within it: every
/// level is again a system of 6×6 blocks.   [Vanek, Mandel & Brezina 1996]

#include <memory>
#include <span>

#include "linear/aggregation.hpp"
#include "linear/gauss_seidel.hpp"
#include "linear/multifrontal.hpp"

namespace quoin::solver {

/// One level: its smoother, which holds the matrix, and the way to the next.
template <int n>
struct MultigridLevel {
  GaussSeidel<n> smoother;
  BlockRows<n, 6> prolongation;
  BlockRows<6, n> restriction;  ///< its transpose
  Blocks<n> solution, right, residual;

  void make_room() {
    for (Blocks<n>* vector : {&solution, &right, &residual}) vector->resize(smoother.rows());
  }
};

/// The rows of a system; couplings that are zero are left out. Of rigid blocks among n = 12 the
/// strains are unknowns of their own.
template <int n>
BlockRows<n, n> block_rows(const Threads& threads, const BlockSystem& system, const Slots& slots);

/// The same as a system, not symmetric.
template <int n>
BlockSystem block_system(const BlockRows<n, n>& matrix);

/// `n`: unknowns of a block, 6 or 12 (the six of strain last).
template <int n>
class RigidMultigrid {
 public:
  /// From here on.
  void use(const Threads& threads) { threads_ = threads; }

  /// The matrix that is smoothed from here on; coarse ones are kept. False where a diagonal block
  /// is singular.
  bool exchange(BlockRows<n, n> matrix);

  /// Coarse levels of this matrix. `frames`: by row, where the rigid motions are taken from. False
  /// where the coarsest matrix is singular. `watch`, where there is one, is looked at, which then
  /// throws StepStopped.
  bool set_up(std::span<const Frame> frames, StepWatch* watch = nullptr);

  /// One V-cycle from zero; linear in `right`.
  void apply(const Blocks<n>& right, Blocks<n>& solution);
  /// The matrix times what apply() gave last.
  void multiply(const Blocks<n>& solution, Blocks<n>& product) const;

  const BlockRows<n, n>& matrix() const { return fine_.smoother.matrix(); }
  const Threads& threads() const { return threads_; }
  int levels() const { return static_cast<int>(coarse_.size()) + 1; }
  /// Blocks of all levels by those of the finest.
  double complexity() const;

 private:
  bool set_up_coarsest(StepWatch* watch);
  void solve_coarsest();
  void cycle(std::size_t coarse);

  Threads threads_;
  MultigridLevel<n> fine_;
  std::vector<MultigridLevel<6>> coarse_;
  Slots slots_;  ///< of the coarsest level
  std::unique_ptr<Multifrontal> direct_;
  BlockVector direct_right_, direct_solution_;
};

}  // namespace quoin::solver
