/// Support scans: the answer of the plain loop, whatever instructions the machine has.

#include "geometry/src/shape/support.hpp"

#include <quoin/geometry/build.hpp>

#include "support/catch.hpp"
#include "support/random.hpp"

using namespace quoin;
using geometry::Vector3;

namespace {

geometry::Support plain(const geometry::Shape& solid, const Vector3& d) {
  geometry::Support best{0, -HUGE_VAL};
  for (int v = 0; v < solid.vertex_count(); ++v) {
    const Vector3 x = geometry::row_offset(solid, v);
    const double value = x.x() * d.x() + x.y() * d.y() + x.z() * d.z();
    if (value > best.value) best = {v, value};
  }
  return best;
}

geometry::Shape solid_of(tests::Random& random, int count) {
  geometry::Points points(3, count);
  for (int k = 0; k < count; ++k) points.col(k) = random.direction();
  return geometry::make_hull(points).polyhedron;
}

}  // namespace

TEST_CASE("support is the same to the bit as the plain loop, for any number of vertices") {
  tests::Random random(11);
  for (int count = 4; count <= 80; ++count) {
    const geometry::Shape p = solid_of(random, count), q = solid_of(random, 84 - count);
    for (int k = 0; k < 20; ++k) {
      const Vector3 d = random.uniform(0.1, 10.0) * random.direction();
      const geometry::Support expected = plain(p, d), found = geometry::support(p, d);
      REQUIRE(found.vertex == expected.vertex);
      REQUIRE(found.value == expected.value);
      const geometry::PairSupport pair = geometry::support_pair(p, q, d);
      REQUIRE(pair.p.vertex == expected.vertex);
      REQUIRE(pair.p.value == expected.value);
      REQUIRE(pair.q.vertex == plain(q, -d).vertex);
      REQUIRE(pair.q.value == plain(q, -d).value);
      geometry::VertexSet beyond;
      const double limit = expected.value - 0.5;
      geometry::find_vertices_beyond(p, d, limit, beyond);
      std::size_t next = 0;
      for (int v = 0; v < p.vertex_count(); ++v) {
        const Vector3 x = geometry::row_offset(p, v);
        if (x.x() * d.x() + x.y() * d.y() + x.z() * d.z() < limit) continue;
        REQUIRE(next < beyond.size());
        REQUIRE(beyond[next++] == v);
      }
      REQUIRE(next == beyond.size());
      REQUIRE(geometry::only_these_beyond(p, d, limit, {beyond.begin(), beyond.size()}));
      REQUIRE_FALSE(geometry::only_these_beyond(p, d, limit, {beyond.begin(), beyond.size() - 1}));
    }
  }
}

TEST_CASE("of equal vertices the lowest index is the support") {
  const geometry::Shape box = geometry::make_box({-1, -1, -1}, {1, 1, 1});
  for (const Vector3& d :
       {Vector3(1, 0, 0), Vector3(0, -1, 0), Vector3(0, 0, 0), Vector3(1, 1, 0)}) {
    const geometry::Support found = geometry::support(box, d), expected = plain(box, d);
    CHECK(found.vertex == expected.vertex);
    CHECK(found.value == expected.value);
  }
}

TEST_CASE("carriers of a support plane are checked as by the plain loop") {
  tests::Random random(12);
  for (int count = 4; count <= 80; ++count) {
    const geometry::Shape solid = solid_of(random, count);
    for (int k = 0; k < 20; ++k) {
      const Vector3 d = random.direction();
      const geometry::Support expected = plain(solid, d);
      const double flat = random.uniform(0.0, 0.1), clear = random.uniform(0.1, 0.5);
      geometry::VertexSet near, beyond;
      geometry::find_vertices_beyond(solid, d, expected.value - flat, near);
      geometry::find_vertices_beyond(solid, d, expected.value - clear, beyond);
      geometry::Support top;
      CHECK(geometry::carried_alone(solid, d, {near, flat, clear}, top) ==
            (near.size() == beyond.size()));
      CHECK(top.vertex == expected.vertex);
      CHECK(top.value == expected.value);
      if (near.size() == 1) continue;
      near.resize(near.size() - 1);
      CHECK(!geometry::carried_alone(solid, d, {near, flat, clear}, top));
    }
  }
}
