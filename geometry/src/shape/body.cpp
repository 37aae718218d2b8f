#include <algorithm>
#include <cmath>
#include <limits>
#include <quoin/geometry/body.hpp>

#include "numeric/double_double.hpp"

namespace quoin::geometry {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
/// What a product of rounded rotations is off, and below which their normals keep their length.
constexpr double kRigid = 8 * kEpsilon;

/// A row of linear · origin.
DoubleDouble turned(const Matrix3& linear, const Vector3& origin, int row) {
  DoubleDouble sum = 0.0;
  for (int k = 0; k < 3; ++k) sum = sum + two_product(linear(row, k), origin[k]);
  return sum;
}

Matrix3 cofactors_of(const Matrix3& a) {
  Matrix3 cofactors;
  cofactors.col(0) = a.col(1).cross(a.col(2));
  cofactors.col(1) = a.col(2).cross(a.col(0));
  cofactors.col(2) = a.col(0).cross(a.col(1));
  return cofactors;
}

// Without branches, which Eigen's comparisons make.
bool is_identity(const Matrix3& a) {
  const double* x = a.data();
  return (x[0] == 1.0) & (x[4] == 1.0) & (x[8] == 1.0) & (x[1] == 0.0) & (x[2] == 0.0) &
         (x[3] == 0.0) & (x[5] == 0.0) & (x[6] == 0.0) & (x[7] == 0.0);
}

double largest_difference(const Matrix3& a, const Matrix3& b) {
  double largest = 0.0;
  for (int k = 0; k < 9; ++k) {
    largest = std::max(largest, std::abs(a.data()[k] - b.data()[k]));
  }
  return largest;
}

/// Bound of the largest singular value: the largest row sum of its squares' matrix.
double largest_stretch(const Matrix3& a) {
  return std::sqrt((a.transpose() * a).cwiseAbs().rowwise().sum().maxCoeff());
}

}  // namespace

Body::Body(const Shape& shape) : shape_(&shape), turned_origin_(shape.origin()) {}

Body::Body(const Shape& shape, const Placement& placement) : shape_(&shape) { move(placement); }

void Body::move(const Placement& placement) {
  placement_ = placement;
  turned_origin_.setZero();
  turned_origin_rest_.setZero();
  if (const Vector3& origin = shape_->origin(); origin != Vector3::Zero()) {
    for (int k = 0; k < 3; ++k) {
      const DoubleDouble sum = turned(placement.linear, origin, k);
      turned_origin_[k] = sum.high;
      turned_origin_rest_[k] = sum.low;
    }
  }
  turned_ = !is_identity(placement.linear);
  if (!turned_) {
    cofactors_.setIdentity();
    rigid_ = true;
    stretch_ = 1.0;
    return;
  }
  cofactors_ = cofactors_of(placement.linear);
  rigid_ = largest_difference(cofactors_, placement.linear) <= kRigid;
  stretch_ = rigid_ ? 1.0 : largest_stretch(placement.linear);
}

}  // namespace quoin::geometry
