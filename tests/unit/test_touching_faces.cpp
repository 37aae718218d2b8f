/// Bricks whose faces lie on each other within noise: the corner where they come nearest carries
/// the exact gap, or the answer is left to others.

#include "geometry/src/search/touching_faces.hpp"

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

}  // namespace

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
