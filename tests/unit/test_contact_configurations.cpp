/// Deliberately built contacts of all seven types and their limits: type, points, polygon, area.
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

/// A pyramid that stands on its tip at the origin.
Shape tip() {
  Points points(3, 5);
  points << 0, 1, -1, 1, -1, 0, 1, 1, -1, -1, 0, 2, 2, 2, 2;
  return make_hull(points).polyhedron;
}

/// A roof with its ridge on the x axis, from -half to half, hanging down (z <= 0) or, turned, up.
Shape ridge(double half) {
  Points points(3, 6);
  points << -half, half, -half, half, -half, half, 0, 0, -1, -1, 1, 1, 0, 0, -1, -1, -1, -1;
  return make_hull(points).polyhedron;
}

Shape ridge_down(double half) { return turned(ridge(half), Vector3::UnitX(), kPi); }

int count_edge_edge(const PairContact& contact) {
  return static_cast<int>(std::count_if(
      contact.points.begin(), contact.points.end(),
      [](const ContactPoint& p) { return p.key.feature_a.kind == FeatureKind::Edge; }));
}

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

/// The same contact asked in every way that may not matter: swapped, turned as a whole, moved far.
template <class Check>
void in_every_pose(const Shape& a, const Shape& b, Check&& check) {
  check(a, b, 1.0);
  check(b, a, -1.0);
  Random random(17);
  for (int i = 0; i < 10; ++i) {
    const Matrix3 turn = random.rotation();
    const Vector3 shift = 100 * random.point(-1, 1);
    check(transformed(a, 1, turn, shift), transformed(b, 1, turn, shift), 1.0);
  }
}

}  // namespace

TEST_CASE("configurations: vertex-vertex, plane open") {
  in_every_pose(cube(), shifted(cube(), Vector3::Constant(1.001)),
                [](const Shape& a, const Shape& b, double) {
                  const PairContact contact = contact_of(a, b);
                  CHECK(contact.type == ContactType::VertexVertex);
                  CHECK(contact.nearest.indeterminate);
                  CHECK_THAT(contact.nearest.gap, WithinAbs(0.001 * std::sqrt(3.0), 1e-12));
                  CHECK(contact.points.size() == 1);
                  CHECK(contact.area == 0.0);
                });
}

TEST_CASE("configurations: vertex-edge, plane open") {
  // the tip turned to point at the middle of a cube's edge, along the bisector of its faces
  const Shape b = transformed(tip(), 1, rotation_about(Vector3::UnitY(), kPi / 4),
                              Vector3(0.5, 0, 0.5) + 0.01 * Vector3(1, 0, 1).normalized());
  in_every_pose(cube(), b, [](const Shape& p, const Shape& q, double) {
    const PairContact contact = contact_of(p, q);
    CHECK(contact.type == ContactType::VertexEdge);
    CHECK(contact.nearest.indeterminate);
    CHECK_THAT(contact.nearest.gap, WithinAbs(0.01, 1e-12));
    CHECK(contact.points.size() == 1);
  });
}

TEST_CASE("configurations: vertex-face, apart and overlapping") {
  for (const double gap : {0.01, 1e-4, 0.0, -1e-4, -0.01}) {
    in_every_pose(cube(), shifted(tip(), {0.1, 0.2, 0.5 + gap}),
                  [gap](const Shape& a, const Shape& b, double) {
                    const PairContact contact = contact_of(a, b);
                    CHECK(contact.type == ContactType::VertexFace);
                    CHECK_FALSE(contact.nearest.indeterminate);
                    CHECK_THAT(contact.nearest.gap, WithinAbs(gap, 1e-12));
                    REQUIRE(contact.points.size() == 1);
                    CHECK(count_edge_edge(contact) == 0);
                    CHECK_THAT(contact.points[0].gap, WithinAbs(gap, 1e-12));
                  });
  }
}

TEST_CASE("configurations: crossed edges (G02), apart and overlapping") {
  const Shape lower = turned(cube(), Vector3::UnitX(), kPi / 4);
  for (const double gap : {0.01, 1e-5, -1e-5, -0.01}) {
    const Shape upper =
        shifted(turned(cube(), Vector3::UnitY(), kPi / 4), {0, 0, std::sqrt(2.0) + gap});
    in_every_pose(lower, upper, [gap](const Shape& a, const Shape& b, double) {
      const PairContact contact = contact_of(a, b);
      CHECK(contact.type == ContactType::EdgeEdgeCrossing);
      CHECK_FALSE(contact.nearest.indeterminate);
      CHECK_THAT(contact.nearest.gap, WithinAbs(gap, 1e-12));
      CHECK(contact.points.size() == 1);
      CHECK(count_edge_edge(contact) == 1);
    });
  }
}

TEST_CASE("configurations: parallel edges, plane open, two points") {
  in_every_pose(ridge(1.0), shifted(ridge_down(1.0), {0.5, 0, 0.01}),
                [](const Shape& a, const Shape& b, double) {
                  const PairContact contact = contact_of(a, b);
                  CHECK(contact.type == ContactType::EdgeEdgeParallel);
                  CHECK(contact.nearest.indeterminate);
                  CHECK_THAT(contact.nearest.gap, WithinAbs(0.01, 1e-12));
                  CHECK(contact.points.size() == 2);
                  REQUIRE(contact.polygon.size() == 2);
                  CHECK_THAT((contact.polygon[0] - contact.polygon[1]).norm(),
                             WithinAbs(1.5, 1e-12));
                  CHECK(contact.area == 0.0);
                });
}

TEST_CASE("configurations: edge-face, two points and the segment between them") {
  const Shape edge = turned(cube(), Vector3::UnitX(), kPi / 4);
  for (const double gap : {0.01, 1e-5, -1e-5, -0.01}) {
    in_every_pose(make_box({-2, -2, -1}, {0.25, 2, 0}), shifted(edge, {0, 0, std::sqrt(0.5) + gap}),
                  [gap](const Shape& a, const Shape& b, double) {
                    const PairContact contact = contact_of(a, b);
                    CHECK(contact.type == ContactType::EdgeFace);
                    CHECK_FALSE(contact.nearest.indeterminate);
                    CHECK_THAT(contact.nearest.gap, WithinAbs(gap, 1e-12));
                    CHECK(contact.points.size() == 2);
                    REQUIRE(contact.polygon.size() == 2);
                    CHECK_THAT((contact.polygon[0] - contact.polygon[1]).norm(),
                               WithinAbs(0.75, 1e-12));
                  });
  }
}

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

TEST_CASE("configurations: face-face turned by 45 degrees (G03), an octagon of eight points") {
  for (const double gap : {1e-4, 0.0, -1e-4}) {
    const Shape upper = shifted(turned(cube(), Vector3::UnitZ(), kPi / 4), {0, 0, 1.0 + gap});
    in_every_pose(cube(), upper, [gap](const Shape& a, const Shape& b, double) {
      const PairContact contact = contact_of(a, b);
      CHECK(contact.type == ContactType::FaceFace);
      CHECK_THAT(contact.nearest.gap, WithinAbs(gap, 1e-12));
      CHECK(contact.points.size() == 8);
      CHECK(count_edge_edge(contact) == 8);
      CHECK(contact.polygon.size() == 8);
      CHECK_THAT(contact.area, WithinAbs(2 * (std::sqrt(2.0) - 1), 1e-12));
      CHECK_THAT(area_of_points(contact), WithinAbs(contact.area, 1e-12));
      for (std::size_t i = 0; i < contact.polygon.size(); ++i) {
        const Vector3 side = contact.polygon[(i + 1) % 8] - contact.polygon[i];
        CHECK_THAT(side.norm(), WithinAbs(std::sqrt(2.0) - 1, 1e-12));
      }
    });
  }
}

TEST_CASE("configurations: crossed beams touch without a vertex in a face") {
  in_every_pose(make_box({-2, -0.5, 0}, {2, 0.5, 1}), make_box({-0.5, -2, 1}, {0.5, 2, 2}),
                [](const Shape& a, const Shape& b, double) {
                  const PairContact contact = contact_of(a, b);
                  CHECK(contact.type == ContactType::FaceFace);
                  CHECK(contact.nearest.status == PairStatus::Touching);
                  CHECK(contact.points.size() == 4);
                  CHECK(count_edge_edge(contact) == 4);
                  CHECK_THAT(contact.area, WithinAbs(1.0, 1e-12));
                  for (const ContactPoint& point : contact.points)
                    CHECK_THAT(point.area, WithinAbs(0.25, 1e-12));
                });
}

TEST_CASE("configurations: bricks one on another, edges over edges and in running bond") {
  const Vector3 brick(0.4, 0.2, 0.2);
  struct Course {
    Vector3 shift;
    double area;
  };
  const Shape lower = make_box(Vector3::Zero(), brick);
  for (const Course& course : {Course{{0, 0, 0.2}, 0.08}, Course{{0.2, 0, 0.2}, 0.04},
                               Course{{-0.1, 0.05, 0.2}, 0.045}, Course{{0.4, 0, 0}, 0.04}}) {
    in_every_pose(lower, make_box(course.shift, course.shift + brick),
                  [&](const Shape& a, const Shape& b, double) {
                    const PairContact contact = contact_of(a, b);
                    CHECK(contact.type == ContactType::FaceFace);
                    CHECK(contact.points.size() == 4);
                    CHECK_THAT(contact.area, WithinAbs(course.area, 1e-12));
                    CHECK_THAT(area_of_points(contact), WithinAbs(course.area, 1e-12));
                  });
  }
  const PairContact bond = contact_of(lower, make_box({0.2, 0, 0.2}, Vector3(0.6, 0.2, 0.4)));
  for (const Vector3& corner :
       {Vector3(0.2, 0, 0.2), Vector3(0.4, 0, 0.2), Vector3(0.2, 0.2, 0.2), Vector3(0.4, 0.2, 0.2)})
    CHECK(has_point(bond, corner));
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

TEST_CASE("configurations: parallel edges that rounding parts have two points") {
  Random random(11);
  const double off = 1e-12, beside = 4.5e-10, tolerance = 1e-9;
  const auto rounded = [&](const Vector3& min, const Vector3& max) {
    Points vertices = make_box(min, max).vertices();
    for (int v = 0; v < 8; ++v)
      for (int i = 0; i < 3; ++i) vertices(i, v) += random.uniform(-off, off);
    return make_hull(vertices).polyhedron;
  };
  int parallel = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const Shape a = rounded({0, -0.05, 0}, {1, 0, 0.5});
    const Shape b = rounded({0, beside, -0.5}, {1, 0.05 + beside, 0});
    PairContact contact;
    update_pair_contact(a, b, {.tolerance = tolerance}, contact);
    if (contact.type != ContactType::EdgeEdgeParallel) continue;
    ++parallel;
    CHECK(has_point(contact, {0, 0, 0}, tolerance));
    CHECK(has_point(contact, {1, 0, 0}, tolerance));
  }
  CHECK(parallel > 10);
}

TEST_CASE("configurations: a face no wider than the tolerance is an edge") {
  const Shape plate = make_box({-1, -1, -1}, {1, 1, 0});
  for (const double width : {1e-2, 1e-4}) {
    CAPTURE(width);
    const Shape blade = make_box({0, 0, 0}, {1, width, 1});
    for (const double lift : {0.0, 0.5}) {
      const PairContact narrow =
          contact_of(plate, shifted(blade, {0, 0, lift}), {.tolerance = 2 * width});
      CHECK(narrow.type == ContactType::EdgeFace);
      CHECK(narrow.area == 0.0);
      const PairContact wide =
          contact_of(plate, shifted(blade, {0, 0, lift}), {.tolerance = 0.5 * width});
      CHECK(wide.type == ContactType::FaceFace);
      CHECK_THAT(wide.area, WithinRel(width, 1e-12));
    }
  }
}

TEST_CASE("configurations: a wedge in a groove touches both its flanks with whole faces") {
  Points wedge(3, 6), left(3, 6);
  wedge << -1, -1, 1, 1, 0, 0, -1, 1, -1, 1, -1, 1, 1, 1, 1, 1, 0, 0;
  left << -2, -2, 0, 0, -2, -2, -2, 2, -2, 2, -2, 2, 2, 2, 0, 0, 0, 0;
  const Shape flank = make_hull(left).polyhedron;
  Points mirrored = left;
  mirrored.row(0) *= -1;
  for (const Shape& side : {flank, make_hull(mirrored).polyhedron}) {
    in_every_pose(side, make_hull(wedge).polyhedron, [](const Shape& a, const Shape& b, double) {
      const PairContact contact = contact_of(a, b);
      CHECK(contact.type == ContactType::FaceFace);
      CHECK(contact.nearest.status == PairStatus::Touching);
      CHECK(contact.points.size() == 4);
      CHECK_THAT(contact.area, WithinRel(2 * std::sqrt(2.0), 1e-12));
    });
  }
}

// Which of the two faces a foot on their common edge lies over is decided by less than tol: where
// the other one leans by less than 30 degrees it carries points, too, and its normal is not theirs.
TEST_CASE("configurations: points on the border of a face are not named by the one that leans") {
  const double beyond = 0.1 * kTolerance;
  for (const double lean : {0.5, 15.0, 29.0}) {
    Points ridged(3, 8);  // its top flat for x < 0, falling beyond
    const double fall = std::tan(lean * kPi / 180);
    ridged << -2, -2, 0, 0, 1, 1, 0, 0, -2, 2, -2, 2, -2, 2, -2, 2, 0, 0, 0, 0, -fall, -fall, -3,
        -3;
    const Shape support = make_hull(ridged).polyhedron;
    for (const double shift : {-beyond, 0.0, beyond}) {
      const Shape brick = make_box({-1.0 + shift, -0.5, 0}, {shift, 0.5, 1});
      in_every_pose(support, brick, [](const Shape& a, const Shape& b, double from_a) {
        const PairContact contact = contact_of(a, b);
        CHECK(contact.type == ContactType::FaceFace);
        CHECK(contact.points.size() == 4);
        for (const ContactPoint& point : contact.points) {
          const auto& of_support = from_a > 0 ? point.key.feature_a : point.key.feature_b;
          REQUIRE(of_support.kind == FeatureKind::Face);
          const Vector3 normal = (from_a > 0 ? a : b).face_normal(of_support.index);
          CHECK_THAT(from_a * normal.dot(point.normal), WithinAbs(1.0, 1e-12));
        }
      });
    }
  }
}

TEST_CASE("configurations: thin plates (G06)") {
  const Shape large = make_box({-50, -50, -0.001}, {50, 50, 0});
  const Shape small = transformed(make_box({-0.5, -0.5, 0}, {0.5, 0.5, 0.001}), 1,
                                  rotation_about(Vector3::UnitZ(), 17 * kPi / 180), {30, 20, 1e-7});
  const PairContact contact = contact_of(large, small, {});
  CHECK(contact.type == ContactType::FaceFace);
  CHECK_THAT(contact.nearest.gap, WithinAbs(1e-7, 1e-13));
  CHECK(contact.points.size() == 4);
  CHECK_THAT(contact.area, WithinAbs(1.0, 1e-9));
}

TEST_CASE("configurations: the published search fails, this one may not (G01)") {
  Points pyramid(3, 5), tetrahedron(3, 4);
  pyramid << -10, 10, 10, -10, 0, -10, -10, 10, 10, 0, 0, 0, 0, 0, -0.5;
  tetrahedron << 0, 1, -.5, -.5, 0, 0, .8, -.8, 0.005, 1, 1, 1;
  const PairContact contact =
      contact_of(make_hull(pyramid).polyhedron, make_hull(tetrahedron).polyhedron, {});
  CHECK(contact.type == ContactType::VertexFace);
  CHECK_THAT(contact.nearest.gap, WithinAbs(0.005, 1e-15));
  CHECK((contact.nearest.normal - Vector3::UnitZ()).norm() < 1e-14);
  CHECK((contact.nearest.point_a - Vector3::Zero()).norm() < 1e-14);
  CHECK(contact.points.size() == 1);
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

TEST_CASE("configurations: crossing at a small angle needs no endless projection (G04)") {
  for (const double degrees : {10.0, 5.0, 1.0, 0.1}) {
    const double angle = degrees * kPi / 180;
    const Shape upper =
        shifted(turned(ridge_down(10.0), Vector3::UnitZ(), angle), {3, 5 * std::tan(angle), 0.01});
    const PairContact contact = contact_of(ridge(10.0), upper, {});
    CAPTURE(degrees);
    CHECK(contact.type == ContactType::EdgeEdgeCrossing);
    CHECK_THAT(contact.nearest.gap, WithinAbs(0.01, 1e-12));
    CHECK(contact.nearest.iterations <= 64);
  }
}

TEST_CASE("configurations: points are as complete before contact as after") {
  const Shape lower = make_box({0, 0, 0}, {1, 1, 1});
  for (const double gap : {1e-2, 1e-4, 1e-9, 0.0, -1e-9, -1e-4, -1e-2}) {
    const PairContact contact = contact_of(lower, make_box({0.3, 0.2, 1 + gap}, {1.3, 1.2, 2}),
                                           {.tolerance = kTolerance, .reach = 1e-3});
    CAPTURE(gap);
    CHECK(contact.type == ContactType::FaceFace);
    REQUIRE(contact.points.size() == 4);
    CHECK(count_edge_edge(contact) == 2);
    CHECK_THAT(contact.area, WithinAbs(0.56, 1e-13));
    for (const ContactPoint& point : contact.points) CHECK_THAT(point.gap, WithinAbs(gap, 1e-15));
  }
}

TEST_CASE(
    "configurations: with a reach beyond the blocks' height only what faces the other carries") {
  const Shape below = make_box({0, 0, 0}, {1, 0.5, 0.2});
  const Shape above = make_box({0.5, 0.1, 0.2}, {1.5, 0.6, 0.4});
  in_every_pose(below, above, [](const Shape& a, const Shape& b, double) {
    const PairContact near = contact_of(a, b);
    const PairContact far = contact_of(a, b, {.tolerance = kTolerance, .reach = 1.0});
    CHECK(near.points.size() == 4);
    REQUIRE(far.points.size() == near.points.size());
    for (std::size_t k = 0; k < far.points.size(); ++k) {
      CHECK(far.points[k].key == near.points[k].key);
      CHECK(far.points[k].gap == near.points[k].gap);
    }
  });
}

TEST_CASE("configurations: of merged points the nearer one stays") {
  constexpr double kWide = 1e-2;  // tol, m
  Points points(3, 9);  // a roof whose ridge is flattened within tol, its lower corners first
  const double fall = 0.3 * kWide, aside = 0.8 * kWide;
  points << -1, 1, -1, 1, -1, 1, -1, 1, 0,  // x
      -aside, -aside, 0, 0, -1, -1, 1, 1, 0, -fall, -fall, 0, 0, -0.5, -0.5, -0.5, -0.5, -1;
  const Shape roof = make_hull(points).polyhedron;
  const Shape plate = make_box({-2, -2, 1e-3}, {2, 2, 1});
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    const PairContact contact =
        contact_of(renumbered(roof, random), renumbered(plate, random), {.tolerance = kWide});
    CHECK_THAT(contact.nearest.gap, WithinAbs(1e-3, 1e-12));
    REQUIRE(contact.points.size() == 2);
    for (const ContactPoint& point : contact.points) CHECK_THAT(point.gap, WithinAbs(1e-3, 1e-12));
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
      std::vector<ContactPoint> together, apart;
      const auto nearest =
          append_contacts_within_reach({0, 1}, below, above, {.reach = reach}, {}, together);
      append_contact_points({0, 1}, below, above, nearest, {.reach = reach - nearest.gap}, apart);
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
