#include "linear/krylov.hpp"

#include <cmath>

namespace quoin::solver {
namespace {

/// Upper triangle of the least-squares problem, made column by column with plane rotations.
class LeastSquares {
 public:
  explicit LeastSquares(double start) : right_{start} {}

  /// The next column of the Hessenberg matrix; returns the residual that is left.
  double add_column(std::vector<double> column) {
    for (std::size_t i = 0; i < cosines_.size(); ++i) {
      const double a = column[i], b = column[i + 1];
      column[i] = cosines_[i] * a + sines_[i] * b;
      column[i + 1] = cosines_[i] * b - sines_[i] * a;
    }
    const std::size_t last = cosines_.size();
    const double size = std::hypot(column[last], column[last + 1]);
    cosines_.push_back(column[last] / size);
    sines_.push_back(column[last + 1] / size);
    column[last] = size;
    right_.push_back(-sines_[last] * right_[last]);
    right_[last] *= cosines_[last];
    columns_.push_back(std::move(column));
    return std::abs(right_.back());
  }

  std::vector<double> solve() const {
    std::vector<double> x(columns_.size());
    for (std::size_t i = x.size(); i-- > 0;) {
      x[i] = right_[i];
      for (std::size_t j = i + 1; j < x.size(); ++j) x[i] -= columns_[j][i] * x[j];
      x[i] /= columns_[i][i];
    }
    return x;
  }

 private:
  std::vector<double> right_, cosines_, sines_;
  std::vector<std::vector<double>> columns_;
};

}  // namespace

/// Takes from the vector after the first `count` what it has along them; returns how much, and its
/// length at last.
template <int n>
std::vector<double> MinimalResidual<n>::orthogonalise(const Threads& threads, std::size_t count) {
  Blocks<n>& next = basis_[count];
  const std::size_t rows = next.size();
  std::vector<double> column(count + 1);
  column[0] = threads.sum(rows, pieces_, [&](std::size_t i) { return next[i].dot(basis_[0][i]); });
  for (std::size_t k = 0; k < count; ++k) {
    const double along = column[k];
    const Blocks<n>&taken = basis_[k], &then = basis_[k + 1];
    column[k + 1] = threads.sum(rows, pieces_, [&](std::size_t i) {
      next[i] -= along * taken[i];
      return next[i].dot(then[i]);
    });
  }
  column[count] = std::sqrt(column[count]);  // with itself
  return column;
}

template <int n>
KrylovResult MinimalResidual<n>::solve(RigidMultigrid<n>& multigrid, const Blocks<n>& right,
                                       const KrylovOptions& options, Blocks<n>& solution) {
  const Threads& threads = multigrid.threads();
  const std::size_t rows = right.size();
  const auto make_vector = [&](std::size_t k) -> Blocks<n>& {
    if (basis_.size() == k) basis_.emplace_back();
    basis_[k].resize(rows);
    return basis_[k];
  };
  KrylovResult result;
  for (auto& block : solution) block.setZero();
  const double size =
      std::sqrt(threads.sum(rows, pieces_, [&](std::size_t i) { return right[i].squaredNorm(); }));
  if (!(size > 0.0)) {
    result.converged = size == 0.0;
    return result;
  }
  Blocks<n>& first = make_vector(0);
  threads.each(rows, [&](std::size_t i) { first[i] = right[i] / size; });
  preconditioned_.resize(rows);
  LeastSquares problem(size);
  while (result.iterations < options.most && !result.converged) {
    if (options.watch != nullptr) options.watch->look();
    const auto at = static_cast<std::size_t>(result.iterations);
    Blocks<n>& next = make_vector(at + 1);
    multigrid.apply(basis_[at], preconditioned_);
    multigrid.multiply(preconditioned_, next);
    std::vector<double> column = orthogonalise(threads, at + 1);
    const double length = column.back();
    if (!std::isfinite(length)) return result;
    ++result.iterations;
    result.residual = problem.add_column(std::move(column)) / size;
    result.converged = result.residual <= options.tolerance;
    if (length == 0.0) break;
    threads.each(rows, [&](std::size_t i) { next[i] /= length; });
  }
  const std::vector<double> shares = problem.solve();
  threads.each(rows, [&](std::size_t i) {
    preconditioned_[i].setZero();
    for (std::size_t k = 0; k < shares.size(); ++k) preconditioned_[i] += shares[k] * basis_[k][i];
  });
  multigrid.apply(preconditioned_, solution);
  return result;
}

template class MinimalResidual<6>;
template class MinimalResidual<12>;

}  // namespace quoin::solver
