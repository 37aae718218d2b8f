/// The exact search of solids that share a point: closed forms, the arbiter, and its bounds.

#include "geometry/src/search/exact_search.hpp"

#include <cmath>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/nearest_features.hpp>

#include "referee/pairs/exact_arbiter.hpp"
#include "referee/pairs/families.hpp"
#include "support/catch.hpp"
#include "support/check_pair.hpp"
#include "support/counted_allocations.hpp"

using namespace quoin;
using namespace geometry;
using tests::allocations;
using tests::Random;
using tests::WithinAbs;

namespace {

double larger(const Shape& p, const Shape& q) { return std::max(p.diameter(), q.diameter()); }

/// The search as it is reached, of solids that touch or overlap within rounding.
LeastOverlap overlap_of(const Shape& p, const Shape& q) {
  return geometry::exact_overlap(p, q, geometry::exact_nearest(p, q, {}, 256));
}

Shape moved(const Shape& solid, const Vector3& shift) {
  return tests::transformed(solid, 1.0, Matrix3::Identity(), shift);
}
Shape turned(const Shape& solid, const Matrix3& turn) {
  return tests::transformed(solid, 1.0, turn, Vector3::Zero());
}
Shape cube(const Vector3& low, double size) { return make_box(low, low + Vector3::Constant(size)); }

/// On multiples of 2^-20, so that shifts by its coordinates round nothing.
Shape round_hull(Random& random, int count) {
  Points points(3, count);
  for (Eigen::Index k = 0; k < count; ++k) points.col(k) = random.direction();
  for (double& x : points.reshaped()) x = std::ldexp(std::round(std::ldexp(x, 20)), -20);
  return make_hull(points).polyhedron;
}

int farthest(const Shape& solid, const Vector3& direction) {
  return geometry::support(solid, direction).vertex;
}

/// Two solids in their own frames.
struct Shapes {
  std::string family;
  Shape a, b;
};

/// Q shifted so that a vertex of it comes to a vertex of P on the other side of a plane.
Shapes touching_in_a_vertex(const Shape& p, const Shape& q, const Vector3& n) {
  return {"", p, moved(q, p.vertex(farthest(p, n)) - q.vertex(farthest(q, -n)))};
}

/// Points on a sphere, evenly.
Shape sphere(int count) {
  Points points(3, count);
  for (int k = 0; k < count; ++k) {
    const double z = 1 - (2 * k + 1.0) / count, angle = k * std::numbers::pi * (3 - std::sqrt(5.0));
    const double radius = std::sqrt(1 - z * z);
    points.col(k) << radius * std::cos(angle), radius * std::sin(angle), z;
  }
  return make_hull(points).polyhedron;
}

/// `per_face` points on a circle in each face of a unit cube.
Shape studded_cube(int per_face) {
  Points points(3, 6 * per_face);
  Eigen::Index k = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      for (int i = 0; i < per_face; ++i) {
        const double angle = 2 * std::numbers::pi * i / per_face;
        points(axis, k) = side;
        points((axis + 1) % 3, k) = 0.5 + 0.45 * std::cos(angle);
        points((axis + 2) % 3, k++) = 0.5 + 0.45 * std::sin(angle);
      }
    }
  }
  return make_hull(points).polyhedron;
}

/// By how much the gap is off, in eps of the larger diameter; the least that the promise leaves for
/// all other steps is half.
double error_of(const Shapes& pair, double gap) {
  const long double exact = tests::exact_gap(pair.a.vertices(), pair.b.vertices()).gap;
  return static_cast<double>(std::abs(gap - exact)) / (kEpsilon * larger(pair.a, pair.b));
}

/// How far a plane is from the overlap that is said of it, in the same units.
double plane_error(const Shapes& pair, const LeastOverlap& found) {
  const Vector3 origin = pair.a.vertex(0);
  const long double gap = -tests::support(pair.b.vertices(), -found.normal, origin) -
                          tests::support(pair.a.vertices(), found.normal, origin);
  return static_cast<double>(std::abs(gap - found.gap)) / (kEpsilon * larger(pair.a, pair.b));
}

}  // namespace

TEST_CASE(
    "exact overlap: all directions of equal overlap are counted, the first in their order is "
    "taken") {
  const Shape outer = cube(Vector3::Constant(-1), 2), inner = cube(Vector3::Constant(-0.25), 0.5);
  for (const auto& [p, q] : {std::pair{outer, inner}, {inner, outer}}) {
    const LeastOverlap found = overlap_of(p, q);
    CHECK(found.converged);
    CHECK(found.gap == -1.25);
    CHECK(found.directions == 6);
    CHECK_FALSE(found.middle);
    CHECK(found.normal == Vector3::UnitX());
  }
  const LeastOverlap beside = overlap_of(outer, moved(inner, {0, -0.5, 0.5}));
  CHECK(beside.gap == -0.75);
  CHECK(beside.directions == 2);
  CHECK(beside.normal == Vector3::UnitZ());
  const LeastOverlap contained = overlap_of(outer, moved(inner, {0, -0.5, 0.125}));
  CHECK(contained.gap == -0.75);
  CHECK(contained.directions == 1);
  CHECK(contained.normal == -Vector3::UnitY());
  const Points corners =
      (Points(3, 6) << 1, -1, 0, 0, 0, 0, 0, 0, 1, -1, 0, 0, 0, 0, 0, 0, 1, -1).finished();
  const Shape octahedron = make_hull(corners).polyhedron;
  const LeastOverlap same = overlap_of(octahedron, octahedron);
  CHECK_THAT(same.gap, WithinAbs(-2 / std::sqrt(3.0), 4 * kEpsilon));
  CHECK(same.directions == 8);
}

TEST_CASE("exact overlap: against the arbiter") {
  Random random(2);
  int pairs = 0, touching = 0;
  const auto check = [&](const Shapes& pair, double allowed) {
    const geometry::ActiveFeatures start = geometry::exact_nearest(pair.a, pair.b, {}, 256);
    if (!start.overlapping) return;
    const LeastOverlap found = geometry::exact_overlap(pair.a, pair.b, start);
    REQUIRE(found.converged);
    INFO(tests::to_text({"", pair.a, pair.b}));
    REQUIRE(error_of(pair, found.gap) <= allowed);
    REQUIRE(plane_error(pair, found) <= 4.0);
    ++pairs;
    touching += std::abs(found.gap) <= 8 * kEpsilon * larger(pair.a, pair.b) ? 1 : 0;
  };
  const auto family_count = static_cast<int>(tests::family_names().size()) - 1;
  for (int family = 0; family < family_count; ++family) {
    for (int k = 0; k < 150; ++k) {
      const tests::SolidPair drawn = tests::make_pair(family, random);
      check({"", tests::polyhedron_of(drawn.a), tests::polyhedron_of(drawn.b)}, 8.0);
    }
  }
  for (int k = 0; k < 400; ++k) {  // in a vertex, in any pose
    const Shape p = turned(round_hull(random, random.integer(4, 12)), random.rotation());
    const Shape q = turned(round_hull(random, random.integer(4, 12)), random.rotation());
    const Shapes pair = touching_in_a_vertex(p, q, random.direction());
    check(pair, 8.0);
    check({"", pair.a, moved(pair.b, random.log_uniform(1e-17, 1e-13) * random.direction())}, 8.0);
  }
  for (int k = 0; k < 10; ++k)
    check({"", round_hull(random, 60), moved(round_hull(random, 60), random.point(-1, 1))}, 8.0);
  check({"", studded_cube(12), moved(studded_cube(12), {0.25, 0.125, 0.5})}, 8.0);
  CHECK(pairs > 1000);
  CHECK(touching > 300);
}

TEST_CASE("exact overlap: witnesses lie on the solids where planes nearly tie") {
  Random random(6);
  for (int k = 0; k < 3000; ++k) {  // one solid in another, tilted by next to nothing
    const Vector3 half(random.uniform(0.2, 1), random.uniform(0.2, 1), random.uniform(0.2, 1));
    const Shape p =
        k % 4 == 0 ? round_hull(random, 12) : turned(make_box(-half, half), random.rotation());
    const Matrix3 tilt = tests::rotation_about(random.direction(), random.log_uniform(1e-9, 1e-2));
    const Vector3 shift = random.log_uniform(1e-10, 0.3) * random.direction();
    const Shapes pair{"", p, moved(turned(p, tilt), shift)};
    const std::vector<tests::Fault> faults =
        tests::check_against_exact({"", pair.a, pair.b}).faults;
    INFO(tests::to_text({"", pair.a, pair.b}));
    for (const tests::Fault& fault : faults) {
      INFO(fault.kind + ": " + fault.text);
      REQUIRE(fault.kind != "witness");
      REQUIRE(fault.kind != "gap");
      REQUIRE(fault.kind != "certificate");
    }
  }
}

TEST_CASE("exact overlap: the work is bounded, and nothing is allocated") {
  Random random(4);
  const auto run = [](const Shape& p, const Shape& q) {
    const long before = allocations;
    const geometry::ActiveFeatures start = geometry::exact_nearest(p, q, {}, 256);
    const LeastOverlap found = geometry::exact_overlap(p, q, start);
    CHECK(allocations == before);
    CHECK(start.overlapping);
    CHECK(found.converged);
    return found;
  };
  const Shapes tip =
      touching_in_a_vertex(round_hull(random, 400), round_hull(random, 400), random.direction());
  CHECK(run(tip.a, tip.b).iterations < 150);
  CHECK(run(studded_cube(36), studded_cube(36)).iterations < 100);
  const Matrix3 turn = random.rotation();
  const Shape coarse = sphere(500), fine = sphere(3000);
  CHECK(run(coarse, turned(coarse, turn)).iterations < 3000);
  CHECK(run(fine, turned(fine, turn)).iterations < 20000);  // by octants
}
