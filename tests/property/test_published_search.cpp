/// How often the published search alone would be wrong, measured (bench/README.md), and that the
/// certificate tells: the exact gap lies between its two bounds. QUOIN_CASES: pairs of each family.

#include <quoin/geometry/published_search.hpp>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/nearest_features.hpp>

#include "referee/pairs/families.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"

namespace {

using namespace quoin::geometry;
using quoin::referee::Random;
using quoin::tests::environment_number;
using quoin::tests::WithinAbs;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

struct Rates {
  long pairs = 0, missed = 0, missed_much = 0, over_100 = 0, never_still = 0, outside = 0;
};

void measure(const Body& a, const Body& b, Rates& rates) {
  const NearestFeatures nearest = nearest_features(a, b);
  if (nearest.status != PairStatus::Separated) return;
  const PublishedAnswer published = published_search(a, b);
  const double size = std::max(a.shape().diameter(), b.shape().diameter());
  const double coordinate =
      std::max(a.shape().largest_coordinate(), b.shape().largest_coordinate());
  const double allowed = 1e-12 * nearest.gap + kEpsilon * (16 * size + 4 * coordinate);
  ++rates.pairs;
  rates.missed += published.gap > nearest.gap * (1 + 1e-9) + allowed ? 1 : 0;
  rates.missed_much += published.gap > 1.1 * nearest.gap + allowed ? 1 : 0;
  rates.over_100 += published.cycles > 100 ? 1 : 0;
  rates.never_still += published.stands_still ? 0 : 1;
  const bool between = published.least_gap() <= nearest.gap + allowed &&
                       std::abs(published.gap) >= nearest.gap - allowed;
  rates.outside += between ? 0 : 1;
}

}  // namespace

TEST_CASE("published search: how often it misses, how many cycles it needs") {
  const std::uint64_t cases = environment_number("QUOIN_CASES", 100);
  const std::vector<std::string>& names = quoin::referee::family_names();
  std::printf("%-16s %6s %8s %12s %12s %12s\n", "", "pairs", "missed", "by over 10%", ">100 cycles",
              "never still");
  long missed = 0;
  for (const char* name : {"boxes", "hulls", "large_hulls", "slivers", "masonry", "wedges"}) {
    const auto place = std::find(names.begin(), names.end(), name);
    REQUIRE(place != names.end());
    const int family = static_cast<int>(place - names.begin());
    Rates rates;
    for (std::uint64_t i = 0; i < cases; ++i) {
      Random random(77003 + i);
      const quoin::referee::SolidPair pair = quoin::referee::make_pair(family, random);
      const Shape a = polyhedron_of(pair.a), b = polyhedron_of(pair.b);
      measure(Body(a), Body(b), rates);
    }
    const double share = 100.0 / static_cast<double>(std::max(rates.pairs, 1L));
    const auto percent = [&](long count) { return share * static_cast<double>(count); };
    std::printf("%-16s %6ld %7.2f%% %11.2f%% %11.2f%% %11.2f%%\n", name, rates.pairs,
                percent(rates.missed), percent(rates.missed_much), percent(rates.over_100),
                percent(rates.never_still));
    CHECK(rates.outside == 0);
    missed += rates.missed;
  }
  CHECK(missed > 0);  // or this measures nothing
}

TEST_CASE("published search: a roof under a point, far from their nearest vertices") {
  Points roof(3, 5), point(3, 4);
  roof << -10, 10, 10, -10, 0, -10, -10, 10, 10, 0, 0, 0, 0, 0, -0.5;
  point << 0, 1, -0.5, -0.5, 0, 0, 0.8, -0.8, 0.005, 1, 1, 1;
  const Hull a = make_hull(roof), b = make_hull(point);
  const PublishedAnswer found = published_search(a.polyhedron, b.polyhedron);
  CHECK(nearest_features(a.polyhedron, b.polyhedron).gap == 0.005);
  CHECK(found.stands_still);
  CHECK(found.gap > 0.5);
  CHECK(found.least_gap() <= 0.005);  // the certificate says that it may be wrong
}

TEST_CASE("published search: a cube over a cube, the right answer and its proof") {
  const Shape cube = make_box({0, 0, 0}, {1, 1, 1});
  const Body a(cube), b(cube, {Matrix3::Identity(), Vector3(1e6, 0.25, 1.5)});
  const Body above(cube, {Matrix3::Identity(), Vector3(0.25, 0.25, 1.5)});
  for (const Body& other : {b, above}) {
    const PublishedAnswer found = published_search(a, other);
    const NearestFeatures nearest = nearest_features(a, other);
    CHECK_THAT(found.gap, WithinAbs(nearest.gap, 1e-12 * nearest.gap));
    CHECK_THAT(found.least_gap(), WithinAbs(nearest.gap, 1e-12 * nearest.gap));
    CHECK_THAT((found.normal - nearest.normal).norm(), WithinAbs(0.0, 1e-12));
    const double along = (found.point_b - found.point_a).dot(found.normal);
    CHECK_THAT(along, WithinAbs(found.gap, 1e-9));
    const PublishedAnswer swapped = published_search(other, a);
    CHECK(swapped.gap == found.gap);
    CHECK(swapped.normal == -found.normal);
  }
}

TEST_CASE("published search: two edges at one degree take many cycles, or end at the limit") {
  const Shape cube = make_box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
  const Matrix3 on_edge = quoin::referee::rotation_about(Vector3::UnitX(), 0.785398);
  const Matrix3 turn = quoin::referee::rotation_about(Vector3::UnitZ(), 0.0174533);
  const Body a(cube, {on_edge, Vector3::Zero()});
  const Body b(cube, {turn * on_edge, Vector3(0.2, 0.001, 1.42)});
  const PublishedAnswer found = published_search(a, b, {.max_cycles = 100});
  CHECK(found.cycles == 100);
  CHECK_FALSE(found.stands_still);
  CHECK(found.gap >= nearest_features(a, b).gap);
}
