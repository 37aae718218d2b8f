/// The dense product against one written out, bit by bit.

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

}  // namespace

TEST_CASE("Every entry takes its products one after the other, whatever the vectors") {
  Random random(1);
  for (const int rows : {1, 5, 6, 16, 23, 24, 41, 96}) {
    for (const int depth : {0, 1, 6, 300}) {
      constexpr int kColumns = 12;
      const Eigen::MatrixXd a = drawn(random, rows, depth), b = drawn(random, kColumns, depth);
      Eigen::MatrixXd c = drawn(random, rows, kColumns), expected = c;
      for (int j = 0; j < kColumns; ++j)
        for (int i = 0; i < rows; ++i)
          for (int k = 0; k < depth; ++k) expected(i, j) -= a(i, k) * b(j, k);
      subtract_product(a, transposed(b), c);
      CHECK(c == expected);
    }
  }
}
