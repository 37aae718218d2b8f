#pragma once
/// Direct solution of K x = f: dense for few unknowns, sparse for many.

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>

#include "block_system.hpp"

namespace quoin::solver {

/// Keeps its memory and the symbolic factorization while the pattern stays.
class LinearSolver {
 public:
  explicit LinearSolver(const Slots& slots) : slots_(&slots) {}

  /// False when the matrix is not positive definite to working accuracy.
  bool factorize(const BlockSystem& system);
  void solve(const BlockVector& right, BlockVector& solution);

  /// Ratio of the largest to the smallest pivot: a lower estimate of the condition number.
  double condition_estimate() const;

 private:
  bool dense() const { return slots_->unknowns() <= kDenseLimit; }
  void fill_dense(const BlockSystem& system);
  void build_pattern(const BlockSystem& system);
  void fill_sparse(const BlockSystem& system);

  static constexpr int kDenseLimit = 96;  // measured: above, the sparse factorization is faster
  const Slots* slots_;
  Eigen::MatrixXd matrix_;
  Eigen::LDLT<Eigen::MatrixXd> dense_;
  Eigen::VectorXd vector_, result_;
  Eigen::SparseMatrix<double> sparse_;  // lower triangle
  std::vector<std::pair<int, int>> pattern_;
  std::vector<int> column_position_;    // of each block column in the value array
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> simplicial_;
};

}  // namespace quoin::solver
