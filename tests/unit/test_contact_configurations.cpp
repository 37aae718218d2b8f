/// Limits between types of contact, and what may not change its points. Contacts with a known
/// answer: tests/pairs/configurations.jsonl.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/contact_point.hpp>

#include "referee/pairs/families.hpp"
#include "support/catch.hpp"

namespace {

using namespace quoin::geometry;
using namespace quoin::referee;
using namespace quoin::tests;

constexpr double kTolerance = 1e-6;  // m
constexpr double kPi = std::numbers::pi;
const Matrix3 kOne = Matrix3::Identity();

PairContact contact_of(const Shape& a, const Shape& b,
                       const ContactOptions& options = {.tolerance = kTolerance}) {
  PairContact contact;
  update_pair_contact(a, b, options, contact);
  return contact;
}

Shape shifted(const Shape& solid, const Vector3& shift) {
  return transformed(solid, 1.0, kOne, shift);
}

Shape turned(const Shape& solid, const Vector3& axis, double angle) {
  return transformed(solid, 1.0, rotation_about(axis, angle), Vector3::Zero());
}

Shape cube() { return make_box(Vector3::Constant(-0.5), Vector3::Constant(0.5)); }

/// A roof with its ridge on the x axis, from -half to half, hanging down (z <= 0) or, turned, up.
Shape ridge(double half) {
  Points points(3, 6);
  points << -half, half, -half, half, -half, half, 0, 0, -1, -1, 1, 1, 0, 0, -1, -1, -1, -1;
  return make_hull(points).polyhedron;
}

Shape ridge_down(double half) { return turned(ridge(half), Vector3::UnitX(), kPi); }

double area_of_points(const PairContact& contact) {
  double sum = 0.0;
  for (const ContactPoint& point : contact.points) sum += point.area;
  return sum;
}

bool has_point(const PairContact& contact, const Vector3& place, double within = 1e-9) {
  return std::any_of(contact.points.begin(), contact.points.end(), [&](const ContactPoint& p) {
    return (p.point_a - place).norm() <= within || (p.point_b - place).norm() <= within;
  });
}

}  // namespace

TEST_CASE("configurations: of an edge along the border of a face the segment has two ends") {
  Random random(31);
  int met = 0;
  for (int i = 0; i < 3000; ++i) {
    const double beside = random.integer(-4, 4) * 0x1p-52, along = random.integer(-4, 4) * 0x1p-52;
    const Shape edge = turned(cube(), Vector3::UnitX(), kPi / 4);  // along x, below the others
    const Matrix3 turn = random.rotation();
    const Shape a = transformed(make_box({-0.5, -2, -1}, {0.5, 0, 0}), 1.0, turn, Vector3::Zero());
    const Shape b = transformed(shifted(edge, {along, beside, std::sqrt(0.5) + 0.01}), 1.0, turn,
                                Vector3::Zero());
    const PairContact contact = contact_of(a, b);
    CAPTURE(i);
    if (contact.type != ContactType::EdgeFace) continue;
    ++met;
    REQUIRE(contact.polygon.size() == 2);
    CHECK_THAT((contact.polygon[1] - contact.polygon[0]).norm(), WithinAbs(1.0, 1e-12));
  }
  CHECK(met > 1000);
}

TEST_CASE("configurations: sides that coincide but for rounding cross in no point") {
  const Vector3 brick(0.4, 0.2, 0.2);
  const double off = 1e-12;  // tol is 4.9e-10
  Random random(7);
  const auto rounded = [&](const Vector3& min) {
    Shape shape = make_box(min, min + brick);
    Points vertices(3, shape.topology().vertex_count());
    for (int v = 0; v < shape.topology().vertex_count(); ++v)
      vertices.col(v) =
          shape.vertex(v) + Vector3(random.uniform(-off, off), random.uniform(-off, off), 0.0);
    shape.set_vertices(vertices);
    return shape;
  };
  for (int trial = 0; trial < 100; ++trial) {
    for (const double along : {0.0, 0.2}) {
      const Shape lower = rounded(Vector3::Zero()), upper = rounded({along, 0.0, 0.2});
      const PairContact contact = contact_of(lower, upper);
      CHECK(contact.points.size() == 4);
      for (const double x : {along, 0.4})
        for (const double y : {0.0, 0.2}) CHECK(has_point(contact, {x, y, 0.2}));
      CHECK_THAT(area_of_points(contact), WithinAbs(contact.area, 1e-15));
    }
  }
}

TEST_CASE("configurations: parallel edges have a point at either end where the solids share one") {
  Random random(11);
  const double off = 1e-12, beside = 4.5e-10, tolerance = 1e-9;
  const auto rounded = [&](const Vector3& min, const Vector3& max) {
    Points vertices = make_box(min, max).vertices();
    for (int v = 0; v < 8; ++v)
      for (int i = 0; i < 3; ++i) vertices(i, v) += random.uniform(-off, off);
    return make_hull(vertices).polyhedron;
  };
  // Seen along the normal A lies on the left of an edge next to the x axis, B on the right of its
  // own.
  const auto left_at = [](const Shape& shape, double x, const Vector3& normal) {  // of the edge, m
    const Eigen::RowVectorXd squares =
        (shape.vertices().colwise() - Vector3(x, 0, 0)).colwise().squaredNorm();
    Eigen::Index nearest = 0;
    squares.minCoeff(&nearest);
    return Vector3::UnitX().cross(normal).dot(shape.vertices().col(nearest));
  };
  int parallel = 0, over = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const Shape a = rounded({0, -0.05, 0}, {1, 0, 0.5});
    const Shape b = rounded({0, beside, -0.5}, {1, 0.05 + beside, 0});
    PairContact contact;
    update_pair_contact(a, b, {.tolerance = tolerance}, contact);
    if (contact.type != ContactType::EdgeEdgeParallel) continue;
    ++parallel;
    REQUIRE(!contact.points.empty());
    const Vector3 normal = contact.nearest.normal;
    for (const double x : {0.0, 1.0}) {
      // Within half of tol of their planes, A reaches to the right and B to the left by this, m.
      const double reach = std::max(0.0, -0.5 * tolerance * normal.z());
      if (left_at(a, x, normal) - reach > left_at(b, x, normal) + reach) continue;
      ++over;
      CHECK(has_point(contact, {x, 0, 0}, tolerance));
    }
  }
  CHECK(over > 10);
  CHECK(parallel > 10);
}

TEST_CASE("configurations: a tilted brick turns from face to edge to vertex exactly at tol") {
  // B stands on A with a face of 1 m by 1 m and is tilted about one or two of its edges
  const Shape a = make_box({-2, -2, -1}, {2, 2, 0});
  const Shape b = make_box({0, 0, 0}, {1, 1, 1});
  for (double angle = 1e-3; angle > 0.5e-12; angle *= 0.1) {
    for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
      const bool within = angle <= tolerance;
      const Shape about_y = turned(b, Vector3::UnitY(), -angle);
      const PairContact edge =
          contact_of(a, shifted(about_y, {0, 0, 1e-3}), {.tolerance = tolerance, .reach = 0.01});
      CAPTURE(angle, tolerance);
      if (std::abs(angle / tolerance - 1) > 0.01)
        CHECK(edge.type == (within ? ContactType::FaceFace : ContactType::EdgeFace));
      CHECK_THAT(edge.nearest.gap, WithinAbs(1e-3, 1e-15));
      CHECK(edge.points.size() == 4);  // all within reach, tilted or not
      for (const ContactPoint& point : edge.points)
        CHECK_THAT(point.gap, WithinAbs(1e-3 + std::tan(angle) * point.point_b.x(), 1e-12));
      const Vector3 diagonal = Vector3(1, -1, 0).normalized();  // lifts three of the corners
      const PairContact vertex = contact_of(a, shifted(turned(b, diagonal, -angle), {0, 0, 1e-3}),
                                            {.tolerance = tolerance, .reach = 0.01});
      if (angle > 2 * tolerance)
        CHECK(vertex.type == ContactType::VertexFace);
      else if (angle < 0.5 * tolerance)
        CHECK(vertex.type == ContactType::FaceFace);
      CHECK(vertex.points.size() == 4);
    }
  }
}

TEST_CASE("configurations: crossing ridges become parallel when their ends are within tol") {
  for (double angle = 1e-3; angle > 0.5e-12; angle *= 0.1) {
    for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
      if (std::abs(2 * angle / tolerance - 1) < 0.5) continue;
      const Shape upper = shifted(turned(ridge_down(1.0), Vector3::UnitZ(), angle), {0, 0, 0.01});
      const PairContact contact = contact_of(ridge(1.0), upper, {.tolerance = tolerance});
      CAPTURE(angle, tolerance);
      CHECK(contact.type == (2 * std::sin(angle) <= tolerance ? ContactType::EdgeEdgeParallel
                                                              : ContactType::EdgeEdgeCrossing));
      CHECK_THAT(contact.nearest.gap, WithinAbs(0.01, 1e-13));
    }
  }
}

TEST_CASE("configurations: merged points lie where they lie, whichever solid is A") {
  constexpr double kSize = 2e-10;  // of the solids, m
  Random random(1);
  const auto prism = [&] {
    const int corners = random.integer(3, 8);
    Points points(3, 2 * corners);
    for (int i = 0; i < corners; ++i) {
      const double angle = 2 * kPi * (i + random.uniform(0.1, 0.9)) / corners;
      points.col(i) = kSize * Vector3(0.5 * std::cos(angle), 0.5 * std::sin(angle), -0.3);
      points.col(corners + i) = points.col(i) + Vector3(0, 0, 0.6 * kSize);
    }
    return make_hull(points).polyhedron;
  };
  const auto listed = [](const std::vector<ContactPoint>& points, const ContactPoint& swapped) {
    return std::any_of(points.begin(), points.end(), [&](const ContactPoint& point) {
      return point.point_a == swapped.point_b && point.point_b == swapped.point_a &&
             point.gap == swapped.gap && point.area == swapped.area;
    });
  };
  for (int i = 0; i < 2000; ++i) {
    const Shape a = prism();
    const Matrix3 lean = rotation_about(random.direction(), random.log_uniform(1e-9, 1e-2));
    const Vector3 shift(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), 0.6);
    const Shape b = transformed(prism(), 1.0, lean, kSize * shift);
    const ContactOptions wide{.tolerance = random.uniform(0.3, 1) * kSize};
    const PairContact contact = contact_of(a, b, wide), swapped = contact_of(b, a, wide);
    CAPTURE(i);
    REQUIRE(contact.points.size() == swapped.points.size());
    for (const ContactPoint& point : swapped.points) REQUIRE(listed(contact.points, point));
  }
}

TEST_CASE(
    "configurations: points of flush faces hang on what else lies within reach, however asked") {
  Random random(21);
  for (const double height : {1.0, 0.2, 0.05, 1e-3}) {  // of the blocks, m
    for (const double reach : {1e-6, 1e-3, 2e-2, 0.1, 0.5}) {
      const Matrix3 turn = random.rotation();
      const Shape below =
          transformed(make_box({0, 0, -height}, {1, 1, 0}), 1.0, turn, Vector3::Zero());
      const Shape above =
          transformed(make_box({0.3, 0.2, 1e-7}, {1.3, 1.2, height}), 1.0, turn, Vector3::Zero());
      std::vector<ContactPoint> together;
      const auto nearest =
          append_contacts_within_reach({0, 1}, below, above, {.reach = reach}, {}, together);
      PairContact whole;
      update_pair_contact(below, above, {.reach = reach - nearest.gap}, whole);
      const std::vector<ContactPoint>& apart = whole.points;
      REQUIRE(together.size() == apart.size());
      REQUIRE(together.size() == 4);
      for (std::size_t k = 0; k < apart.size(); ++k) {
        CHECK(together[k].key == apart[k].key);
        CHECK(together[k].point_a == apart[k].point_a);
        CHECK(together[k].point_b == apart[k].point_b);
        CHECK(together[k].area == apart[k].area);
      }
    }
  }
}

TEST_CASE("configurations: nothing on the far side of a solid, however large reach is") {
  Random random(22);
  const Shape ground = make_box({-10, -10, -5}, {10, 10, 0});
  for (int turn = 0; turn < 300; ++turn) {
    Points points(3, random.integer(5, 24));
    for (Eigen::Index k = 0; k < points.cols(); ++k) points.col(k) = random.point(-1, 1);
    points.row(2).array() -= points.row(2).minCoeff();
    const Shape solid = make_hull(points).polyhedron;
    const PairContact contact = contact_of(ground, solid, {.reach = 5.0});
    for (const ContactPoint& point : contact.points) {
      const Vector3 below = point.point_b - Vector3(0, 0, 1e-6);
      bool outside = false;
      for (int f = 0; f < solid.topology().face_count(); ++f) {
        const Vector3 corner = solid.vertex(solid.topology().face(f)[0]);
        outside = outside || solid.face_normal(f).dot(below - corner) > 0.0;
      }
      CHECK(outside);  // there is no more of the solid between it and the ground
    }
  }
}

TEST_CASE("configurations: faces bumped by less than tol have the same points in any numbering") {
  Random random(23);
  const auto rounded = [&random](const Shape& solid, const Matrix3& turn) {
    Points points = turn * solid.vertices();
    for (double& x : points.reshaped()) x += random.uniform(-5e-7, 5e-7);
    return points;
  };
  for (int turn = 0; turn < 60; ++turn) {
    const Matrix3 frame = random.rotation();
    const Points lower = rounded(make_box({-1, -1, -1}, {1, 1, 0}), frame);
    const Points upper = rounded(make_box({-2, -2, 2e-3}, {3, 2, 1}), frame);
    std::size_t count = 0;
    for (int order = 0; order < 12; ++order) {
      Points p = lower, q = upper;
      for (Points* points : {&p, &q})
        for (int k = 7; k > 0; --k) points->col(k).swap(points->col(random.integer(0, k)));
      const PairContact contact =
          contact_of(make_hull(p).polyhedron, make_hull(q).polyhedron, {.tolerance = 1e-3});
      if (order == 0) count = contact.points.size();
      CHECK(contact.points.size() == count);
      CHECK_THAT(contact.area, WithinAbs(4.0, 1e-4));
    }
    CHECK(count <= 5);  // the corners, and the place of the least gap
  }
}
