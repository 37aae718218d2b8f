#include "linear/aggregation.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

#include "base/index.hpp"

namespace quoin::solver {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Share of the stiffest coupling of a row. Chosen on the tangents of bench/large.md.
constexpr double kStiff = 0.1;

/// Of a row, its entries' numbers.
struct Entries {
  std::size_t first, last;
};

Entries entries(const BlockRows<6, 6>& matrix, std::size_t row) {
  return {index(matrix.start[row]), index(matrix.start[row + 1])};
}

/// L of each diagonal block's symmetric part.
std::vector<Matrix6> diagonal_factors(const BlockRows<6, 6>& matrix) {
  std::vector<Matrix6> factors(index(matrix.rows()), Matrix6::Zero());
  for (std::size_t i = 0; i < factors.size(); ++i) {
    for (auto [k, last] = entries(matrix, i); k < last; ++k) {
      if (matrix.column[k] != static_cast<int>(i)) continue;
      const Matrix6 symmetric = 0.5 * (matrix.value[k] + matrix.value[k].transpose());
      factors[i] = symmetric.llt().matrixL();
    }
  }
  return factors;
}

/// Grows groups on a matrix whose couplings are known.
class Grouping {
 public:
  explicit Grouping(const BlockRows<6, 6>& matrix) : matrix_(matrix), coupling_(couplings(matrix)) {
    groups_.of.assign(index(matrix.rows()), -1);
    stiffest_.assign(groups_.of.size(), 0.0);
    for (std::size_t i = 0; i < stiffest_.size(); ++i) {
      for (auto [k, last] = entries(matrix_, i); k < last; ++k) {
        stiffest_[i] = std::max(stiffest_[i], coupling_[k]);
      }
    }
  }

  Aggregates grow() {
    for (std::size_t i = 0; i < groups_.of.size(); ++i) {
      if (alone(i)) take_neighbours(i);
    }
    join_neighbours();
    for (std::size_t i = 0; i < groups_.of.size(); ++i) {
      if (groups_.of[i] < 0 && coupled(i)) take_neighbours(i);
    }
    return std::move(groups_);
  }

 private:
  bool stiff(std::size_t i, std::size_t k) const {
    const std::size_t j = index(matrix_.column[k]);
    return j != i && coupling_[k] > kStiff * std::min(stiffest_[i], stiffest_[j]);
  }

  /// Neither it nor a stiff neighbour is in a group, and it has such neighbours.
  bool alone(std::size_t i) const {
    if (groups_.of[i] >= 0) return false;
    bool any = false;
    for (auto [k, last] = entries(matrix_, i); k < last; ++k) {
      if (!stiff(i, k)) continue;
      if (groups_.of[index(matrix_.column[k])] >= 0) return false;
      any = true;
    }
    return any;
  }

  bool coupled(std::size_t i) const {
    const auto [first, last] = entries(matrix_, i);
    return last - first > 1;
  }

  void take_neighbours(std::size_t i) {
    groups_.of[i] = groups_.count;
    for (auto [k, last] = entries(matrix_, i); k < last; ++k) {
      int& group = groups_.of[index(matrix_.column[k])];
      if (stiff(i, k) && group < 0) group = groups_.count;
    }
    ++groups_.count;
  }

  /// Rows that are left, to the group of their stiffest neighbour.
  void join_neighbours() {
    const std::vector<int> first = groups_.of;
    for (std::size_t i = 0; i < first.size(); ++i) {
      if (first[i] >= 0) continue;
      double most = 0.0;
      for (auto [k, last] = entries(matrix_, i); k < last; ++k) {
        const int group = first[index(matrix_.column[k])];
        if (group < 0 || !stiff(i, k) || coupling_[k] <= most) continue;
        most = coupling_[k];
        groups_.of[i] = group;
      }
    }
  }

  const BlockRows<6, 6>& matrix_;
  std::vector<double> coupling_;  // by entry
  std::vector<double> stiffest_;  // by row
  Aggregates groups_;
};

}  // namespace

std::vector<double> couplings(const BlockRows<6, 6>& matrix) {
  const std::vector<Matrix6> factors = diagonal_factors(matrix);
  std::vector<double> result(matrix.value.size(), 0.0);
  for (std::size_t i = 0; i < factors.size(); ++i) {
    for (auto [k, last] = entries(matrix, i); k < last; ++k) {
      const std::size_t j = index(matrix.column[k]);
      if (j == i) continue;
      const Matrix6 inverse = factors[j].transpose() * matrix.value[k].inverse() * factors[i];
      const double size = inverse.norm();
      if (size < 1e12) result[k] = 1.0 / size;  // else singular to rounding, or not finite
    }
  }
  return result;
}

Aggregates aggregate(const BlockRows<6, 6>& matrix) { return Grouping(matrix).grow(); }

}  // namespace quoin::solver
