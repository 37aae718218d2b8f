#pragma once
/// Block Gauss–Seidel by colours: rows of one colour are not coupled, so they go side by side.

#include "linear/block_rows.hpp"

namespace quoin::solver {

/// One sweep there and one back, each with half of the products that a sweep over whole rows takes:
/// there from zero only rows of earlier colours count, and what they leave is of the later ones.
template <int n>
class GaussSeidel {
 public:
  using Square = Eigen::Matrix<double, n, n>;

  /// False where a diagonal block is singular to rounding.
  bool set(BlockRows<n, n> matrix, const Threads& threads);

  const BlockRows<n, n>& matrix() const { return matrix_; }
  const std::vector<Square>& inverse() const { return inverse_; }  ///< of the diagonal blocks
  std::size_t rows() const { return inverse_.size(); }

  /// From zero; `residual`: right - A solution.
  void there(const Threads& threads, const Blocks<n>& right, Blocks<n>& solution,
             Blocks<n>& residual) const;
  void back(const Threads& threads, const Blocks<n>& right, Blocks<n>& solution);
  /// A solution, right after back().
  void multiply(const Threads& threads, const Blocks<n>& solution, Blocks<n>& product) const;

 private:
  using Vector = Eigen::Matrix<double, n, 1>;

  void set_colours();
  void set_own();
  bool invert(const Threads& threads);
  Vector times(int first, int end, const Blocks<n>& x) const;
  Vector earlier(std::size_t row, const Blocks<n>& x) const {
    return times(matrix_.start[row], own_[row], x);
  }
  Vector later(std::size_t row, const Blocks<n>& x) const {
    return times(own_[row] + 1, matrix_.start[row + 1], x);
  }

  BlockRows<n, n> matrix_;       // entries of a row: of earlier colours, its own, of later colours
  std::vector<int> own_;         // by row, its diagonal entry
  std::vector<Square> inverse_;  // of the diagonal blocks
  std::vector<int> order_;       // rows by colour
  std::vector<std::size_t> colour_start_;  // in order_, and its end
  std::vector<int> colour_, taken_;        // by row; memory of set_colours()
  Blocks<n> later_;                        // by row, of the solution that back() ended with
};

}  // namespace quoin::solver
