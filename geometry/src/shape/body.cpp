#include <algorithm>
#include <cmath>
#include <limits>
#include <quoin/geometry/body.hpp>

#include "numeric/double_double.hpp"
#include "numeric/floating_point.hpp"

namespace quoin::geometry {
namespace {

/// What a product of rounded rotations is off, and below which their normals keep their length.
constexpr double kRigid = 8 * kEpsilon;

/// A row of linear · origin.
DoubleDouble turned(const Matrix3& linear, const Vector3& origin, int row) {
  DoubleDouble sum = 0.0;
  for (int k = 0; k < 3; ++k) sum = sum + two_product(linear(row, k), origin[k]);
  return sum;
}

/// Writes the matrix of cofactors and tells whether it is the matrix itself within rounding. In
/// plain numbers, which are compared where they were made: what is written number by number and
/// read in pairs waits.
bool take_cofactors(const Matrix3& matrix, Matrix3& cofactors) {
  const double* a = matrix.data();
  double* to = cofactors.data();
  bool same = true;
  const auto take = [&](int k, double value) {
    same = same & (std::abs(value - a[k]) <= kRigid);
    to[k] = value;
  };
  const auto cross = [&](int column, int u, int v) {
    take(column, a[u + 1] * a[v + 2] - a[u + 2] * a[v + 1]);
    take(column + 1, a[u + 2] * a[v] - a[u] * a[v + 2]);
    take(column + 2, a[u] * a[v + 1] - a[u + 1] * a[v]);
  };
  cross(0, 3, 6);
  cross(3, 6, 0);
  cross(6, 0, 3);
  return same;
}

// A turned matrix is told by its first number, as a rule.
bool is_identity(const Matrix3& a) {
  const double* x = a.data();
  return x[0] == 1.0 && x[4] == 1.0 && x[8] == 1.0 && x[1] == 0.0 && x[2] == 0.0 && x[3] == 0.0 &&
         x[5] == 0.0 && x[6] == 0.0 && x[7] == 0.0;
}

/// Bound of the largest singular value: the largest row sum of its squares' matrix.
double largest_stretch(const Matrix3& a) {
  return std::sqrt((a.transpose() * a).cwiseAbs().rowwise().sum().maxCoeff());
}

}  // namespace

Body::Body(const Shape& shape) : shape_(&shape), turned_origin_(shape.origin()) {}

Body::Body(const Shape& shape, const Placement& placement) : shape_(&shape) { move(placement); }

Points Body::vertices() const {
  return (placement_.linear * shape_->vertices()).colwise() + placement_.translation;
}

Box Body::box() const {
  const Points places = vertices();
  return {places.rowwise().minCoeff(), places.rowwise().maxCoeff()};
}

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
  rigid_ = take_cofactors(placement_.linear, cofactors_);
  stretch_ = rigid_ ? 1.0 : largest_stretch(placement.linear);
}

}  // namespace quoin::geometry
