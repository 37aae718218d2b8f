/// Kinematics of one block: Cayley rotation, exact displacement of points, velocities.

#include <cmath>

#include "solver/src/block/displacement.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"

using namespace quoin::solver;
using namespace quoin::tests;

namespace {

Vector12 random_vector(Random& random, double size) {
  Vector12 v;
  for (double& x : v) x = random.uniform(-size, size);
  return v;
}

BlockState random_block(Random& random) {
  const Vector12 v = random_vector(random, 1.0);
  BlockState block;
  block.centroid = 10.0 * v.head<3>();
  block.rotation = cayley(3.0 * v.segment<3>(3));
  block.strain = 0.1 * v.tail<6>();
  return block;
}

Vector3 place(const BlockState& block, const Vector3& arm) {
  const Pose now = pose(block);
  return now.centroid + now.shape * arm;
}

}  // namespace

TEST_CASE("Cayley rotation turns by twice the arc tangent of half the vector") {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Vector3 theta = random_vector(random, 4.0).head<3>();
    const Matrix3 turn = cayley(theta).toRotationMatrix();
    const Matrix3 exact = Eigen::AngleAxisd(2.0 * std::atan(0.5 * theta.norm()), theta.normalized())
                              .toRotationMatrix();
    CHECK((turn - exact).norm() < 1e-14);
    // cay(theta) = (I - [theta]/2)^-1 (I + [theta]/2): the mean of start and end turns about theta.
    const Vector3 v(1, 2, 3);
    CHECK((turn * v - v - theta.cross(0.5 * (turn * v + v))).norm() < 1e-13);
    CHECK((cayley(-theta) * (turn * v) - v).norm() < 1e-14);
  }
}

TEST_CASE("Mean motion times the increment is the exact displacement of a point, however large") {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const BlockState start = random_block(random);
    Vector12 increment = random_vector(random, i < 100 ? 1.0 : 1e-3);
    const bool deformable = i % 2 == 0;
    if (!deformable) increment.tail<6>().setZero();
    const BlockState end = displaced(start, increment);
    const Vector3 arm = random_vector(random, 2.0).head<3>();
    const Matrix3x12 t =
        mean_motion(pose(start), pose(end), increment.segment<3>(3), arm, deformable);
    CHECK((t * increment - (place(end, arm) - place(start, arm))).norm() < 1e-13);
    if (!deformable) CHECK(t.rightCols<6>().isZero(0.0));
  }
}
