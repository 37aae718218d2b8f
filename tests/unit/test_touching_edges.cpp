/// Bricks that touch along an edge of each, within noise: the plane that is taken has the exact
/// gap.

#include "geometry/src/search/touching_edges.hpp"

#include <cmath>
#include <quoin/geometry/build.hpp>

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

}  // namespace

TEST_CASE("edges beside each other within noise have the exact gap, whatever carries it") {
  tests::Random random(15);
  const Shape brick = geometry::make_box({-0.25, -0.125, -0.125}, {0.25, 0.125, 0.125});
  const double allowed = 16 * kEpsilon * brick.diameter();
  int proved = 0, overlapping = 0;
  for (int k = 0; k < 600; ++k) {
    const double noise = random.log_uniform(1e-15, 1e-9);
    const auto noisy = [&](const Vector3& step) {
      return Placement{tests::rotation_about(random.direction(), noise * random.uniform(0, 1)),
                       step + noise * random.direction()};
    };
    const Body a(brick, noisy(Vector3::Zero()));
    const Body b(brick, noisy({random.chance(0.5) ? 0.25 : 0.0, 0.25, 0.25}));
    const double exact = tests::exact_gap(a, b);
    const double limit = 1e-12 * std::abs(exact) + allowed;
    const geometry::NearestFeatures whole = geometry::nearest_features(a, b);
    REQUIRE(std::abs(whole.gap - exact) <= limit);
    CHECK(geometry::nearest_features(a, b, {}, whole.hint).gap == whole.gap);
    CHECK(geometry::nearest_features(b, a).gap == whole.gap);

    const geometry::PlacedPair pair(a, b);
    geometry::LateInit<geometry::ContactPolygon> faces;
    geometry::Optimum optimum(faces);
    const geometry::Lengths length = geometry::lengths(pair.a, pair.b, 0.0);
    const Vector3 across = random.chance(0.5) ? Vector3::UnitY() : Vector3::UnitZ();
    if (!geometry::touching_edges(pair.a, pair.b, length, across, optimum)) continue;
    ++proved;
    overlapping += exact < 0.0;
    REQUIRE(std::abs(optimum.plane.gap - exact) <= limit);
  }
  CHECK(proved > 200);
  CHECK(overlapping > 30);
}

TEST_CASE("edges that cross, or lie at a corner of both bricks, are left to others") {
  const Shape cube = geometry::make_box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
  const auto answered = [&](const Placement& aside) {
    const Body a(cube), b(cube, aside);
    const geometry::PlacedPair pair(a, b);
    geometry::LateInit<geometry::ContactPolygon> faces;
    geometry::Optimum optimum(faces);
    return geometry::touching_edges(pair.a, pair.b, geometry::lengths(pair.a, pair.b, 0.0),
                                    Vector3::UnitZ(), optimum);
  };
  CHECK(!answered({tests::rotation_about({0.6, 0.8, 0.0}, 0.1), {0.0, 1.1, 1.1}}));
  CHECK(!answered({tests::rotation_about({0.6, 0.8, 0.0}, 1e-12), {1.0, 1.0, 1.0}}));
}
