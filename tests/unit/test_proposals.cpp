/// What the searches propose, against each other, the proved answer and the arbiter. A wrong
/// proposal costs time alone: the certificate decides. Here is that they are right in nearly all
/// pairs.

#include <algorithm>
#include <array>
#include <cmath>
#include <quoin/geometry/build.hpp>

#include "geometry/src/certify/certificate.hpp"
#include "geometry/src/search/corner_features.hpp"
#include "geometry/src/search/exact_search.hpp"
#include "geometry/src/search/nearest_feature_search.hpp"
#include "support/bits.hpp"
#include "support/catch.hpp"
#include "support/exact_gap.hpp"
#include "support/random.hpp"

using namespace quoin;
using namespace geometry;
using tests::Random;

namespace {

Shape brick(Random& random) {
  const Vector3 half(random.uniform(0.2, 0.6), random.uniform(0.2, 0.6), random.uniform(0.2, 0.6));
  return make_box(-half, half);
}
Shape prism(Random& random) {
  const int sides = random.integer(3, 8);
  Points polygon(3, sides);
  for (int k = 0; k < sides; ++k) {
    const double angle = 6.283185307179586 * (k + random.uniform(0.1, 0.9)) / sides;
    polygon.col(k) = 0.5 * Vector3(std::cos(angle), std::sin(angle), 0.0);
  }
  return make_prism(polygon, {0, 0, random.uniform(0.3, 1.0)});
}
Shape hull(Random& random) {
  Points points(3, random.integer(4, 40));
  for (int k = 0; k < points.cols(); ++k) points.col(k) = 0.5 * random.direction();
  return make_hull(points).polyhedron;
}
Shape placed(Random& random, const Shape& solid, const Vector3& middle) {
  return {solid.shared_topology(), (random.rotation() * solid.vertices()).colwise() + middle};
}

/// How many pairs there were of each kind, and in how many the proposal was that of the others.
struct Counts {
  int overlapping = 0, by_polytope = 0, by_box = 0, apart = 0, by_corners = 0;
};

/// EPA against the exact search; of bricks their 15 directions against EPA.
void check_overlap(const Shape& p, const Shape& q, const SearchResult& start, double rounding,
                   Counts& counts) {
  const double size = std::max(p.diameter(), q.diameter());
  const SearchResult grown = expand_polytope(p, q, start, rounding);
  ++counts.overlapping;
  if (grown.outcome != SearchOutcome::Overlapping) return;
  ++counts.by_polytope;
  const LeastOverlap exact = exact_overlap(p, q, {});
  REQUIRE(std::abs(grown.bound - exact.gap) < 20 * kEpsilon * size);
  const bool bricks = !p.topology().brick().empty() && !q.topology().brick().empty();
  const SearchResult found = bricks ? box_sat(p, q, 4 * rounding) : SearchResult{};
  counts.by_box += found.outcome == SearchOutcome::Overlapping;
  for (const SearchResult& result : {grown, found}) {
    if (result.outcome != SearchOutcome::Overlapping) continue;
    REQUIRE((result.normal - exact.normal).norm() < 1e-12);
    for (std::size_t i = 0; i < 3; ++i) {  // its corners lie on the plane
      const Vector3 w = q.vertex(result.q[i]) - p.vertex(result.p[i]);
      REQUIRE(std::abs(w.dot(exact.normal) - exact.gap) < 250 * kEpsilon * size);
    }
  }
}

/// The features that a search's corners span and those of two corners, where both are proved.
void check_apart(const Shape& a, const Shape& b, const SearchResult& found, Counts& counts) {
  const Lengths length = lengths(a, b, 0.0);
  Carrier by_a, by_b;
  NearestFeatures by_search, by_corners;
  if (!corner_carrier(a, found.p, by_a) || !corner_carrier(b, found.q, by_b)) return;
  if (certify(a, b, by_a, by_b, length, nullptr, by_search) != Trial::Proved) return;
  ++counts.apart;
  REQUIRE(tests::bits_of(by_search) == tests::bits_of(nearest_features(a, b)));
  if (!has_plain_corners(a, b) || certify_corners(a, b, length, by_corners) != Trial::Proved)
    return;
  ++counts.by_corners;
  REQUIRE(tests::bits_of(by_search) == tests::bits_of(by_corners));
}

using Make = Shape (*)(Random&);

Counts compare(Random& random, Make make_a, Make make_b, int count) {
  Counts counts;
  for (int k = 0; k < count; ++k) {
    const Shape a = placed(random, make_a(random), random.point(-1, 1));
    const Shape b =
        placed(random, make_b(random), a.origin() + random.uniform(0.1, 2.0) * random.direction());
    const double rounding = 1.25 * kEpsilon * std::max(a.diameter(), b.diameter());
    const SearchResult found =
        nearest_feature_search(a, b, b.vertex_mean() - a.vertex_mean(), rounding);
    if (found.outcome == SearchOutcome::Overlapping) check_overlap(a, b, found, rounding, counts);
    if (found.outcome == SearchOutcome::Separated) check_apart(a, b, found, counts);
  }
  return counts;
}

}  // namespace

TEST_CASE("proposals: least overlap and nearest features are those that are proved") {
  Random random(8);
  const Counts bricks = compare(random, brick, brick, 8000);
  CHECK(bricks.overlapping > 2000);
  CHECK(bricks.by_polytope == bricks.overlapping);
  CHECK(bricks.by_box > bricks.overlapping * 99 / 100);
  CHECK(bricks.apart > 2000);
  CHECK(bricks.by_corners > bricks.apart * 9 / 10);
  for (const auto& [a, b] : {std::pair<Make, Make>{prism, prism}, {brick, prism}, {hull, hull}}) {
    const Counts counts = compare(random, a, b, 1500);
    CHECK(counts.overlapping > 300);
    CHECK(counts.by_polytope > counts.overlapping * 99 / 100);
    CHECK(counts.apart > 300);
    if (a != Make(hull)) CHECK(counts.by_corners > counts.apart / 2);
  }
}

TEST_CASE("proposals: what is ambiguous, or none of theirs, is left to others") {
  const Shape box = make_box({0, 0, 0}, {1, 1, 1});
  const double rounding = 5 * kEpsilon * box.diameter();
  const SearchResult start = nearest_feature_search(box, box, Vector3::UnitX(), 0.25 * rounding);
  REQUIRE(start.outcome == SearchOutcome::Overlapping);
  CHECK(expand_polytope(box, box, start, 0.25 * rounding).outcome == SearchOutcome::Unclear);
  Points frustum = box.vertices();
  for (int v = 0; v < 8; ++v)
    if (frustum(2, v) > 0.5) frustum.col(v).head<2>() *= 0.5;
  const Shape tapered(box.shared_topology(), frustum);
  Random random(6);
  for (const Shape& other : {box, make_box({0.9, 0.1, 0.1}, {1.9, 1.1, 1.1}),  // flush
                             make_box({0.25, 0.25, 0.25}, {0.75, 0.75, 0.75}),
                             make_box({1, 0, 0}, {2, 1, 1})})  // touching
    CHECK(box_sat(box, other, rounding).outcome == SearchOutcome::Unclear);
  CHECK(box_sat(tapered, placed(random, brick(random), {0.4, 0.4, 1.1}), rounding).outcome ==
        SearchOutcome::Unclear);
  CHECK(has_plain_corners(box, box));
  CHECK_FALSE(has_plain_corners(box, hull(random)));  // more than three faces meet
}
