/// The part that two faces share, against the hull of its corners and against closed forms.

#include "geometry/src/polygon/contact_polygon.hpp"

#include <algorithm>
#include <cmath>
#include <quoin/geometry/build.hpp>

#include "support/catch.hpp"
#include "support/random.hpp"

using namespace quoin;
using namespace geometry;
using tests::WithinAbs;

namespace {

/// A prism over a polygon with corners on a circle around `centre`, from height `low` to `high`.
Shape prism(tests::Random& random, int corners, const Vector3& centre, double low, double high) {
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
  for (int f = 1; f < solid.topology().face_count(); ++f)
    if (sign * solid.face_normal(f).z() > sign * solid.face_normal(best).z()) best = f;
  return best;
}

/// The upper face of P against the lower one of Q.
void lay(const Shape& p, const Shape& q, ContactPolygon& part) {
  part.face_p = face_towards(p, 1.0);
  part.face_q = face_towards(q, -1.0);
  part.plane = geometry::ContactPlane(p.vertex(p.topology().face(part.face_p)[0]), {0, 0, 1});
  geometry::lay_faces(p, q, 0.0, part);
  geometry::find_polygon(part);
}

double sum_of_shares(const ContactPolygon& part) {
  double sum = 0.0;
  for (const geometry::SharedCorner& corner : part.corners) sum += corner.share;
  return sum;
}

/// Twice the area of a triangle, positive where `at` lies to the left.
double turn(const Vector3& from, const Vector3& to, const Vector3& at) {
  return (to - from).cross(at - from).z();
}

std::vector<Vector3> corners_of(const Shape& solid, int face) {
  std::vector<Vector3> corners;
  for (const int v : solid.topology().face(face)) corners.push_back(solid.vertex(v));
  if (solid.face_normal(face).z() < 0.0) std::reverse(corners.begin(), corners.end());
  return corners;
}

/// The corners that two convex polygons share, by comparing all of one with all of the other.
std::vector<Vector3> shared_by_all_pairs(const std::vector<Vector3>& p,
                                         const std::vector<Vector3>& q) {
  std::vector<Vector3> shared;
  const auto add_covered = [&](const std::vector<Vector3>& of, const std::vector<Vector3>& by) {
    for (const Vector3& c : of) {
      bool inside = true;
      for (std::size_t k = 0; k < by.size(); ++k)
        inside = inside && turn(by[k], by[(k + 1) % by.size()], c) > 0.0;
      if (inside) shared.push_back(c);
    }
  };
  add_covered(p, q);
  add_covered(q, p);
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vector3 &a = p[i], &b = p[(i + 1) % p.size()];
    for (std::size_t j = 0; j < q.size(); ++j) {
      const Vector3 &c = q[j], &d = q[(j + 1) % q.size()];
      const double at = turn(c, d, a), end = turn(c, d, b);
      if ((at > 0.0) == (end > 0.0) || (turn(a, b, c) > 0.0) == (turn(a, b, d) > 0.0)) continue;
      shared.push_back(a + at / (at - end) * (b - a));
    }
  }
  return shared;
}

}  // namespace

TEST_CASE("faces of few and of many corners share what all pairs of their sides say") {
  tests::Random random(13);
  for (int turn = 0; turn < 1500; ++turn) {
    const int most = turn < 1000 ? 14 : 120;
    const Shape p = prism(random, random.integer(3, most), {0, 0, 0}, -1, 0);
    const Vector3 aside(random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0), 0.0);
    const Shape q = prism(random, random.integer(3, most), aside, 0, 1);
    ContactPolygon part;
    lay(p, q, part);
    const std::vector<Vector3> expected =
        shared_by_all_pairs(corners_of(p, part.face_p), corners_of(q, part.face_q));
    REQUIRE(part.corners.size() == expected.size());
    CHECK((part.margin > 0.0) == !expected.empty());
    CHECK(part.convex == !expected.empty());
    for (const Vector3& place : expected) {  // in whatever order
      const auto is_there = [&](const geometry::SharedCorner& corner) {
        return (part.plane.point(corner.place, 0.0) - place).norm() <= 1e-12;
      };
      CHECK(std::count_if(part.corners.begin(), part.corners.end(), is_there) == 1);
    }
    CHECK_THAT(sum_of_shares(part), WithinAbs(part.polygon.area, 1e-14));
  }
}

TEST_CASE("the hull puts corners on sides in order") {
  ContactPolygon part;
  lay(geometry::make_box({0, 0, 0}, {2, 1, 1}), geometry::make_box({1, 0, 1}, {3, 1, 2}), part);
  geometry::SmallVector<int, 32> order;
  geometry::find_order(part.corners, order);
  CHECK(order.size() == 4);
  CHECK(part.polygon.area == 1.0);
  CHECK(sum_of_shares(part) == 1.0);
}
