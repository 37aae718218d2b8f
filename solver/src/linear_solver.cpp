#include "linear_solver.hpp"

namespace quoin::solver {
namespace {

std::size_t index(int i) { return static_cast<std::size_t>(i); }

}  // namespace

bool LinearSolver::factorize(const BlockSystem& system) {
  const int n = slots_->unknowns();
  vector_.resize(n);
  result_.resize(n);
  symmetric_ = system.symmetric;
  return dense() ? factorize_dense(system) : factorize_sparse(system);
}

bool LinearSolver::factorize_dense(const BlockSystem& system) {
  const int n = slots_->unknowns();
  matrix_.setZero(n, n);
  for (std::size_t s = 0; s < system.diagonal.size(); ++s) {
    const int at = slots_->start[s], size = slots_->size[s];
    matrix_.block(at, at, size, size) = system.diagonal[s].topLeftCorner(size, size);
  }
  for (std::size_t p = 0; p < system.pairs.size(); ++p) {
    const std::size_t i = index(system.pairs[p].first), j = index(system.pairs[p].second);
    const int rows = slots_->size[i], columns = slots_->size[j];
    const auto upper = system.off_diagonal[p].topLeftCorner(rows, columns);
    auto lower = matrix_.block(slots_->start[j], slots_->start[i], columns, rows);
    if (symmetric_) {
      lower = upper.transpose();
    } else {
      matrix_.block(slots_->start[i], slots_->start[j], rows, columns) = upper;
      lower = system.mirrored[p].topLeftCorner(columns, rows);
    }
  }
  if (symmetric_) {
    dense_.compute(matrix_);
    return dense_.info() == Eigen::Success && dense_.isPositive();
  }
  dense_lu_.compute(matrix_);
  return dense_lu_.matrixLU().diagonal().cwiseAbs().minCoeff() > 0.0;
}

bool LinearSolver::factorize_sparse(const BlockSystem& system) {
  Sparse& sparse = symmetric_ ? lower_ : whole_;
  if (sparse.matrix.rows() != slots_->unknowns() || sparse.pairs != system.pairs) {
    build_pattern(system, sparse);
  }
  fill_sparse(system, sparse);
  if (symmetric_) {
    simplicial_.factorize(sparse.matrix);
    return simplicial_.info() == Eigen::Success && simplicial_.vectorD().minCoeff() > 0.0;
  }
  sparse_lu_.factorize(sparse.matrix);
  return sparse_lu_.info() == Eigen::Success;
}

// Column by column: blocks above (when not symmetric), the diagonal block, the blocks below, each in
// ascending order; fill_sparse runs in the same order.
void LinearSolver::build_pattern(const BlockSystem& system, Sparse& sparse) {
  const int n = slots_->unknowns();
  sparse.pairs = system.pairs;
  std::vector<Eigen::Triplet<double>> entries;
  const auto add_block = [&](std::size_t i, std::size_t j, bool lower_only) {
    for (int c = 0; c < slots_->size[j]; ++c) {
      for (int r = lower_only ? c : 0; r < slots_->size[i]; ++r) {
        entries.emplace_back(slots_->start[i] + r, slots_->start[j] + c, 0.0);
      }
    }
  };
  for (std::size_t s = 0; s < system.diagonal.size(); ++s) add_block(s, s, symmetric_);
  for (const auto& [first, second] : system.pairs) {
    add_block(index(second), index(first), false);
    if (!symmetric_) add_block(index(first), index(second), false);
  }
  sparse.matrix.resize(n, n);
  sparse.matrix.setFromTriplets(entries.begin(), entries.end());
  if (symmetric_) {
    simplicial_.analyzePattern(sparse.matrix);
  } else {
    sparse_lu_.analyzePattern(sparse.matrix);
  }
}

void LinearSolver::fill_sparse(const BlockSystem& system, Sparse& sparse) {
  double* values = sparse.matrix.valuePtr();
  const int* starts = sparse.matrix.outerIndexPtr();
  column_position_.assign(starts, starts + sparse.matrix.cols());
  const auto put = [&](std::size_t i, std::size_t j, const Matrix12& block, bool transposed,
                       bool lower_only) {
    for (int c = 0; c < slots_->size[j]; ++c) {
      int& at = column_position_[index(slots_->start[j] + c)];
      for (int r = lower_only ? c : 0; r < slots_->size[i]; ++r) {
        values[at++] = transposed ? block(c, r) : block(r, c);
      }
    }
  };
  if (!symmetric_) {
    for (std::size_t p = 0; p < system.pairs.size(); ++p) {
      put(index(system.pairs[p].first), index(system.pairs[p].second), system.off_diagonal[p],
          false, false);
    }
  }
  for (std::size_t s = 0; s < system.diagonal.size(); ++s) {
    put(s, s, system.diagonal[s], false, symmetric_);
  }
  for (std::size_t p = 0; p < system.pairs.size(); ++p) {
    const Matrix12& block = symmetric_ ? system.off_diagonal[p] : system.mirrored[p];
    put(index(system.pairs[p].second), index(system.pairs[p].first), block, symmetric_, false);
  }
}

void LinearSolver::solve(const BlockVector& right, BlockVector& solution) {
  for (std::size_t s = 0; s < right.size(); ++s) {
    vector_.segment(slots_->start[s], slots_->size[s]) = right[s].head(slots_->size[s]);
  }
  if (dense()) {
    if (symmetric_) {
      result_ = dense_.solve(vector_);
    } else {
      result_ = dense_lu_.solve(vector_);
    }
  } else if (symmetric_) {
    result_ = simplicial_.solve(vector_);
  } else {
    result_ = sparse_lu_.solve(vector_);
  }
  for (std::size_t s = 0; s < solution.size(); ++s) {
    solution[s].setZero();
    solution[s].head(slots_->size[s]) = result_.segment(slots_->start[s], slots_->size[s]);
  }
}

double LinearSolver::condition_estimate() const {
  if (slots_->unknowns() == 0) return 1.0;
  if (!symmetric_) {
    if (!dense()) return 0.0;  // the sparse factors do not show their pivots
    const Eigen::ArrayXd pivots = dense_lu_.matrixLU().diagonal().array().abs();
    return pivots.maxCoeff() / pivots.minCoeff();
  }
  const Eigen::VectorXd pivots =
      dense() ? Eigen::VectorXd(dense_.vectorD()) : Eigen::VectorXd(simplicial_.vectorD());
  return pivots.maxCoeff() / pivots.minCoeff();
}

}  // namespace quoin::solver
