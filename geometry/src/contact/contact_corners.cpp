#include "contact/contact_corners.hpp"

#include <cstdint>

namespace quoin::geometry {
namespace {

/// Where each point goes.
struct Places {
  SmallVector<std::int64_t, 64> keys;
  SmallVector<unsigned, 64> places;

  /// Behind those with smaller keys. Counted, as sorting would branch on the keys.
  Places(const SharedCorners& corners, bool reversed) {
    const std::size_t count = corners.size();
    keys.resize(count);
    places.resize(count);
    std::int64_t* const key = keys.begin();
    unsigned* const place = places.begin();
    for (std::size_t i = 0; i < count; ++i) {
      key[i] = key_number(corners[i].feature_p, corners[i].feature_q, reversed);
      unsigned before = 0;
      for (std::size_t j = 0; j < i; ++j) {
        const unsigned smaller = key[j] <= key[i];
        before += smaller;
        place[j] += 1 - smaller;
      }
      place[i] = before;
    }
  }
};

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
  const Places order(corners, reversed);
  ContactPoint common;
  common.key.a = blocks[0];
  common.key.b = blocks[1];
  common.type = type;
  common.indeterminate = nearest.indeterminate;
  common.normal = nearest.normal;
  contacts.resize(first + count, common);
  for (std::size_t i = 0; i < count; ++i) {
    take_point(corners[i], reversed, plane, contacts[first + order.places[i]]);
  }
}

}  // namespace quoin::geometry
