/// The kernels of all instruction sets that this machine can run give the bits of the plain ones.

#include "geometry/src/kernels/kernels.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <functional>
#include <quoin/geometry/build.hpp>
#include <vector>

#include "support/bits.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"

using namespace quoin;
using namespace geometry;

namespace {

/// What a kernel has answered.
struct Bits : quoin::tests::Bits {
  using quoin::tests::Bits::add;
  void add(const geometry::Support& top) {
    add(top.vertex);
    add(top.value);
  }
  void add(const geometry::SearchResult& found) {
    add(std::array{static_cast<int>(found.outcome), found.iterations});
    add(found.normal);
    add(found.bound);
    add(found.corners);
    add(found.p);
    add(found.q);
  }
};

/// How many answers there were; all kernels have to agree.
int check_all(const std::function<int(const Kernels&, Bits&)>& ask) {
  Bits expected;
  const int count = ask(geometry::kPlainKernels, expected);
  for (const Kernels* kernels : geometry::runnable_kernels()) {
    INFO(kernels->name);
    Bits found;
    CHECK(ask(*kernels, found) == count);
    CHECK(found.all.size() == expected.all.size());
    const auto [here, there] =
        std::mismatch(found.all.begin(), found.all.end(), expected.all.begin(), expected.all.end());
    INFO("the first difference is number " << here - found.all.begin());
    CHECK(here == found.all.end());
  }
  return count;
}

Shape hull(tests::Random& random, int count) {
  geometry::Points points(3, count);
  for (int k = 0; k < count; ++k) points.col(k) = random.direction();
  return geometry::make_hull(points).polyhedron;
}

Shape brick(tests::Random& random) {
  const Vector3 half(random.uniform(0.2, 0.9), random.uniform(0.2, 0.9), random.uniform(0.2, 0.9));
  return geometry::make_box(-half, half);
}

/// Bodies about so far from each other, turned or not.
struct Bodies {
  geometry::Body a, b;
  geometry::PlacedPair pair;
  geometry::Lengths length;
  Bodies(tests::Random& random, const Shape& p, const Shape& q, double distance)
      : a(p, placement(random, random.point(-1, 1))),
        b(q, placement(random, a.placement().translation + distance * random.direction())),
        pair(a, b),
        length(geometry::lengths(pair.a, pair.b, 0.0)) {}

 private:
  static geometry::Placement placement(tests::Random& random, const Vector3& translation) {
    if (random.chance(0.3)) return {.translation = translation};
    return {.linear = random.rotation(), .translation = translation};
  }
};

constexpr int kCounts[] = {4, 6, 8, 9, 14, 16, 17, 24, 25, 32, 33, 40, 57, 64, 65, 72, 90, 130};

}  // namespace

TEST_CASE("kernels: scans") {
  tests::Random random(15);
  for (const int count : kCounts) {
    const Shape shape = count == 8 ? brick(random) : hull(random, count);
    const Bodies bodies(random, shape, shape, 1.0);
    for (int k = 0; k < 40; ++k) {
      // along an axis many vertices of a brick are equal
      const Vector3 d = k < 3 ? Vector3(Vector3::Unit(k)) : random.direction();
      const double depth = random.uniform(0.0, 0.6);
      check_all([&](const Kernels& kernels, Bits& bits) {
        const Solid& solid = bodies.pair.a;
        const geometry::Support top = kernels.support(solid, d);
        bits.add(top);
        geometry::VertexSet beyond;
        kernels.find_vertices_beyond(solid, d, top.value - depth, beyond);
        for (const int v : beyond) bits.add(v);
        geometry::VertexSet deep, shallow;
        bits.add(kernels.find_top(solid, d, {depth, 0.3 * depth}, deep, shallow));
        CHECK(std::ranges::equal(deep, beyond));
        for (const int v : shallow) bits.add(v);
        geometry::Support again;
        for (const double clear : {depth, 1.2 * depth}) {
          bits.add(int{kernels.carried_alone(solid, d, {beyond, depth, clear}, again)});
          bits.add(again);
        }
        return beyond.count();
      });
    }
  }
}

TEST_CASE("kernels: searches, and what certifies them") {
  tests::Random random(16);
  int proved = 0, overlapping = 0;
  for (int k = 0; k < 600; ++k) {
    const int count = kCounts[random.integer(0, std::ssize(kCounts) - 1)];
    const Shape p = k % 3 == 0 ? brick(random) : hull(random, count);
    const Shape q = k % 3 == 0 ? brick(random) : hull(random, random.integer(4, 40));
    const Bodies bodies(random, p, q, random.uniform(0.3, 3.0));
    const Solid &a = bodies.pair.a, &b = bodies.pair.b;
    const double rounding = bodies.length.rounding;
    proved += check_all([&](const Kernels& kernels, Bits& bits) {
      const geometry::SearchResult found =
          kernels.nearest_feature_search(a, b, b.vertex_mean() - a.vertex_mean(), rounding);
      bits.add(found);
      if (found.outcome != geometry::SearchOutcome::Separated) return 0;
      geometry::Carrier by_a, by_b;
      if (!geometry::corner_carrier(a, found.p, by_a)) return 0;
      if (!geometry::corner_carrier(b, found.q, by_b)) return 0;
      geometry::NearestFeatures cold, warm;
      const geometry::Trial trial = kernels.certify(a, b, by_a, by_b, bodies.length, nullptr, cold);
      bits.add(static_cast<int>(trial));
      if (trial != geometry::Trial::Proved) return 0;
      bits.add(cold);
      bits.add(cold.hint);
      CHECK(kernels.certify_hint(a, b, cold.hint, bodies.length, warm) == trial);
      bits.add(warm);
      bits.add(warm.hint);
      return 1;
    });
    overlapping += check_all([&](const Kernels& kernels, Bits& bits) {
      const geometry::SearchResult start =
          kernels.nearest_feature_search(a, b, b.vertex_mean() - a.vertex_mean(), rounding);
      if (start.outcome != geometry::SearchOutcome::Overlapping) return 0;
      bits.add(kernels.expand_polytope(a, b, start, rounding));
      return 1;
    });
    if (k % 3 != 0) continue;
    check_all([&](const Kernels& kernels, Bits& bits) {
      geometry::NearestFeatures by_corners;
      const geometry::Trial trial = kernels.certify_corners(a, b, bodies.length, by_corners);
      bits.add(static_cast<int>(trial));
      if (trial == geometry::Trial::Proved) bits.add(by_corners);
      bits.add(kernels.box_sat(a, b, rounding));
      return 0;
    });
  }
  CHECK(proved > 100);
  CHECK(overlapping > 100);
}
