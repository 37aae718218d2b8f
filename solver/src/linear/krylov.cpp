#include "linear/krylov.hpp"

#include <cmath>

namespace quoin::solver {
namespace {

template <int n>
double dot(const Blocks<n>& a, const Blocks<n>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
  return sum;
}

template <int n>
void add(double factor, const Blocks<n>& from, Blocks<n>& to) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += factor * from[i];
}

template <int n>
void scale(double factor, Blocks<n>& vector) {
  for (auto& block : vector) block *= factor;
}

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

template <int n>
KrylovResult minimise_residual(RigidMultigrid<n>& multigrid, const Blocks<n>& right,
                               const KrylovOptions& options, Blocks<n>& solution) {
  KrylovResult result;
  for (auto& block : solution) block.setZero();
  const double size = std::sqrt(dot(right, right));
  if (!(size > 0.0)) {
    result.converged = size == 0.0;
    return result;
  }
  std::vector<Blocks<n>> basis{right};
  scale(1.0 / size, basis[0]);
  LeastSquares problem(size);
  Blocks<n> preconditioned(right.size());
  while (result.iterations < options.most && !result.converged) {
    if (options.watch != nullptr) options.watch->look();
    multigrid.apply(basis.back(), preconditioned);
    Blocks<n> next(right.size());
    for (std::size_t i = 0; i < next.size(); ++i) {
      next[i] = multigrid.matrix().times(static_cast<int>(i), preconditioned);
    }
    std::vector<double> column;
    for (const Blocks<n>& vector : basis) {
      column.push_back(dot(next, vector));
      add(-column.back(), vector, next);
    }
    column.push_back(std::sqrt(dot(next, next)));
    if (!std::isfinite(column.back())) return result;
    const double length = column.back();
    ++result.iterations;
    result.residual = problem.add_column(std::move(column)) / size;
    result.converged = result.residual <= options.tolerance;
    if (length == 0.0) break;
    scale(1.0 / length, next);
    basis.push_back(std::move(next));
  }
  const std::vector<double> shares = problem.solve();
  Blocks<n> sum(right.size(), Eigen::Matrix<double, n, 1>::Zero());
  for (std::size_t k = 0; k < shares.size(); ++k) add(shares[k], basis[k], sum);
  multigrid.apply(sum, solution);
  return result;
}

template KrylovResult minimise_residual(RigidMultigrid<6>&, const Blocks<6>&, const KrylovOptions&,
                                        Blocks<6>&);
template KrylovResult minimise_residual(RigidMultigrid<12>&, const Blocks<12>&,
                                        const KrylovOptions&, Blocks<12>&);

}  // namespace quoin::solver
