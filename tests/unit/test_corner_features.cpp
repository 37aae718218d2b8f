/// Nearest features from two corners, and the search that is their fallback: both over the same
/// pairs.

#include "geometry/src/search/corner_features.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <quoin/geometry/build.hpp>

#include "geometry/src/certify/certificate.hpp"
#include "geometry/src/search/nearest_feature_search.hpp"
#include "support/catch.hpp"
#include "support/exact_gap.hpp"
#include "support/random.hpp"

using namespace quoin;
using namespace geometry;

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

Shape brick(tests::Random& random) {
  const Vector3 half(random.uniform(0.2, 0.6), random.uniform(0.2, 0.6), random.uniform(0.2, 0.6));
  return geometry::make_box(-half, half);
}
Shape prism(tests::Random& random) {
  const int sides = random.integer(3, 8);
  Points polygon(3, sides);
  for (int k = 0; k < sides; ++k) {
    const double angle = 6.283185307179586 * (k + random.uniform(0.1, 0.9)) / sides;
    polygon.col(k) = 0.5 * Vector3(std::cos(angle), std::sin(angle), 0.0);
  }
  return geometry::make_prism(polygon, {0, 0, random.uniform(0.3, 1.0)});
}
Shape tetrahedron(tests::Random& random) {
  Points points(3, 4);
  for (int k = 0; k < 4; ++k) points.col(k) = 0.6 * random.direction();
  return geometry::make_hull(points).polyhedron;
}
Shape placed(tests::Random& random, const Shape& solid, const Vector3& middle) {
  return {solid.shared_topology(), (random.rotation() * solid.vertices()).colwise() + middle};
}

geometry::Lengths lengths(const Shape& a, const Shape& b) {
  geometry::Lengths length;
  length.contact = geometry::default_tolerance(geometry::Body(a), geometry::Body(b));
  length.rounding = 5 * kEpsilon * std::max(a.diameter(), b.diameter());
  const double coordinate = std::max(a.largest_coordinate(), b.largest_coordinate());
  length.place = std::max(length.rounding, 2 * kEpsilon * coordinate);
  length.widest = std::max({length.contact, length.place, geometry::kClearAbove * length.rounding});
  return length;
}

/// The features that the corners span, if they are proved to be the nearest.
bool proved(const Shape& a, const Shape& b, std::span<const int> corners_a,
            std::span<const int> corners_b, NearestFeatures& answer) {
  Carrier by_a, by_b;
  return geometry::corner_carrier(a, corners_a, by_a) &&
         geometry::corner_carrier(b, corners_b, by_b) &&
         geometry::certify(a, b, by_a, by_b, lengths(a, b), nullptr, answer) == Trial::Proved;
}

void check_same(const NearestFeatures& x, const NearestFeatures& y) {
  REQUIRE(x.status == y.status);
  REQUIRE(x.gap == y.gap);
  REQUIRE(x.normal == y.normal);
  REQUIRE(x.point_a == y.point_a);
  REQUIRE(x.point_b == y.point_b);
  REQUIRE(x.feature_a == y.feature_a);
  REQUIRE(x.feature_b == y.feature_b);
  REQUIRE(x.residual_a == y.residual_a);
  REQUIRE(x.residual_b == y.residual_b);
  REQUIRE(x.rule == y.rule);
  REQUIRE(x.hint.vertices_a == y.hint.vertices_a);
  REQUIRE(x.hint.vertices_b == y.hint.vertices_b);
}

struct Counts {
  int apart = 0, by_corners = 0;
};

/// Corners, search and the whole query where the search is proved to have the answer.
Counts compare(tests::Random& random, Shape (*make_a)(tests::Random&),
               Shape (*make_b)(tests::Random&), int count) {
  Counts counts;
  for (int k = 0; k < count; ++k) {
    const Shape a = placed(random, make_a(random), random.point(-1, 1));
    const Shape b =
        placed(random, make_b(random), a.origin() + random.uniform(0.8, 2.0) * random.direction());
    REQUIRE(geometry::has_plain_corners(a, b));
    const Vector3 across = b.vertex_mean() - a.vertex_mean();
    const geometry::SearchResult found =
        geometry::nearest_feature_search(a, b, across, 0.25 * lengths(a, b).rounding);
    NearestFeatures by_search, by_corners;
    const bool first = geometry::certify_corners(a, b, lengths(a, b), by_corners) == Trial::Proved;
    if (found.outcome != geometry::SearchOutcome::Separated) {
      if (first) {  // a shallow overlap proves itself
        const double exact = tests::exact_gap(geometry::Body(a), geometry::Body(b));
        REQUIRE(std::abs(by_corners.gap - exact) <= 16 * kEpsilon * (a.diameter() + b.diameter()));
      }
      continue;
    }
    if (!proved(a, b, found.p, found.q, by_search)) continue;
    ++counts.apart;
    check_same(by_search, nearest_features(a, b));
    if (!first) continue;
    ++counts.by_corners;
    check_same(by_search, by_corners);
  }
  return counts;
}

}  // namespace

TEST_CASE("features of two corners are those that the search finds") {
  tests::Random random(8);
  const Counts bricks = compare(random, brick, brick, 10000);
  CHECK(bricks.apart > 4000);
  CHECK(bricks.by_corners > bricks.apart * 9 / 10);
  const std::array<Counts, 4> others{
      compare(random, prism, prism, 3000), compare(random, brick, tetrahedron, 3000),
      compare(random, tetrahedron, prism, 3000), compare(random, tetrahedron, tetrahedron, 3000)};
  for (const Counts& counts : others) {
    CHECK(counts.apart > 1000);
    CHECK(counts.by_corners > counts.apart / 2);
    CHECK(counts.by_corners < counts.apart);
  }
}

TEST_CASE("vertices in which more than three faces meet are left to the search") {
  tests::Random random(9);
  const Shape box = brick(random);
  Points points(3, 12);
  for (int k = 0; k < 12; ++k) points.col(k) = random.direction();
  const Shape hull = geometry::make_hull(points).polyhedron;
  CHECK(geometry::has_plain_corners(box, box));
  CHECK_FALSE(geometry::has_plain_corners(box, hull));
  CHECK_FALSE(geometry::has_plain_corners(hull, box));
}
