/// One pair at a time: hints, placements that are none, and the certificate checked from outside.
/// Closed forms: tests/pairs/configurations.jsonl.

#include <cmath>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/nearest_features.hpp>

#include "referee/pairs/families.hpp"
#include "support/catch.hpp"

namespace {

using namespace quoin::geometry;
using quoin::referee::rotation_about;
using quoin::referee::transformed;
using quoin::tests::WithinAbs;

Shape cube(const Vector3& centre, double size = 1.0) {
  return make_box(centre - Vector3::Constant(size / 2), centre + Vector3::Constant(size / 2));
}

}  // namespace

TEST_CASE("nearest features: a wrong hint, of vertices that are not there, changes nothing") {
  const Shape a = cube({0, 0, 0});
  const Shape b = transformed(cube({0, 0, 0}), 1.0,
                              rotation_about(Vector3(1, 2, 3).normalized(), 0.7), {0.3, 0.2, 1.6});
  const NearestFeatures cold = nearest_features(a, b);
  FeatureHint hint;
  hint.vertices_a = {7, 99, -5, 7};
  hint.vertices_b = {3, 3, 1000, 0};
  hint.face_a = 77;
  hint.face_b = 2;
  hint.normal = Vector3(std::nan(""), 0, 1);
  for (const FeatureHint& start : {hint, cold.hint}) {
    const NearestFeatures warm = nearest_features(a, b, {}, start);
    CHECK(warm.gap == cold.gap);
    CHECK(warm.normal == cold.normal);
    CHECK(warm.point_a == cold.point_a);
    CHECK(warm.point_b == cold.point_b);
  }
  CHECK(nearest_features(a, b, {}, cold.hint).iterations == 1);
}

TEST_CASE("nearest features: a placement that is none is a status, cold and warm") {
  const double infinity = std::numeric_limits<double>::infinity();
  const Shape box = cube({0, 0, 0});
  const Body a(box);
  for (const Vector3& way : {Vector3(2, 0.1, 0.3), Vector3(2, 2, 0), Vector3(2, 0, 0)}) {
    const Placement placement{.translation = way};
    const FeatureHint warm = nearest_features(a, Body(box, placement)).hint;
    for (const double bad : {std::nan(""), infinity}) {
      for (int number = 0; number < 13; ++number) {
        Placement none = placement;
        if (number < 9) none.linear(number / 3, number % 3) = bad;
        if (number >= 9 && number < 12) none.translation[number - 9] = bad;
        if (number == 12) none.linear *= bad;
        for (const FeatureHint& hint : {FeatureHint{}, warm}) {
          const NearestFeatures answer = nearest_features(a, Body(box, none), {}, hint);
          CHECK(answer.status == PairStatus::NotConverged);
          CHECK(std::isnan(answer.gap));
        }
      }
    }
  }
}

TEST_CASE("nearest features: the certificate can be checked with two loops") {
  const Shape a = cube({0, 0, 0});
  const Shape b = transformed(cube({0, 0, 0}), 1.0,
                              rotation_about(Vector3(3, 1, 2).normalized(), 1.1), {0.9, 0.8, 1.4});
  const NearestFeatures n = nearest_features(a, b);
  REQUIRE(n.status == PairStatus::Separated);
  double beyond_a = -1.0, beyond_b = -1.0;
  for (int v = 0; v < 8; ++v) {
    beyond_a = std::max(beyond_a, n.normal.dot(a.vertex(v) - n.point_a));
    beyond_b = std::max(beyond_b, -n.normal.dot(b.vertex(v) - n.point_b));
  }
  CHECK_THAT(beyond_a, WithinAbs(n.residual_a, 1e-15));
  CHECK_THAT(beyond_b, WithinAbs(n.residual_b, 1e-15));
  CHECK_THAT((n.point_b - n.point_a).norm(), WithinAbs(n.gap, 1e-15));
}
