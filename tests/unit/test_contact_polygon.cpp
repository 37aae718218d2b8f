/// The part that two faces share, against the hull of its corners and against closed forms.

#include "geometry/src/polygon/contact_polygon.hpp"

#include <algorithm>
#include <quoin/geometry/build.hpp>

#include "geometry/src/polygon/projected_feature.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"

using namespace quoin;
using geometry::ContactPolygon;
using geometry::Matrix3;
using geometry::Points;
using geometry::Shape;
using geometry::Vector3;
using tests::WithinAbs;

namespace {

/// A prism over a polygon with corners on a circle around `centre`, from height `low` to `high`.
Shape prism(tests::Random& random, int corners, const Vector3& centre, double low,
                 double high) {
  Points polygon(3, corners);
  const double first = random.uniform(0.0, 6.0);
  for (int k = 0; k < corners; ++k) {
    const double angle = first + 6.283185307179586 * (k + random.uniform(-0.3, 0.3)) / corners;
    polygon.col(k) = centre + Vector3(std::cos(angle), std::sin(angle), low);
  }
  return geometry::make_prism(polygon, {0, 0, high - low});
}

int face_towards(const Shape& solid, double sign) {
  int best = 0;
  for (int f = 1; f < solid.topology().face_count(); ++f) {
    if (sign * solid.face_normal(f).z() > sign * solid.face_normal(best).z()) best = f;
  }
  return best;
}

/// The upper face of P against the lower one of Q.
void lay(const Shape& p, const Shape& q, ContactPolygon& part) {
  part.face_p = face_towards(p, 1.0);
  part.face_q = face_towards(q, -1.0);
  part.plane = geometry::ContactPlane(p.vertex(p.topology().face(part.face_p)[0]), {0, 0, 1});
  REQUIRE(geometry::lay_faces(p, q, 0.0, part));
  geometry::find_polygon(part);
}

double sum_of_shares(const ContactPolygon& part) {
  double sum = 0.0;
  for (const geometry::SharedCorner& corner : part.corners) sum += corner.share;
  return sum;
}

/// The same faces, clipped in the general way.
void clip(const Shape& p, const Shape& q, const ContactPolygon& part,
          geometry::SharedCorners& corners) {
  geometry::ProjectedFeature patch_p, patch_q;
  geometry::lay_feature(p, {geometry::FeatureKind::Face, part.face_p}, part.plane, 1.0, patch_p);
  geometry::lay_feature(q, {geometry::FeatureKind::Face, part.face_q}, part.plane, -1.0, patch_q);
  geometry::append_shared_corners(patch_p, patch_q, geometry::border_rounding(p, q, 0.0), corners);
}

const geometry::SharedCorner* find_named(const geometry::SharedCorners& corners,
                                         const geometry::SharedCorner& as) {
  return std::find_if(corners.begin(), corners.end(), [&](const geometry::SharedCorner& c) {
    return c.feature_p == as.feature_p && c.feature_q == as.feature_q;
  });
}

}  // namespace

TEST_CASE("clear faces of few corners share what the general way says") {
  tests::Random random(13);
  int measured = 0;
  for (int turn = 0; turn < 4000; ++turn) {
    const int count_p = random.integer(3, 14), count_q = random.integer(3, 14);
    const Shape p = prism(random, count_p, {0, 0, 0}, -1, 0);
    const Vector3 aside(random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0), 0.0);
    const Shape q = prism(random, count_q, aside, 0, 1);
    ContactPolygon part;
    lay(p, q, part);
    geometry::SharedCorners corners;
    clip(p, q, part, corners);
    CHECK(part.measured == (std::max(count_p, count_q) <= 12 && !corners.empty()));
    CHECK((part.margin > 0.0) == !part.corners.empty());
    measured += part.measured ? 1 : 0;
    REQUIRE(part.corners.size() == corners.size());
    geometry::SharedPolygon hull;
    geometry::find_polygon(corners, hull);
    CHECK_THAT(part.polygon.area, WithinAbs(hull.area, 1e-14));
    CHECK_THAT((part.polygon.centroid - hull.centroid).norm(), WithinAbs(0.0, 1e-9));
    CHECK_THAT(sum_of_shares(part), WithinAbs(hull.area, 1e-14));
    for (const geometry::SharedCorner& corner : corners) {
      const geometry::SharedCorner* const same = find_named(part.corners, corner);
      REQUIRE(same != part.corners.end());
      CHECK(same->place == corner.place);
      CHECK(same->height_p == corner.height_p);
      CHECK(same->height_q == corner.height_q);
      CHECK_THAT(same->share, WithinAbs(corner.share, 1e-11));
    }
  }
  CHECK(measured > 1500);
}

TEST_CASE("corners of clear faces know their gaps and how near they come to each other") {
  ContactPolygon part;
  lay(geometry::make_box({0, 0, 0}, {4, 4, 1}), geometry::make_box({1, 1, 1.5}, {2, 6, 2}), part);
  REQUIRE(part.measured);
  CHECK(part.lowest == 0.5);
  CHECK(part.highest == 0.5);
  CHECK(part.nearest_squared == 1.0);
  CHECK(part.polygon.area == 3.0);
}

TEST_CASE("faces are laid as by the plain loop, to the bit, for any number of corners") {
  tests::Random random(14);
  for (int corners = 3; corners <= 40; ++corners) {
    const Shape p = prism(random, corners, random.point(-1, 1), -1, 0);
    geometry::PolygonRows rows;
    const std::span<const int> cycle = p.topology().face(face_towards(p, 1.0));
    rows.count = static_cast<int>(cycle.size());
    std::copy(cycle.begin(), cycle.end(), rows.vertex);
    const geometry::ContactPlane plane(random.point(-1, 1), random.direction());
    geometry::lay_corners(p, plane, rows);
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int k = 0; k < rows.count; ++k) {
      const geometry::LocalPlane local(p, plane);
      const geometry::Vec3 vertex = p.vertex(rows.vertex[k]);
      REQUIRE(rows.x[k] == local.place(vertex).x());
      REQUIRE(rows.y[k] == local.place(vertex).y());
      REQUIRE(rows.height[k] == local.height(vertex));
      REQUIRE((plane.place(p.vertex(rows.vertex[k])) - local.place(vertex)).norm() < 1e-15);
      low = std::min(low, rows.height[k]);
      high = std::max(high, rows.height[k]);
    }
    for (int k = 0; k < rows.count; ++k) {
      const double x = rows.x[rows.next(k)] - rows.x[k], y = rows.y[rows.next(k)] - rows.y[k];
      REQUIRE(rows.side_x[k] == x);
      REQUIRE(rows.side_y[k] == y);
      REQUIRE(rows.length[k] == std::sqrt(x * x + y * y));
    }
    for (int k = rows.count; k < rows.filled() - 1; ++k) {  // one corner more than once
      REQUIRE(rows.x[k] == rows.x[0]);
      REQUIRE(rows.y[k] == rows.y[0]);
      REQUIRE(rows.length[k] == 0.0);
    }
    REQUIRE(rows.low == low);
    REQUIRE(rows.high == high);
  }
}

TEST_CASE("corners on sides are in doubt, and the hull puts them in order") {
  ContactPolygon part;
  lay(geometry::make_box({0, 0, 0}, {2, 1, 1}), geometry::make_box({1, 0, 1}, {3, 1, 2}), part);
  CHECK(!part.measured);
  geometry::SmallVector<int, 32> order;
  geometry::find_order(part.corners, order);
  CHECK(order.size() == 4);
  CHECK(part.polygon.area == 1.0);
  CHECK(sum_of_shares(part) == 1.0);
}

TEST_CASE("a face within the other has its own corners") {
  ContactPolygon part;
  lay(geometry::make_box({0, 0, 0}, {4, 4, 1}), geometry::make_box({1, 1, 1}, {2, 3, 2}), part);
  CHECK(part.measured);
  CHECK(part.corners.size() == 4);
  CHECK(part.polygon.area == 2.0);
  ContactPolygon other;
  lay(geometry::make_box({1, 1, 0}, {2, 3, 1}), geometry::make_box({0, 0, 1}, {4, 4, 2}), other);
  CHECK(other.corners.size() == 4);
  CHECK(other.polygon.area == 2.0);
}
