#pragma once
/// Direct solution of K x = f: dense for few unknowns, sparse for many.

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>

#include "block_system.hpp"

namespace quoin::solver {

/// Keeps its memory and the symbolic factorization while the pattern stays.
class LinearSolver {
 public:
  explicit LinearSolver(const Slots& slots) : slots_(&slots) {}

  /// L D L^T for a symmetric matrix, L U for another. False when it is singular to working accuracy, or
  /// symmetric and not positive definite.
  bool factorize(const BlockSystem& system);
  void solve(const BlockVector& right, BlockVector& solution);

  /// Few unknowns are solved without sparse structures.
  static bool is_dense(int unknowns) { return unknowns <= kDenseLimit; }

  /// Ratio of the largest to the smallest pivot: a lower estimate of the condition number.
  double condition_estimate() const;

 private:
  // Lower triangle of a symmetric matrix, or a whole one: each keeps its own pattern.
  struct Sparse {
    Eigen::SparseMatrix<double> matrix;
    std::vector<std::pair<int, int>> pairs;  // that the pattern was made for
  };

  bool dense() const { return is_dense(slots_->unknowns()); }
  bool factorize_dense(const BlockSystem& system);
  bool factorize_sparse(const BlockSystem& system);
  void build_pattern(const BlockSystem& system, Sparse& sparse);
  void fill_sparse(const BlockSystem& system, Sparse& sparse);

  static constexpr int kDenseLimit = 96;  // 8 deformable or 16 rigid blocks; chosen, not measured
  const Slots* slots_;
  bool symmetric_ = true;               // what was factorized last
  Eigen::MatrixXd matrix_;
  Eigen::LDLT<Eigen::MatrixXd> dense_;
  Eigen::PartialPivLU<Eigen::MatrixXd> dense_lu_;
  Eigen::VectorXd vector_, result_;
  Sparse lower_, whole_;
  std::vector<int> column_position_;    // of each column in the value array
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> simplicial_;
  Eigen::SparseLU<Eigen::SparseMatrix<double>> sparse_lu_;
};

}  // namespace quoin::solver
