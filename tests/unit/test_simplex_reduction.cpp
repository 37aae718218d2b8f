/// The step of the search: the nearest point of the simplex. test_kernels has the wide ones.

#include "geometry/src/search/simplex_reduction.hpp"

#include <vector>

#include "support/catch.hpp"
#include "support/random.hpp"

using namespace quoin::geometry;
using quoin::tests::Random;

namespace {

struct State {
  SimplexReduction rows;
  Direction towards{};
  Carried carried = Carried::Found;
};

Vector3 corner(const SimplexReduction& rows, int lane) {
  return {rows.offset.x[lane], rows.offset.y[lane], rows.offset.z[lane]};
}
Vector3 along(const Direction& d) { return {d.x, d.y, d.z}; }

NewCorner new_corner(const std::vector<Vector3>& points, int k) {
  const Vector3& w = points[static_cast<std::size_t>(k)];
  const FourVectors all{four(w.x()), four(w.y()), four(w.z())};
  return {all, all, corner_name(k, k)};
}

bool same(const State& a, const State& b) {
  bool equal = a.carried == b.carried && a.rows.edges == b.rows.edges &&
               a.rows.triangles == b.rows.triangles && along(a.towards) == along(b.towards) &&
               a.towards.scale == b.towards.scale;
  for (int lane = 0; lane < 4; ++lane) {
    equal = equal && corner(a.rows, lane) == corner(b.rows, lane) &&
            std::bit_cast<long long>(a.rows.names[lane]) ==
                std::bit_cast<long long>(b.rows.names[lane]);
  }
  return equal;
}

State stepped(const NewCorner& a, State state) {
  state.carried = take_corner(a, state.rows, state.towards);
  return state;
}
State second_step(const NewCorner& a, State state) {
  take_second_corner(a, state.rows, state.towards);
  return state;
}

/// No corner taken up or let go lies nearer along the direction than those that carry the point.
void check_nearest(const State& before, const NewCorner& a, const State& after) {
  const Vector3 d = along(after.towards).normalized();
  const double reach = d.dot(corner(after.rows, 3));
  CHECK(reach > 0.0);
  for (int lane = 0; lane < 4; ++lane) {
    CHECK(std::abs(d.dot(corner(after.rows, lane)) - reach) < 1e-12);
    CHECK(d.dot(corner(before.rows, lane)) > reach - 1e-12);
  }
  CHECK(corner(after.rows, 3) == Vector3(a.w.x[0], a.w.y[0], a.w.z[0]));
}

int support(const std::vector<Vector3>& points, const Vector3& d) {
  int best = 0;
  for (std::size_t k = 1; k < points.size(); ++k)
    if (d.dot(points[k]) < d.dot(points[static_cast<std::size_t>(best)]))
      best = static_cast<int>(k);
  return best;
}

/// All steps of a search among points around a middle; how many there were.
int walk(Random& random, const Vector3& middle) {
  std::vector<Vector3> points(24);
  for (Vector3& point : points) point = middle + random.direction();
  const NewCorner first = new_corner(points, 0);
  State state{{first.offset, first.name}, {first.w.x[0], first.w.y[0], first.w.z[0]}, {}};
  for (int step = 0; step < 32; ++step) {
    const int k = support(points, along(state.towards));
    const NewCorner a = new_corner(points, k);
    if (!(along(state.towards)
              .normalized()
              .dot(corner(state.rows, 3) - points[static_cast<std::size_t>(k)]) > 1e-12))
      return step;
    const State next = stepped(a, state);
    if (state.rows.edges == 1) CHECK(same(second_step(a, state), next));
    if (next.carried != Carried::Found) return step;
    check_nearest(state, a, next);
    state = next;
  }
  return 32;
}

}  // namespace

TEST_CASE("a step of the search finds the nearest point of the simplex") {
  Random random(13);
  int longest = 0;
  for (int k = 0; k < 500; ++k)
    longest = std::max(longest, walk(random, random.uniform(1.01, 2.0) * random.direction()));
  CHECK(longest >= 4);
  CHECK(longest < 32);
}

TEST_CASE("a step of the search tells when the origin is inside") {
  std::vector<Vector3> points{{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
  State state{{new_corner(points, 0).offset, new_corner(points, 0).name}, {1, 1, 1}, {}};
  for (int k = 1; k < 4; ++k) state = stepped(new_corner(points, k), state);
  CHECK(state.carried == Carried::Inside);
}
