/// The part that two faces share, against the hull of its corners and against closed forms.

#include "geometry/src/shared_part.hpp"

#include <quoin/geometry/build.hpp>

#include "support/catch.hpp"
#include "support/random.hpp"

using namespace quoin;
using geometry::Matrix3;
using geometry::Points;
using geometry::Polyhedron;
using geometry::SharedPart;
using geometry::Vector3;
using tests::WithinAbs;

namespace {

/// A prism over a polygon with corners on a circle around `centre`, from height `low` to `high`.
Polyhedron prism(tests::Random& random, int corners, const Vector3& centre, double low,
                 double high) {
  Points polygon(3, corners);
  const double first = random.uniform(0.0, 6.0);
  for (int k = 0; k < corners; ++k) {
    const double angle = first + 6.283185307179586 * (k + random.uniform(-0.3, 0.3)) / corners;
    polygon.col(k) = centre + Vector3(std::cos(angle), std::sin(angle), low);
  }
  return geometry::make_prism(polygon, {0, 0, high - low});
}

int face_towards(const Polyhedron& solid, double sign) {
  int best = 0;
  for (int f = 1; f < solid.topology().face_count(); ++f) {
    if (sign * solid.face_normal(f).z() > sign * solid.face_normal(best).z()) best = f;
  }
  return best;
}

/// The upper face of P against the lower one of Q.
void lay(const Polyhedron& p, const Polyhedron& q, SharedPart& part) {
  part.face_p = face_towards(p, 1.0);
  part.face_q = face_towards(q, -1.0);
  part.plane = geometry::ContactPlane(p.vertex(p.topology().face(part.face_p)[0]), {0, 0, 1});
  REQUIRE(geometry::lay_faces(p, q, 0.0, part));
  geometry::find_polygon(part);
}

double sum_of_shares(const SharedPart& part) {
  double sum = 0.0;
  for (const geometry::SharedCorner& corner : part.corners) sum += corner.share;
  return sum;
}

}  // namespace

TEST_CASE("corners found in their order make the polygon that their hull makes") {
  tests::Random random(13);
  int in_order = 0;
  for (int turn = 0; turn < 2000; ++turn) {
    const Polyhedron p = prism(random, random.integer(3, 20), {0, 0, 0}, -1, 0);
    const Vector3 aside(random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0), 0.0);
    const Polyhedron q = prism(random, random.integer(3, 20), aside, 0, 1);
    SharedPart part;
    lay(p, q, part);
    in_order += part.overlay.in_order ? 1 : 0;
    CHECK((part.overlay.margin > 0.0) == !part.corners.empty());
    geometry::SharedCorners corners = part.corners;
    geometry::SharedPolygon hull;
    geometry::find_polygon(corners, hull);
    REQUIRE(hull.order.size() == part.polygon.order.size());
    CHECK_THAT(part.polygon.area, WithinAbs(hull.area, 1e-14));
    CHECK_THAT((part.polygon.centroid - hull.centroid).norm(), WithinAbs(0.0, 1e-9));
    CHECK_THAT(sum_of_shares(part), WithinAbs(hull.area, 1e-14));
  }
  CHECK(in_order == 2000);
}

TEST_CASE("faces are laid as by the plain loop, to the bit, for any number of corners") {
  tests::Random random(14);
  for (int corners = 3; corners <= 40; ++corners) {
    const Polyhedron p = prism(random, corners, random.point(-1, 1), -1, 0);
    geometry::PolygonRows rows;
    const std::span<const int> cycle = p.topology().face(face_towards(p, 1.0));
    rows.count = static_cast<int>(cycle.size());
    std::copy(cycle.begin(), cycle.end(), rows.vertex);
    const geometry::ContactPlane plane(random.point(-1, 1), random.direction());
    geometry::lay_corners(p, plane, rows);
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int k = 0; k < rows.count; ++k) {
      const Vector3 step = p.vertex(rows.vertex[k]) - plane.origin;
      REQUIRE(rows.x[k] == geometry::along(plane.axis_u, step));
      REQUIRE(rows.y[k] == geometry::along(plane.axis_v, step));
      REQUIRE(rows.height[k] == geometry::along(plane.normal, step));
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

TEST_CASE("flush faces are in doubt, and their hull puts the corners in order") {
  SharedPart part;
  lay(geometry::make_box({0, 0, 0}, {2, 1, 1}), geometry::make_box({1, 0, 1}, {3, 1, 2}), part);
  CHECK(!part.overlay.in_order);
  CHECK(part.polygon.order.size() == 4);
  CHECK(part.polygon.area == 1.0);
  CHECK(sum_of_shares(part) == 1.0);
}

TEST_CASE("a face within the other has its own corners") {
  SharedPart part;
  lay(geometry::make_box({0, 0, 0}, {4, 4, 1}), geometry::make_box({1, 1, 1}, {2, 3, 2}), part);
  CHECK(part.overlay.in_order);
  CHECK(part.corners.size() == 4);
  CHECK(part.polygon.area == 2.0);
  SharedPart other;
  lay(geometry::make_box({1, 1, 0}, {2, 3, 1}), geometry::make_box({0, 0, 1}, {4, 4, 2}), other);
  CHECK(other.corners.size() == 4);
  CHECK(other.polygon.area == 2.0);
}
