// A body – a shape and a placement – against the same solid with its vertices where they stand.
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/contact_point.hpp>

#include "referee/pairs/cut_cell.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"
#include "support/same_contacts.hpp"

namespace {

namespace geometry = quoin::geometry;
namespace tests = quoin::tests;
using namespace geometry;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

Shape random_shape(tests::Random& random) {
  if (random.integer(0, 1) == 0) {
    const Vector3 half(random.uniform(0.3, 1), random.uniform(0.3, 1), random.uniform(0.3, 1));
    return geometry::make_box(-half, half);
  }
  geometry::Points points(3, random.integer(4, 40));
  for (int k = 0; k < points.cols(); ++k) points.col(k) = random.direction();
  return geometry::make_hull(points).polyhedron;
}

/// A rotation, and of each third body a strain of up to 5 % besides.
Placement random_placement(tests::Random& random, const Vector3& translation) {
  Placement placement{random.rotation(), translation};
  if (random.integer(0, 2) == 0) {
    Matrix3 strain;
    for (int k = 0; k < 9; ++k) strain.data()[k] = random.uniform(-0.03, 0.03);
    placement.linear *= Matrix3::Identity() + 0.5 * (strain + strain.transpose());
  }
  return placement;
}

Shape copied(const Body& body) {
  Shape copy(body.shape());
  geometry::Points vertices(3, copy.vertex_count());
  for (int v = 0; v < copy.vertex_count(); ++v) vertices.col(v) = body.vertex(v);
  copy.set_vertices(vertices);
  return copy;
}

/// A cube with four corners off, some of them by two planes that are nearly one.
Shape cut_cube(tests::Random& random) {
  tests::Cell cell = tests::box_cell({-1, -1, -1}, {1, 1, 1});
  Vector3 normal = Vector3::UnitX();
  double level = 0.0;
  for (int k = 0; k < 4; ++k) {
    const double off = k > 0 && random.chance(0.6) ? random.log_uniform(1e-12, 1e-1) : 2.0;
    normal = (off < 1.0 ? Vector3(normal + off * random.direction()) : random.direction());
    normal.normalize();
    level = off < 1.0 ? level * (1 + 0.1 * off) : random.uniform(0.5, 1.1);
    cell = tests::cut(cell, normal, level, 0.0);
  }
  return geometry::make_hull(cell.points()).polyhedron;
}

/// How far a body reaches along a direction, m.
double reach(const Body& body, const Vector3& direction) {
  double most = -HUGE_VAL;
  for (int v = 0; v < body.shape().vertex_count(); ++v)
    most = std::max(most, direction.dot(body.vertex(v)));
  return most;
}

}  // namespace

TEST_CASE("a body adds no more than its twelve numbers and what follows from them") {
  STATIC_REQUIRE(sizeof(Body) <= 256);
}

TEST_CASE("bodies are answered as copies of them with their vertices where they stand") {
  tests::Random random(21);
  int overlapping = 0, deformed = 0;
  for (int k = 0; k < 3000; ++k) {
    const Shape shape_a = random_shape(random), shape_b = random_shape(random);
    const Body a(shape_a, random_placement(random, random.point(-1, 1)));
    const Body b(shape_b, random_placement(random, random.uniform(0.2, 3.0) * random.direction()));
    const NearestFeatures placed = geometry::nearest_features(a, b);
    const NearestFeatures copies = geometry::nearest_features(copied(a), copied(b));
    const double allowed = 16 * kEpsilon * 2.5 + 1e-12 * std::abs(copies.gap);
    REQUIRE(std::abs(placed.gap - copies.gap) <= allowed);
    REQUIRE(placed.status == copies.status);
    REQUIRE(std::abs(placed.normal.norm() - 1.0) <= 4 * kEpsilon);
    // The normal parts the bodies by the gap: nothing of either reaches beyond its witness.
    REQUIRE(-reach(b, -placed.normal) - reach(a, placed.normal) >= placed.gap - allowed);
    REQUIRE((placed.point_b - placed.point_a - placed.gap * placed.normal).norm() <= allowed);
    overlapping += placed.gap < 0.0;
    deformed += !a.is_rigid() || !b.is_rigid();
  }
  CHECK(overlapping > 300);
  CHECK(deformed > 1000);
}

TEST_CASE("nothing depends on where the pair stands") {
  tests::Random random(22);
  for (int k = 0; k < 500; ++k) {
    const Shape shape_a = random_shape(random), shape_b = random_shape(random);
    Placement at_a = random_placement(random, Vector3::Zero());
    Placement at_b = random_placement(random, Vector3::Zero());
    // Places that can be shifted exactly.
    at_a.translation = (random.point(-1, 1) * 0x1p20).array().round() * 0x1p-20;
    at_b.translation = (random.point(-1, 1) * 0x1.8p21).array().round() * 0x1p-20;
    const NearestFeatures here = geometry::nearest_features({shape_a, at_a}, {shape_b, at_b});
    const Vector3 shift(0x1p20, -0x1p22, 0x1p30);
    at_a.translation += shift;
    at_b.translation += shift;
    const NearestFeatures there = geometry::nearest_features({shape_a, at_a}, {shape_b, at_b});
    REQUIRE(there.status == here.status);
    REQUIRE(there.gap == here.gap);
    REQUIRE(there.normal == here.normal);
    REQUIRE(there.residual_a == here.residual_a);
    REQUIRE(there.residual_b == here.residual_b);
    REQUIRE(there.feature_a == here.feature_a);
    REQUIRE(there.feature_b == here.feature_b);
    REQUIRE(there.iterations == here.iterations);
  }
}

TEST_CASE("a turned brick on its twin has the same flush contact anywhere") {
  tests::Random random(23);
  const Shape brick = geometry::make_box({-0.2, -0.1, -0.05}, {0.2, 0.1, 0.05});
  for (int k = 0; k < 300; ++k) {
    const Matrix3 turn = random.rotation();
    for (const double far : {0.0, 10.0, 1e3, 1e6}) {
      const Vector3 at = far * Vector3(0.6, -0.64, 0.48);
      // A gap that the rounding of the places cannot hide.
      const double gap = std::max(1e-6, 1e-9 * far);
      const Body a(brick, {turn, at}), b(brick, {turn, at + turn * Vector3(0.1, 0.05, 0.1 + gap)});
      geometry::PairContact contact;
      geometry::update_pair_contact(a, b, {.reach = 1e-6}, contact);
      REQUIRE(contact.type == geometry::ContactType::FaceFace);
      REQUIRE(contact.points.size() == 4);
      REQUIRE(std::abs(contact.nearest.gap - gap) <= 4 * kEpsilon * (1 + far));
      REQUIRE(std::abs(contact.area - 0.3 * 0.15) <= 4 * kEpsilon * (1 + far));
    }
  }
}

TEST_CASE("nearest features and then contact points are those of one call, anywhere") {
  tests::Random random(25);
  const Shape cube = geometry::make_box({-1, -1, -1}, {1, 1, 1});
  for (int k = 0; k < 2000; ++k) {
    const Shape shape = cut_cube(random);
    const double far = k % 2 == 0 ? 1e8 : 0.0, apart = random.uniform(-0.1, 0.5);
    const Placement at_a{random.rotation(), far * Vector3(1, -0.3, 0.7)};
    Placement at_b{random.rotation(), at_a.translation + 4 * random.direction()};
    const NearestFeatures before = geometry::nearest_features({shape, at_a}, {cube, at_b});
    at_b.translation += (apart - before.gap) * before.normal;
    const Body a(shape, at_a), b(cube, at_b);
    for (const geometry::PointFrame frame :
         {geometry::PointFrame::World, geometry::PointFrame::Bodies}) {
      const geometry::ContactOptions options{.reach = 1e-6, .frame = frame};
      geometry::PairContact together;
      geometry::update_pair_contact(a, b, options, together);
      std::vector<geometry::ContactPoint> points;
      const NearestFeatures nearest = geometry::nearest_features(a, b);
      geometry::ContactOptions within = options;
      within.reach += nearest.gap;
      geometry::append_contacts_within_reach({0, 1}, a, b, within, {}, points);
      REQUIRE(tests::same_but_previous(points, together.points));
    }
  }
}

TEST_CASE("swapping two bodies changes no bit") {
  tests::Random random(24);
  for (int k = 0; k < 1000; ++k) {
    const Shape shape = random_shape(random);
    const Body a(shape, random_placement(random, random.point(-1, 1)));
    const Body b(shape, random_placement(random, random.uniform(0.2, 3.0) * random.direction()));
    const NearestFeatures ab = geometry::nearest_features(a, b);
    const NearestFeatures ba = geometry::nearest_features(b, a);
    REQUIRE(ab.gap == ba.gap);
    REQUIRE(ab.normal == Vector3(-ba.normal));
    REQUIRE(ab.point_a == ba.point_b);
    REQUIRE(ab.point_b == ba.point_a);
    REQUIRE(ab.feature_a == ba.feature_b);
    REQUIRE(geometry::nearest_features(a, b, {}, ab.hint).gap == ab.gap);
    REQUIRE(geometry::nearest_features(a, b, {}, ab.hint).point_a == ab.point_a);
  }
}
