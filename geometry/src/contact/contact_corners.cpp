#include "contact/contact_corners.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace quoin::geometry {
namespace {

/// The corners by the keys of their points, and which corner each is.
using Order = SmallVector<std::pair<std::int64_t, std::size_t>, 64>;

void find_places(const SharedCorners& corners, bool reversed, Order& order) {
  for (std::size_t i = 0; i < corners.size(); ++i)
    order.push_back({key_number(corners[i].feature_p, corners[i].feature_q, reversed), i});
  std::sort(order.begin(), order.end());
}

/// Fills in what is the point's own.
void take_point(const SharedCorner& corner, bool reversed, const ContactPlane& plane,
                ContactPoint& contact) {
  contact.key.feature_a = reversed ? corner.feature_q : corner.feature_p;
  contact.key.feature_b = reversed ? corner.feature_p : corner.feature_q;
  const double height_a = reversed ? corner.height_q : corner.height_p;
  const double height_b = reversed ? corner.height_p : corner.height_q;
  for (int i = 0; i < 3; ++i) {
    const double foot =
        plane.origin[i] + plane.axis_u[i] * corner.place.x() + plane.axis_v[i] * corner.place.y();
    contact.point_a[i] = foot + height_a * plane.normal[i];
    contact.point_b[i] = foot + height_b * plane.normal[i];
  }
  contact.gap = gap_of(corner) + 0.0;  // one zero
  contact.area = corner.share;
}

}  // namespace

void append_corners(const std::array<int, 2>& blocks, bool reversed, const NearestFeatures& nearest,
                    ContactType type, const ContactPlane& plane, const SharedCorners& corners,
                    std::vector<ContactPoint>& contacts) {
  const std::size_t count = corners.size(), first = contacts.size();
  Order order;
  find_places(corners, reversed, order);
  ContactPoint common;
  common.key.a = blocks[0];
  common.key.b = blocks[1];
  common.type = type;
  common.indeterminate = nearest.indeterminate;
  common.normal = nearest.normal;
  contacts.resize(first + count, common);
  for (std::size_t i = 0; i < count; ++i)
    take_point(corners[order[i].second], reversed, plane, contacts[first + i]);
}

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
