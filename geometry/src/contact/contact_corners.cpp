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

}  // namespace quoin::geometry
