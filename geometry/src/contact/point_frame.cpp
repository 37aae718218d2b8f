#include "contact/point_frame.hpp"

namespace quoin::geometry {
namespace {

/// From a place as seen from the middle of the pair into the frame of the shape.
class IntoFrame {
 public:
  explicit IntoFrame(const Solid& solid) : solid_(solid) {
    if (solid.turned() == nullptr) return;
    const Matrix3& cofactors = solid.turned()->cofactors();
    const double determinant = solid.turned()->placement().linear.col(0).dot(cofactors.col(0));
    inverse_ = cofactors.transpose() / determinant;
  }
  Vector3 operator()(const Vector3& place) const {
    const Vector3 offset = place - solid_.origin();
    return solid_.shape().origin() + (solid_.turned() == nullptr ? offset : inverse_ * offset);
  }

 private:
  const Solid& solid_;
  Matrix3 inverse_ = Matrix3::Identity();
};

}  // namespace

void move(const Solid& a, const Solid& b, const Vector3& middle, PointFrame frame,
          std::span<ContactPoint> points) {
  if (points.empty()) return;
  if (frame == PointFrame::World) {
    for (ContactPoint& point : points) {
      point.point_a += middle;
      point.point_b += middle;
    }
    return;
  }
  const IntoFrame into_a(a), into_b(b);
  for (ContactPoint& point : points) {
    point.point_a = into_a(point.point_a);
    point.point_b = into_b(point.point_b);
  }
}

}  // namespace quoin::geometry
