/// Least overlap by the polytope, against all faces and pairs of edges of the exact hulls.

#include "geometry/src/search/exact_search.hpp"
#include "geometry/src/search/nearest_feature_search.hpp"

#include <quoin/geometry/build.hpp>
#include <vector>

#include "support/catch.hpp"
#include "support/random.hpp"

using namespace quoin;
using geometry::SearchOutcome;
using geometry::SearchResult;
using geometry::Shape;
using geometry::Vector3;

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

Shape hull(tests::Random& random, int count, const Vector3& middle) {
  geometry::Points points(3, count);
  for (int k = 0; k < count; ++k) points.col(k) = middle + 0.5 * random.direction();
  return geometry::make_hull(points).polyhedron;
}

}  // namespace

TEST_CASE("the polytope finds the least overlap") {
  tests::Random random(7);
  int found = 0, most = 0;
  for (int k = 0; k < 1500; ++k) {
    const Shape p = hull(random, random.integer(4, 40), random.point(-1, 1));
    const Vector3 middle = p.origin() + random.uniform(0.0, 0.8) * random.direction();
    const Shape q = hull(random, random.integer(4, 40), middle);
    const double size = std::max(p.diameter(), q.diameter()), rounding = 1.25 * kEpsilon * size;
    const SearchResult start =
        geometry::nearest_feature_search(p, q, q.vertex_mean() - p.vertex_mean(), rounding);
    if (start.outcome != SearchOutcome::Overlapping) continue;
    const SearchResult grown = geometry::expand_polytope(p, q, start, rounding);
    REQUIRE(grown.outcome == SearchOutcome::Overlapping);
    const geometry::LeastOverlap exact = geometry::exact_overlap(p, q, {});
    REQUIRE(std::abs(grown.bound - exact.gap) < 20 * kEpsilon * size);
    REQUIRE((grown.normal - exact.normal).norm() < 1e-12);
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3 w = q.vertex(grown.q[i]) - p.vertex(grown.p[i]);
      REQUIRE(std::abs(w.dot(grown.normal) - exact.gap) < 20 * kEpsilon * size);
    }
    ++found;
    most = std::max(most, grown.iterations);
  }
  CHECK(found > 1000);
  CHECK(most > 20);  // many blocks of facets
}

TEST_CASE("where the polytope starts does not matter") {
  tests::Random random(8);
  int found = 0;
  for (int k = 0; k < 300;
       ++k) {  // few vertices: not every side of a tetrahedron has one beyond it
    const Shape p = hull(random, random.integer(4, 12), random.point(-1, 1));
    const Shape q = hull(random, random.integer(4, 12), p.origin() + random.point(-0.3, 0.3));
    const double rounding = 1.25 * kEpsilon * std::max(p.diameter(), q.diameter());
    std::vector<SearchResult> grown;
    for (int i = 0; i < 8; ++i) {
      const SearchResult start =
          geometry::nearest_feature_search(p, q, random.direction(), rounding);
      if (start.outcome != SearchOutcome::Overlapping) break;
      grown.push_back(geometry::expand_polytope(p, q, start, rounding));
      REQUIRE(grown.back().outcome == SearchOutcome::Overlapping);
      REQUIRE(std::abs(grown.back().bound - grown[0].bound) < 4 * rounding);
      REQUIRE((grown.back().normal - grown[0].normal).norm() < 1e-12);
      ++found;
    }
  }
  CHECK(found > 1000);
}

TEST_CASE("several directions as good are left open") {
  const Shape box = geometry::make_box({0, 0, 0}, {1, 1, 1});
  const double rounding = 1.25 * kEpsilon * box.diameter();
  const SearchResult start = geometry::nearest_feature_search(box, box, Vector3::UnitX(), rounding);
  REQUIRE(start.outcome == SearchOutcome::Overlapping);
  CHECK(geometry::expand_polytope(box, box, start, rounding).outcome == SearchOutcome::Unclear);
}
