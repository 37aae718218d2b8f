#include "linear_solver.hpp"

namespace quoin::solver {

bool LinearSolver::factorize(const BlockSystem& system) {
  const int n = slots_->unknowns();
  vector_.resize(n);
  result_.resize(n);
  if (dense()) {
    fill_dense(system);
    dense_.compute(matrix_);
    return dense_.info() == Eigen::Success && dense_.isPositive();
  }
  if (sparse_.rows() != n || pattern_ != system.pairs) build_pattern(system);
  fill_sparse(system);
  simplicial_.factorize(sparse_);
  return simplicial_.info() == Eigen::Success && simplicial_.vectorD().minCoeff() > 0.0;
}

void LinearSolver::fill_dense(const BlockSystem& system) {
  const int n = slots_->unknowns();
  matrix_.setZero(n, n);
  for (int s = 0; s < slots_->count(); ++s) {
    const auto i = static_cast<std::size_t>(s);
    matrix_.block(slots_->start[i], slots_->start[i], slots_->size[i], slots_->size[i]) =
        system.diagonal[i].topLeftCorner(slots_->size[i], slots_->size[i]);
  }
  for (std::size_t p = 0; p < system.pairs.size(); ++p) {
    const auto i = static_cast<std::size_t>(system.pairs[p].first);
    const auto j = static_cast<std::size_t>(system.pairs[p].second);
    matrix_.block(slots_->start[j], slots_->start[i], slots_->size[j], slots_->size[i]) =
        system.off_diagonal[p].topLeftCorner(slots_->size[i], slots_->size[j]).transpose();
  }
}

// Column by column: the diagonal block's lower part, then the blocks below it in ascending order.
void LinearSolver::build_pattern(const BlockSystem& system) {
  const int n = slots_->unknowns();
  pattern_ = system.pairs;
  std::vector<Eigen::Triplet<double>> entries;
  for (int s = 0; s < slots_->count(); ++s) {
    const auto i = static_cast<std::size_t>(s);
    for (int c = 0; c < slots_->size[i]; ++c) {
      for (int r = c; r < slots_->size[i]; ++r) {
        entries.emplace_back(slots_->start[i] + r, slots_->start[i] + c, 0.0);
      }
    }
  }
  for (const auto& [first, second] : system.pairs) {
    const auto i = static_cast<std::size_t>(first);
    const auto j = static_cast<std::size_t>(second);
    for (int c = 0; c < slots_->size[i]; ++c) {
      for (int r = 0; r < slots_->size[j]; ++r) {
        entries.emplace_back(slots_->start[j] + r, slots_->start[i] + c, 0.0);
      }
    }
  }
  sparse_.resize(n, n);
  sparse_.setFromTriplets(entries.begin(), entries.end());
  simplicial_.analyzePattern(sparse_);
}

void LinearSolver::fill_sparse(const BlockSystem& system) {
  double* values = sparse_.valuePtr();
  const int* starts = sparse_.outerIndexPtr();
  column_position_.assign(starts, starts + sparse_.cols());
  for (int s = 0; s < slots_->count(); ++s) {
    const auto i = static_cast<std::size_t>(s);
    for (int c = 0; c < slots_->size[i]; ++c) {
      int& at = column_position_[static_cast<std::size_t>(slots_->start[i] + c)];
      for (int r = c; r < slots_->size[i]; ++r) values[at++] = system.diagonal[i](r, c);
    }
  }
  for (std::size_t p = 0; p < system.pairs.size(); ++p) {
    const auto i = static_cast<std::size_t>(system.pairs[p].first);
    const auto j = static_cast<std::size_t>(system.pairs[p].second);
    for (int c = 0; c < slots_->size[i]; ++c) {
      int& at = column_position_[static_cast<std::size_t>(slots_->start[i] + c)];
      for (int r = 0; r < slots_->size[j]; ++r) values[at++] = system.off_diagonal[p](c, r);
    }
  }
}

void LinearSolver::solve(const BlockVector& right, BlockVector& solution) {
  for (int s = 0; s < slots_->count(); ++s) {
    const auto i = static_cast<std::size_t>(s);
    vector_.segment(slots_->start[i], slots_->size[i]) = right[i].head(slots_->size[i]);
  }
  if (dense()) {
    result_ = dense_.solve(vector_);
  } else {
    result_ = simplicial_.solve(vector_);
  }
  for (int s = 0; s < slots_->count(); ++s) {
    const auto i = static_cast<std::size_t>(s);
    solution[i].setZero();
    solution[i].head(slots_->size[i]) = result_.segment(slots_->start[i], slots_->size[i]);
  }
}

double LinearSolver::condition_estimate() const {
  if (slots_->unknowns() == 0) return 1.0;
  const Eigen::VectorXd pivots =
      dense() ? Eigen::VectorXd(dense_.vectorD()) : Eigen::VectorXd(simplicial_.vectorD());
  return pivots.maxCoeff() / pivots.minCoeff();
}

}  // namespace quoin::solver
