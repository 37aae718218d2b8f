/// Heights by the solids' surfaces and shares with a given first moment, against closed forms.

#include "geometry/src/contact/contact_patch.hpp"

#include <quoin/geometry/build.hpp>

#include "support/catch.hpp"

using namespace quoin;
using geometry::ContactPlane;
using geometry::OuterSurface;
using geometry::Points;
using geometry::Shape;
using geometry::SharedCorner;
using geometry::SharedCorners;
using geometry::SharedPolygon;
using geometry::Vector2;
using geometry::Vector3;
using tests::WithinAbs;

namespace {

constexpr double kRounding = 1e-15;  // m

SharedCorner at(double x, double y, double share) {
  SharedCorner corner;
  corner.place = {x, y};
  corner.share = share;
  return corner;
}

Vector2 moment_of(const SharedCorners& points) {
  Vector2 moment = Vector2::Zero();
  for (const SharedCorner& c : points) moment += c.share * c.place;
  return moment;
}

double sum_of(const SharedCorners& points) {
  double sum = 0.0;
  for (const SharedCorner& c : points) sum += c.share;
  return sum;
}

}  // namespace

TEST_CASE("over a face with one corner lifted the surface is the higher of both diagonals") {
  constexpr double kLift = 1e-10;
  const Shape box = geometry::make_box({-1, -1, -1}, {1, 1, 0});
  int lifted = 0;
  for (int v = 0; v < box.vertex_count(); ++v) {
    if (box.vertex(v).z() != 0.0) continue;
    ++lifted;
    Points vertices = box.vertices();
    vertices(2, v) += kLift;
    Shape bumped = box;
    bumped.set_vertices(vertices);
    const ContactPlane plane(Vector3::Zero(), Vector3::UnitZ());
    const OuterSurface surface(bumped, plane, 1.0, 1e-3, kRounding);
    const Vector2 corner = plane.place(bumped.vertex(v));
    CHECK_THAT(surface.height({0, 0}, -1.0), WithinAbs(0.5 * kLift, 1e-24));
    CHECK_THAT(surface.height(0.5 * corner, -1.0), WithinAbs(0.75 * kLift, 1e-24));
    CHECK_THAT(surface.height(-0.5 * corner, -1.0), WithinAbs(0.25 * kLift, 1e-24));
    CHECK(surface.height(3.0 * corner, -1.0) == -1.0);
    double off = 0.0;
    for (int f = 0; f < box.topology().face_count(); ++f) {
      off = std::max(off, geometry::bumps(bumped, f).off_plane);
    }
    CHECK(off > 0.1 * kLift);
  }
  CHECK(lifted == 4);
}

TEST_CASE("balanced shares keep their sum and have the polygon's first moment") {
  SharedPolygon polygon;
  polygon.area = 2.0;
  polygon.centroid = {0.4, 0.6};
  SharedCorners points;
  for (const SharedCorner& c : {at(0, 0, 1.0), at(1, 0, 0.5), at(1, 1, 0.5), at(0, 1, 0.0)}) {
    points.push_back(c);
  }
  geometry::balance_shares(polygon, points);
  CHECK_THAT(sum_of(points), WithinAbs(2.0, 1e-15));
  CHECK((moment_of(points) - 2.0 * polygon.centroid).norm() < 1e-15);
  for (const SharedCorner& c : points) CHECK(c.share >= 0.0);
}

TEST_CASE("shares of points that do not surround the centroid come as near as they can") {
  SharedPolygon polygon;
  polygon.area = 1.0;
  polygon.centroid = {2.0, 0.5};
  SharedCorners points;
  for (const SharedCorner& c : {at(0, 0, 0.5), at(1, 0, 0.0), at(1, 1, 0.0), at(0, 1, 0.5)}) {
    points.push_back(c);
  }
  geometry::balance_shares(polygon, points);
  CHECK_THAT(sum_of(points), WithinAbs(1.0, 1e-15));
  CHECK((moment_of(points) - Vector2(1.0, 0.5)).norm() < 1e-15);
}
