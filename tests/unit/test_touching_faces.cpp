/// Bricks whose faces lie on each other within noise: the corner where they come nearest carries
/// the exact gap, or the answer is left to others. Neither a hint nor who is A changes a bit.

#include "geometry/src/search/touching_faces.hpp"

#include <algorithm>
#include <cmath>
#include <quoin/geometry/build.hpp>

#include "support/bits.hpp"
#include "support/catch.hpp"
#include "support/exact_gap.hpp"
#include "support/random.hpp"

using namespace quoin;
using geometry::Body;
using geometry::Placement;
using geometry::Shape;
using geometry::Vector3;

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

struct Found {
  bool proved = false;
  double gap = 0.0;
};

Found touching(const Body& a, const Body& b, const Vector3& across) {
  const geometry::PlacedPair pair(a, b);
  geometry::LateInit<geometry::ContactPolygon> faces;
  geometry::Optimum optimum(faces);
  const geometry::Lengths length = geometry::lengths(pair.a, pair.b, 0.0);
  const bool proved = geometry::touching_faces(pair.a, pair.b, length, across, optimum);
  return {proved, optimum.plane.gap};
}

/// One answer with its points; the hint for the next.
struct Answer {
  geometry::NearestFeatures nearest;
  std::vector<geometry::ContactPoint> points;

  Answer(const Body& a, const Body& b, geometry::FeatureHint& hint) {
    nearest = geometry::append_contacts_within_reach({0, 1}, a, b, {.reach = 1e-4}, hint, points);
    hint = nearest.hint;
  }
  /// As of B and A. Places are in the world, so only who is who changes.
  Answer mirrored() const {
    Answer other = *this;
    geometry::NearestFeatures& n = other.nearest;
    std::swap(n.point_a, n.point_b);
    std::swap(n.feature_a, n.feature_b);
    std::swap(n.residual_a, n.residual_b);
    n.normal = Vector3::Zero() - n.normal;  // one zero
    for (geometry::ContactPoint& point : other.points) std::swap(point.point_a, point.point_b);
    return other;
  }
  /// Of its points in any order and under any names: which of several names a point gets, and so
  /// where it stands in the list, hangs on who is A.
  std::vector<std::vector<std::uint64_t>> bits_of_places() const {
    std::vector<std::vector<std::uint64_t>> places;
    for (const geometry::ContactPoint& point : points) {
      const std::array ends{point.point_a, point.point_b};
      places.push_back(tests::bits_of(ends, point.gap, point.area).all);
    }
    std::sort(places.begin(), places.end());
    return places;
  }
};

/// A step from one brick of a wall to the next: with faces, edges or a vertex on it.
Vector3 step_in_wall(tests::Random& random) {
  const bool over = random.chance(0.7), beside = random.chance(0.6);
  const Vector3 step(random.chance(0.5) ? 0.25 : (random.chance(0.5) ? 0.5 : 0.1),
                     beside ? 0.25 : 0.0, over ? 0.25 : 0.0);
  return over || beside ? step : Vector3(0.5, 0.0, 0.0);
}

/// Two neighbours of a wall that tremble, mostly by what is of the scale of the rounding, where
/// planes are nearly as good.
class Neighbours {
 public:
  explicit Neighbours(tests::Random& random)
      : noise(random.chance(0.1) ? 0.0
                                 : random.log_uniform(1e-16, random.chance(0.8) ? 1e-13 : 1e-9)),
        step(step_in_wall(random)),
        heading_(random.chance(0.5) ? random.rotation()
                                    : geometry::Matrix3(geometry::Matrix3::Identity())),
        random_(random) {}
  Body shaken(const Vector3& place) const {
    const geometry::Matrix3 turn =
        tests::rotation_about(random_.direction(), noise * random_.uniform(0, 1));
    return Body(brick_, {heading_ * turn, heading_ * (place + noise * random_.direction())});
  }
  const double noise;  // m, rad
  const Vector3 step;

 private:
  Shape brick_ = geometry::make_box({-0.25, -0.125, -0.125}, {0.25, 0.125, 0.125});
  geometry::Matrix3 heading_;
  tests::Random& random_;
};

}  // namespace

TEST_CASE("bricks of a wall with noise: neither a hint nor who is A changes a bit") {
  tests::Random random(tests::environment_number("QUOIN_SEED", 19));
  const auto pairs = tests::environment_number("QUOIN_CASES", 4000);
  for (std::uint64_t k = 0; k < pairs; ++k) {
    const Neighbours bricks(random);
    geometry::FeatureHint hint, mirrored_hint;
    for (int move = 0; move < 4; ++move) {
      const Body a = bricks.shaken({0, 0, 0}), b = bricks.shaken(bricks.step);
      geometry::FeatureHint none;
      const Answer warm(a, b, hint), cold(a, b, none);
      const Answer mirrored = Answer(b, a, mirrored_hint).mirrored();
      CAPTURE(k, move, bricks.noise, bricks.step.transpose());
      REQUIRE(tests::bits_of(warm.nearest) == tests::bits_of(cold.nearest));
      REQUIRE(tests::bits_of(warm.points) == tests::bits_of(cold.points));
      REQUIRE(tests::bits_of(mirrored.nearest) == tests::bits_of(cold.nearest));
      REQUIRE(mirrored.bits_of_places() == cold.bits_of_places());
    }
  }
}

// Two edges nearly beside each other whose gap is a few roundings: the line across them, turned by
// what rounding leaves of it, has another vertex on its other side. Such lines are no proof.
TEST_CASE("a line that rounding may turn from one vertex to another: a hint changes no bit") {
  const Shape brick = geometry::make_box({-0.25, -0.125, -0.125}, {0.25, 0.125, 0.125});
  Placement below, beside;
  below.translation << -0x1.62c6c6a3fb0bp-49, 0x1.b2b9c636a7a24p-50, -0x1.d35d995910e58p-49;
  below.linear << 0x1p+0, -0x1.357f61efc7f7cp-54, -0x1.e2101fa8544d2p-52, 0x1.357f61efc7f78p-54,
      0x1p+0, -0x1.24406c84f94ap-53, 0x1.e2101fa8544d2p-52, 0x1.24406c84f949ep-53, 0x1p+0;
  beside.translation << 0x1.fffffffffffd5p-2, 0x1.fffffffffffe4p-3, 0x1.000000000004p-2;
  beside.linear << 0x1p+0, -0x1.1a59dd35b2752p-50, -0x1.d7e0718dc79ap-50, 0x1.1a59dd35b2758p-50,
      0x1p+0, 0x1.aa87f10e6b9b9p-51, 0x1.d7e0718dc799cp-50, -0x1.aa87f10e6b9c9p-51, 0x1p+0;
  const Body a(brick, below), b(brick, beside);
  geometry::FeatureHint none;
  const Answer cold(a, b, none);
  const std::array<int, 2> of_a{5, 7}, of_b{0, 2};
  for (const int kind : {0, 1, 2}) {  // the edges, or a vertex of each
    geometry::FeatureHint hint;
    hint.normal = {0.9645504, 0.0, 0.2638443};
    hint.vertices_a = {of_a[kind == 1 ? 1 : 0], kind == 0 ? of_a[1] : -1, -1, -1};
    hint.vertices_b = {of_b[kind == 2 ? 1 : 0], kind == 0 ? of_b[1] : -1, -1, -1};
    CAPTURE(kind);
    REQUIRE(tests::bits_of(Answer(a, b, hint).nearest) == tests::bits_of(cold.nearest));
  }
}

TEST_CASE("faces that lie on each other within noise have the exact gap") {
  tests::Random random(14);
  const Shape brick = geometry::make_box({-0.25, -0.125, -0.125}, {0.25, 0.125, 0.125});
  const double allowed = 16 * kEpsilon * brick.diameter();
  int proved = 0, overlapping = 0;
  for (int k = 0; k < 400; ++k) {
    const double noise = random.log_uniform(1e-16, 1e-9);
    const Placement below{tests::rotation_about(random.direction(), noise * random.uniform(0, 1)),
                          noise * random.direction()};
    // Coplanar sides within noise, or not.
    const Vector3 step(random.chance(0.5) ? 0.25 : 0.1, random.chance(0.5) ? 0.0 : 0.05, 0.25);
    const Placement above{tests::rotation_about(random.direction(), noise * random.uniform(0, 1)),
                          step + noise * random.direction()};
    const Body a(brick, below), b(brick, above);
    const Found found = touching(a, b, Vector3::UnitZ());
    if (!found.proved) continue;
    ++proved;
    const double exact = tests::exact_gap(a, b);
    overlapping += exact < 0.0;
    REQUIRE(std::abs(found.gap - exact) <= 1e-12 * std::abs(exact) + allowed);
  }
  CHECK(proved > 350);
  CHECK(overlapping > 100);
}

TEST_CASE("faces that share but a strip are no proof of a deeper overlap") {
  tests::Random random(16);
  const Shape cube = geometry::make_box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
  for (int k = 0; k < 200; ++k) {  // the side faces overlap by a tenth of it
    const Placement aside{
        tests::rotation_about(random.direction(), random.log_uniform(1e-16, 1e-10)),
        {0.3, 1 - 1e-10, 1 - 1e-9}};
    const Body a(cube, {}), b(cube, aside);
    const Found found = touching(a, b, Vector3::UnitZ());
    if (found.proved)
      CHECK(std::abs(found.gap - tests::exact_gap(a, b)) <= 16 * kEpsilon * cube.diameter());
  }
}

TEST_CASE("bricks that lean on each other are proved from last step's features at once") {
  tests::Random random(17);
  const Shape brick = geometry::make_box({-0.5, -0.25, -0.2}, {0.5, 0.25, 0.2});
  int at_once = 0, overlapping = 0;
  for (int k = 0; k < 400; ++k) {
    const double lean = random.log_uniform(1e-7, 1e-3);
    const geometry::Matrix3 turn = random.rotation();
    const Vector3 axis(random.uniform(-1, 1), random.uniform(-1, 1), 0.0);
    const Vector3 step(random.uniform(-0.4, 0.4), random.uniform(-0.2, 0.2), 0.4 - 2 * lean);
    const Body a(brick, {turn, random.point(-2, 2)});
    const Body b(brick, {turn * tests::rotation_about(axis.normalized(), lean),
                         a.placement().translation + turn * step});
    geometry::FeatureHint hint;
    const Answer cold(a, b, hint), warm(a, b, hint);
    REQUIRE(tests::bits_of(warm.nearest) == tests::bits_of(cold.nearest));
    REQUIRE(tests::bits_of(warm.points) == tests::bits_of(cold.points));
    const double exact = tests::exact_gap(a, b);
    REQUIRE(std::abs(warm.nearest.gap - exact) <= 16 * kEpsilon * brick.diameter());
    overlapping += exact < 0.0;
    at_once += warm.nearest.iterations == 1;
  }
  CHECK(overlapping > 350);
  CHECK(at_once > 350);
}
