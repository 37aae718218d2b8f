#include <cmath>
#include <limits>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/time_of_impact.hpp>

#include "support/catch.hpp"
#include "support/random.hpp"

namespace {

using namespace quoin::geometry;
using namespace quoin::tests;

/// The same scene elsewhere.
struct Frame {
  Matrix3 turn = Matrix3::Identity();
  Vector3 shift = Vector3::Zero();
  Placement operator()(const Placement& x) const {
    return {turn * x.linear, turn * x.translation + shift};
  }
  Motion operator()(const Motion& m) const {
    return {turn * m.translation, turn * m.rotation, turn * m.centre + shift};
  }
};

std::vector<Frame> frames() {
  Random random(3);
  return {{}, {random.rotation(), {1, 2, 3}}, {random.rotation(), {1e5, -2e5, 1e5}}};
}

}  // namespace

TEST_CASE("time of impact: a falling box") {
  const Shape ground = make_box({-5, -5, -1}, {5, 5, 0}), box = make_box({0, 0, 0}, {1, 1, 1});
  for (const Frame& frame : frames()) {
    const Body still(ground, frame(Placement{}));
    const Body high(box, frame(Placement{Matrix3::Identity(), {0, 0, 3}}));
    const auto fall = [&](double way) {
      return time_of_impact(still, {}, high, frame(Motion{.translation = {0.5, 0, -way}}),
                            {.length = 1e-6});
    };
    const Impact hit = fall(12.0);
    CHECK(hit.status == ImpactStatus::Impact);
    CHECK(hit.s <= 0.25);
    CHECK_THAT(hit.s, WithinAbs(0.25, 1e-6 / 12 + 1e-10));
    CHECK(hit.nearest.gap > 0.0);
    CHECK(hit.nearest.gap <= 1e-6);
    CHECK(fall(2.9).status == ImpactStatus::Apart);
    CHECK(fall(2.9).s == 1.0);
    CHECK(fall(-1.0).iterations == 2);                // it leaves: the end is looked at
    CHECK(fall(3.0).status == ImpactStatus::Impact);  // touches at the end
  }
}

TEST_CASE("time of impact: a bar that turns about its end onto a wall") {
  // From along x; its tip, 2 m out, meets the plane y = 1 when sin(angle) = 1/2.
  const Shape bar = make_box({0, -0.01, 0}, {2, 0, 0.1});
  const Shape wall = make_box({-9, 1, -1}, {9, 2, 1});
  for (const Frame& frame : frames()) {
    const Body still(wall, frame(Placement{})), turning(bar, frame(Placement{}));
    for (const double angle : {0.5, 1.0, 20.0}) {
      const Impact hit = time_of_impact(turning, frame(Motion{.rotation = {0, 0, angle}}), still,
                                        {}, {.length = 1e-6});
      const double meets = std::numbers::pi / 6 / angle;
      CHECK((hit.status == ImpactStatus::Impact) == (meets < 1.0));
      if (meets > 1.0) continue;
      CHECK(hit.s <= meets);
      CHECK_THAT(hit.s, WithinAbs(meets, 1e-6 / angle + 1e-9));
    }
    // about z nothing comes nearer along z
    const Body below(wall, frame(Placement{Matrix3::Identity(), {0, 0, -3}}));
    CHECK(time_of_impact(turning, frame(Motion{.rotation = {0, 0, 9}}), below, {}, {}).s == 1.0);
  }
}

TEST_CASE("time of impact: at once, never by sliding, and given up") {
  const Shape box = make_box({0, 0, 0}, {1, 1, 1});
  const Body a(box), on(box, {Matrix3::Identity(), {0, 0, 1}});
  const Impact touching = time_of_impact(a, {}, on, {.translation = {0, 0, 5}}, {});
  CHECK(touching.status == ImpactStatus::Impact);
  CHECK(touching.s == 0.0);
  const Body above(box, {Matrix3::Identity(), {-3, 0, 1.1}});
  CHECK(time_of_impact(a, {}, above, {.translation = {9, 0, 0}}, {}).status == ImpactStatus::Apart);
  const Impact given_up = time_of_impact(a, {.rotation = {1, 2, 3}}, above,
                                         {.translation = {9, 0, -0.05}}, {.max_iterations = 2});
  CHECK(given_up.status == ImpactStatus::NotConverged);
  CHECK(given_up.s < 1.0);
  CHECK_THROWS_AS(time_of_impact(a, {}, on, {}, {.length = -1.0}), InputError);
  CHECK_THROWS_AS(time_of_impact(a, {}, on, {.translation = {std::nan(""), 0, 0}}, {}), InputError);
  CHECK_THROWS_AS(time_of_impact({box, {-Matrix3::Identity(), {0, 0, 0}}}, {}, on, {}, {}),
                  InputError);
}

TEST_CASE("time of impact: a motion between two placements") {
  Random random(4);
  for (int i = 0; i < 50; ++i) {
    const Placement start{random.rotation(), {1, 2, 3}}, end{random.rotation(), {3, 1, 0}};
    const Motion motion = motion_between(start, end, {0.3 * i, 1, 0});
    const Placement reached = placement_at(start, motion, 1.0);
    CHECK((reached.linear - end.linear).norm() < 1e-13);
    CHECK((reached.translation - end.translation).norm() < 1e-13 * (i + 10));
    CHECK(motion.rotation.norm() < 3.1416);
  }
}

TEST_CASE("time of impact: never late, beside dense sampling") {
  Random random(11);
  const auto cases = environment_number("QUOIN_CASES", 200);
  int hits = 0, apart = 0;
  for (std::uint64_t i = 0; i < cases; ++i) {
    const auto hull = [&] {
      Points points(3, 5 + static_cast<int>(i % 12));
      for (double& x : points.reshaped()) x = random.uniform(-1, 1);
      return make_hull(points).polyhedron;
    };
    const auto vector = [&](double most) {
      return Vector3(random.uniform(-most, most), random.uniform(-most, most),
                     random.uniform(-most, most));
    };
    const Shape p = hull(), q = hull();
    const Vector3 away = (i % 5 == 0 ? 1e4 : 0.0) * Vector3(1, 2, -1);
    const Body a(p, {random.rotation(), away});
    const Body b(q, {random.rotation(), away + 4.0 * random.rotation().col(0)});
    const Motion of_a{vector(1.5), vector(3), away + vector(0.5)};
    const Motion of_b{away - b.placement().translation + vector(1.5), vector(3),
                      b.placement().translation + vector(0.5)};
    const Impact hit = time_of_impact(a, of_a, b, of_b, {.length = 1e-6});
    REQUIRE(hit.status != ImpactStatus::NotConverged);
    hits += hit.status == ImpactStatus::Impact;
    apart += hit.status == ImpactStatus::Apart;
    if (hit.status == ImpactStatus::Impact && hit.s > 0.0) {
      CHECK(hit.nearest.gap > 0.0);
      CHECK(hit.nearest.gap <= 1e-6);
    }
    constexpr int kSamples = 100;
    FeatureHint hint;
    for (int k = 0; k < kSamples; ++k) {  // up to there they are apart
      const double s = hit.s * k / kSamples;
      const NearestFeatures nearest =
          nearest_features({p, placement_at(a.placement(), of_a, s)},
                           {q, placement_at(b.placement(), of_b, s)}, {}, hint);
      hint = nearest.hint;
      if (!(nearest.gap > 0.0)) FAIL(i << ": overlap at " << s << " before " << hit.s);
    }
  }
  CHECK(hits > 0);
  CHECK(apart > 0);
}
