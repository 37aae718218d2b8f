/// The dense product against one written out, bit by bit.

#include "solver/src/subtract_product.hpp"
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
  SubtractProduct subtract;
  for (const int rows : {1, 5, 16, 23, 24, 41, 96}) {
    for (const int depth : {0, 1, 6, 300}) {
      const int columns = rows == 41 ? 13 : rows;
      const Eigen::MatrixXd a = drawn(random, rows, depth), b = drawn(random, columns, depth);
      const Eigen::MatrixXd start = drawn(random, rows, columns);
      Eigen::MatrixXd expected = start;
      for (int j = 0; j < columns; ++j) {
        for (int i = 0; i < rows; ++i) {
          for (int k = 0; k < depth; ++k) expected(i, j) -= a(i, k) * b(j, k);
        }
      }
      Eigen::MatrixXd whole = start, lower = start;
      subtract({a.data(), 1, rows}, {b.data(), columns, 1}, depth, Triangle::Both, whole);
      CHECK(whole == expected);
      if (rows != columns) continue;
      subtract({a.data(), 1, rows}, {b.data(), columns, 1}, depth, Triangle::Lower, lower);
      for (int j = 0; j < columns; ++j) {
        for (int i = j; i < rows; ++i) REQUIRE(lower(i, j) == expected(i, j));
      }
    }
  }
}
