/// Least overlap of bricks over the 15 directions, against the polytope that knows no bricks.

#include <algorithm>
#include <quoin/geometry/build.hpp>

#include "geometry/src/search/nearest_feature_search.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"

using namespace quoin;
using namespace geometry;

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

Shape brick(tests::Random& random, const geometry::Matrix3& turn, const Vector3& middle) {
  const Vector3 half(random.uniform(0.2, 0.6), random.uniform(0.2, 0.6), random.uniform(0.2, 0.6));
  const Shape box = geometry::make_box(-half, half);
  return {box.shared_topology(), (turn * box.vertices()).colwise() + middle};
}

double rounding_of(const Shape& p, const Shape& q) {
  return 5 * kEpsilon * std::max(p.diameter(), q.diameter());
}

/// From a search that must have found them overlapping.
SearchResult by_polytope(const Shape& p, const Shape& q) {
  const double rounding = 0.25 * rounding_of(p, q);
  const SearchResult found =
      geometry::nearest_feature_search(p, q, q.vertex_mean() - p.vertex_mean(), rounding);
  return found.outcome == SearchOutcome::Overlapping
             ? geometry::expand_polytope(p, q, found, rounding)
             : SearchResult{};
}

}  // namespace

TEST_CASE("a brick's vertices are known by their places") {
  const Shape box = geometry::make_box({1, 2, 3}, {2, 4, 7});
  const std::span<const int> vertices = box.topology().brick();
  REQUIRE(vertices.size() == 8);
  const Vector3 base = box.vertex(vertices[0]);
  for (std::size_t place = 0; place < 8; ++place) {
    Vector3 expected = base;
    for (std::size_t k = 0; k < 3; ++k)
      if ((place >> k & 1) != 0) expected += box.vertex(vertices[std::size_t{1} << k]) - base;
    CHECK(box.vertex(vertices[place]) == expected);
  }
  const geometry::Points triangle =
      (geometry::Points(3, 3) << 0, 1, 0, 0, 0, 1, 0, 0, 0).finished();
  CHECK(geometry::make_prism(triangle, {0, 0, 1}).topology().brick().empty());
}

TEST_CASE("bricks that overlap part by the same facet as by the polytope") {
  tests::Random random(5);
  int compared = 0, overlapping = 0;
  for (int k = 0; k < 20000; ++k) {
    const Shape p = brick(random, random.rotation(), random.point(-1, 1));
    const Shape q = brick(random, random.rotation(),
                          p.origin() + random.uniform(0.1, 0.9) * random.direction());
    const SearchResult expected = by_polytope(p, q);
    if (expected.outcome != SearchOutcome::Overlapping) continue;
    ++overlapping;
    const SearchResult found = geometry::box_sat(p, q, rounding_of(p, q));
    if (found.outcome != SearchOutcome::Overlapping) continue;
    ++compared;
    REQUIRE((found.normal - expected.normal).norm() < 1e-13);
    REQUIRE(std::abs(found.bound - expected.bound) < 50 * rounding_of(p, q));
    for (std::size_t i = 0; i < 3; ++i) {  // its corners lie on the plane that both have found
      const auto height = [&](const SearchResult& of) {
        return found.normal.dot(q.vertex(of.q[i]) - p.vertex(of.p[i]));
      };
      REQUIRE(std::abs(height(found) - height(expected)) < 50 * rounding_of(p, q));
    }
  }
  CHECK(overlapping > 10000);
  CHECK(compared > overlapping * 99 / 100);
}

TEST_CASE("bricks with several directions of least overlap, and others, are left to the polytope") {
  const Shape box = geometry::make_box({0, 0, 0}, {1, 1, 1});
  const auto unclear = [&](const Shape& p, const Shape& q) {
    return geometry::box_sat(p, q, rounding_of(p, q)).outcome == SearchOutcome::Unclear;
  };
  CHECK(unclear(box, box));
  CHECK(unclear(box, geometry::make_box({0.9, 0.1, 0.1}, {1.9, 1.1, 1.1})));  // flush
  CHECK(unclear(box, geometry::make_box({0.25, 0.25, 0.25}, {0.75, 0.75, 0.75})));
  CHECK(unclear(box, geometry::make_box({1, 0, 0}, {2, 1, 1})));  // touching
  geometry::Points frustum = box.vertices();
  for (int v = 0; v < 8; ++v)
    if (frustum(2, v) > 0.5) frustum.col(v).head<2>() *= 0.5;
  tests::Random random(6);
  const Shape tapered(box.shared_topology(), frustum);
  REQUIRE_FALSE(tapered.topology().brick().empty());
  const Shape other = brick(random, random.rotation(), {0.4, 0.4, 1.1});
  CHECK(unclear(tapered, other));
  // What parts it from another solid most is told by its faces: its edges span no normals.
  CHECK(geometry::box_sat(tapered, other, rounding_of(tapered, other)).normal == Vector3::Zero());
  CHECK(geometry::box_sat(box, box, rounding_of(box, box)).normal != Vector3::Zero());
}
