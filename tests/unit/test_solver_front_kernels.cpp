/// The dense kernels against ones written out, bit by bit.

#include <Eigen/Core>

#include "solver/src/linear/front_kernels.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"

using namespace quoin::solver;
using namespace quoin::tests;

namespace {

Eigen::MatrixXd drawn(Random& random, int rows, int columns) {
  Eigen::MatrixXd result(rows, columns);
  for (double& x : result.reshaped()) x = random.uniform(-1, 1);
  return result;
}

Columns whole(Eigen::MatrixXd& matrix) {
  return {matrix.data(), matrix.rows(), static_cast<int>(matrix.rows()),
          static_cast<int>(matrix.cols())};
}

}  // namespace

TEST_CASE("Every entry takes its products one after the other, whatever the vectors") {
  Random random(1);
  for (const int rows : {1, 5, 6, 16, 23, 24, 41, 96}) {
    for (const int depth : {0, 1, 6, 300}) {
      const int columns = rows == 41 ? 13 : rows;
      Eigen::MatrixXd a = drawn(random, rows, depth), b = drawn(random, columns, depth);
      const Eigen::MatrixXd start = drawn(random, rows, columns);
      Eigen::MatrixXd expected = start;
      for (int j = 0; j < columns; ++j) {
        for (int i = 0; i < rows; ++i)
          for (int k = 0; k < depth; ++k) expected(i, j) -= a(i, k) * b(j, k);
      }
      Eigen::MatrixXd both = start, lower = start;
      subtract_product(whole(a), transposed(whole(b)), Triangle::Both, whole(both));
      CHECK(both == expected);
      subtract_product(whole(a), transposed(whole(b)), Triangle::Lower, whole(lower));
      for (int j = 0; j < columns; ++j)
        for (int i = j; i < rows; ++i) REQUIRE(lower(i, j) == expected(i, j));
    }
  }
}

TEST_CASE("Rows are solved one unknown after the other, whatever the vectors") {
  Random random(2);
  for (const int rows : {0, 1, 6, 14, 30, 31}) {
    Eigen::MatrixXd upper = drawn(random, kPanel, kPanel), x = drawn(random, rows, kPanel);
    const Eigen::VectorXd reciprocals = drawn(random, kPanel, 1);
    for (const double* scale : {reciprocals.data(), static_cast<const double*>(nullptr)}) {
      Eigen::MatrixXd expected = x, solved = x;
      for (int i = 0; i < rows; ++i) {
        for (int k = 0; k < kPanel; ++k) {
          if (scale != nullptr) expected(i, k) *= scale[k];
          for (int j = k + 1; j < kPanel; ++j) expected(i, j) -= expected(i, k) * upper(k, j);
        }
      }
      solve_panel(as_is(whole(upper)), scale, whole(solved));
      CHECK(solved == expected);
    }
  }
}
