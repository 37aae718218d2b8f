/// A block's own matrices: inverses of known ones, and of those that are not positive definite.

#include "solver/src/linear/small_matrices.hpp"

#include <Eigen/Dense>
#include <cmath>

#include "support/catch.hpp"
#include "support/random.hpp"

using namespace quoin::solver;
using namespace quoin::tests;

namespace {

/// Q D Q' with eigenvalues from 1 down to 1 / `condition`.
Eigen::MatrixXd definite(Random& random, int n, double condition) {
  Eigen::MatrixXd drawn(n, n);
  for (double& x : drawn.reshaped()) x = random.uniform(-1, 1);
  const Eigen::MatrixXd q = Eigen::HouseholderQR<Eigen::MatrixXd>(drawn).householderQ();
  Eigen::VectorXd d(n);
  for (int k = 0; k < n; ++k) d[k] = std::pow(condition, -static_cast<double>(k) / (n - 1));
  const Eigen::MatrixXd result = q * d.asDiagonal() * q.transpose();
  return 0.5 * (result + result.transpose());
}

}  // namespace

TEST_CASE("The inverse of a positive definite matrix is right to its condition") {
  Random random(1);
  for (const int n : {2, 3, 6, 9, 12}) {
    for (const double condition : {1.0, 1e4, 1e10}) {
      const Eigen::MatrixXd matrix = definite(random, n, condition);
      Eigen::MatrixXd inverse(n, n);
      REQUIRE(invert_symmetric(matrix, inverse));
      const Eigen::MatrixXd rest = inverse * matrix - Eigen::MatrixXd::Identity(n, n);
      CHECK(rest.cwiseAbs().maxCoeff() <= 100 * 2.2e-16 * condition);
    }
  }
}

TEST_CASE("Units of rows do not matter: strains beside metres") {
  Random random(2);
  const Eigen::MatrixXd matrix = definite(random, 12, 100.0);
  Eigen::VectorXd unit = Eigen::VectorXd::Ones(12);
  unit.tail(6).setConstant(1e6);
  Eigen::MatrixXd inverse(12, 12), scaled(12, 12);
  REQUIRE(invert_symmetric(matrix, inverse));
  REQUIRE(invert_symmetric(unit.asDiagonal() * matrix * unit.asDiagonal(), scaled));
  const Eigen::MatrixXd back = unit.asDiagonal() * scaled * unit.asDiagonal();
  CHECK((back - inverse).cwiseAbs().maxCoeff() <= 1e-12 * inverse.cwiseAbs().maxCoeff());
}

TEST_CASE("Rows whose pivots are not positive are zero, the others as if these were not there") {
  Eigen::Matrix3d matrix;
  matrix << 4, 0, 1, 0, 0, 0, 1, 0, 2;
  Eigen::MatrixXd inverse(3, 3);
  CHECK_FALSE(invert_symmetric(matrix, inverse));
  Eigen::Matrix3d expected;
  expected << 2, 0, -1, 0, 0, 0, -1, 0, 4;
  CHECK((7.0 * inverse - expected).cwiseAbs().maxCoeff() <= 1e-14);
  matrix(1, 1) = -1.0;
  CHECK_FALSE(invert_symmetric(matrix, inverse));
  CHECK((7.0 * inverse - expected).cwiseAbs().maxCoeff() <= 1e-14);
}
