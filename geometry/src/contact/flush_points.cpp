#include "contact/flush_points.hpp"

namespace quoin::geometry {

FlushPoints::FlushPoints(const FlushFaces& faces, std::span<const PolygonCorner> corners)
    : faces_(faces), corners_(corners) {
  const Names names_p(*faces.p, faces.face_p), names_q(*faces.q, faces.face_q);
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const PolygonCorner& corner = corners[k];
    name_p_[k] = names_p.of(corner.feature_p);
    name_q_[k] = names_q.of(corner.feature_q);
    key_[k] = key_number({corner.feature_p.kind, name_p_[k]}, {corner.feature_q.kind, name_q_[k]},
                         faces.reversed);
    const double gap = corner.height_q - corner.height_p;
    lowest_ = gap < lowest_ ? gap : lowest_;
    highest_ = gap > highest_ ? gap : highest_;
  }
  find_order();
}

/// Each against those before it: how near, and behind how many. Counted, as sorting would branch on
/// the keys.
void FlushPoints::find_order() {
  std::array<double, kMost> x, y;
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    x[i] = corners_[i].x;
    y[i] = corners_[i].y;
    unsigned before = 0;
    for (std::size_t k = 0; k < i; ++k) {
      const double dx = x[i] - x[k], dy = y[i] - y[k], squared = dx * dx + dy * dy;
      nearest_ = squared < nearest_ ? squared : nearest_;
      const bool smaller = key_[k] <= key_[i];
      before += smaller;
      place_[k] += !smaller;
    }
    place_[i] = before;
  }
}

void FlushPoints::write(const ContactPlane& plane, const Vector3& normal, const Vector3* middle,
                        std::span<ContactPoint> points) const {
  const bool reversed = faces_.reversed;
  for (std::size_t k = 0; k < corners_.size(); ++k) {
    const PolygonCorner& corner = corners_[k];
    const double height_a = reversed ? corner.height_q : corner.height_p;
    const double height_b = reversed ? corner.height_p : corner.height_q;
    ContactPoint& point = points[place_[k]];
    const Feature of_p{corner.feature_p.kind, name_p_[k]}, of_q{corner.feature_q.kind, name_q_[k]};
    point.key = {faces_.blocks[0], faces_.blocks[1], reversed ? of_q : of_p,
                 reversed ? of_p : of_q};
    point.type = ContactType::FaceFace;
    for (int i = 0; i < 3; ++i) {
      const double foot = plane.origin[i] + plane.axis_u[i] * corner.x + plane.axis_v[i] * corner.y;
      const double place_a = foot + height_a * plane.normal[i];
      const double place_b = foot + height_b * plane.normal[i];
      point.point_a[i] = middle != nullptr ? place_a + (*middle)[i] : place_a;
      point.point_b[i] = middle != nullptr ? place_b + (*middle)[i] : place_b;
    }
    point.normal = normal;
    point.gap = corner.height_q - corner.height_p + 0.0;  // one zero
    point.area = corner.share;
  }
}

}  // namespace quoin::geometry
