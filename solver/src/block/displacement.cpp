#include "block/displacement.hpp"

namespace quoin::solver {

Matrix3 strain_matrix(const Vector6& strain) {
  Matrix3 matrix;
  matrix << strain[0], 0.5 * strain[3], 0.5 * strain[5],  //
      0.5 * strain[3], strain[1], 0.5 * strain[4],        //
      0.5 * strain[5], 0.5 * strain[4], strain[2];
  return matrix;
}

Matrix3 cross_matrix(const Vector3& v) {
  Matrix3 matrix;
  matrix << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return matrix;
}

Eigen::Quaterniond cayley(const Vector3& theta) {
  Eigen::Quaterniond turn(1.0, 0.5 * theta.x(), 0.5 * theta.y(), 0.5 * theta.z());
  turn.normalize();
  return turn;
}

Pose pose(const BlockState& block) {
  Pose result;
  result.centroid = block.centroid;
  result.centroid_rest = block.centroid_rest;
  result.rotation = block.rotation.toRotationMatrix();
  result.shape = result.rotation + result.rotation * strain_matrix(block.strain);
  return result;
}

Vector3 between(const Pose& from, const Pose& to) {
  return (to.centroid - from.centroid) + (to.centroid_rest - from.centroid_rest);
}

void move_centroid(const Vector3& by, BlockState& block) {
  // the sum of two doubles and what its rounding leaves [Knuth 1969], twice
  const auto sum = [](double x, double y, double& rest) {
    const double z = x + y, part = z - x;
    rest = (x - (z - part)) + (y - part);
    return z;
  };
  for (int k = 0; k < 3; ++k) {
    double left = 0.0, rest = 0.0;
    const double place = sum(block.centroid[k], by[k], left);
    block.centroid[k] = sum(place, block.centroid_rest[k] + left, rest);
    block.centroid_rest[k] = rest;
  }
}

BlockState displaced(const BlockState& block, const Vector12& increment) {
  BlockState result = block;
  move_centroid(increment.head<3>(), result);
  result.rotation = (block.rotation * cayley(increment.segment<3>(3))).normalized();
  result.strain += increment.tail<6>();
  return result;
}

Matrix3x6 strain_motion(const Vector3& arm) {
  Matrix3x6 matrix;
  const double x = arm.x(), y = arm.y(), z = arm.z();
  matrix << x, 0, 0, 0.5 * y, 0, 0.5 * z,  //
      0, y, 0, 0.5 * x, 0.5 * z, 0,        //
      0, 0, z, 0, 0.5 * y, 0.5 * x;
  return matrix;
}

namespace {

/// Of the end of an arm of a block that is turned so.
Matrix3x12 rigid_motion(const Matrix3& rotation, const Vector3& arm) {
  Matrix3x12 matrix;
  matrix.leftCols<3>().setIdentity();
  for (int i = 0; i < 3; ++i) matrix.col(3 + i) = rotation.col(i).cross(arm);
  matrix.rightCols<6>().setZero();
  return matrix;
}

}  // namespace

Matrix3x12 mean_motion(const Pose& start, const Pose& end, const Vector3& theta,
                       const Vector3& reference_arm, bool deformable) {
  const Vector3 mean_arm = 0.5 * (start.shape * reference_arm + end.shape * reference_arm);
  Matrix3x12 matrix = rigid_motion(start.rotation, mean_arm);
  if (deformable) {
    const Matrix3 turned =
        start.rotation + 0.5 * cross_matrix(start.rotation * theta) * start.rotation;
    matrix.rightCols<6>() = turned * strain_motion(reference_arm);
  }
  return matrix;
}

Matrix3x12 motion(const Pose& pose, const Vector3& reference_arm, bool deformable) {
  Matrix3x12 matrix = rigid_motion(pose.rotation, pose.shape * reference_arm);
  if (deformable) matrix.rightCols<6>() = pose.rotation * strain_motion(reference_arm);
  return matrix;
}

}  // namespace quoin::solver
