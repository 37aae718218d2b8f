/// A block that slides over tops that lie flush, along walls, over gaps and down steps is not
/// stopped at the joints, whatever the time step; at a step up it is.

#include <cmath>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>

#include "support/catch.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

constexpr Material kRock{.density = 2500, .young = 5e9, .poisson = 0.25};
constexpr double kSpeed = 3.0, kTime = 1.2;

/// Fixed boxes of `length` beside each other from x = -3 on, `gap` apart, tops at z = 0.
Scene floor_of(int count, double length, double gap) {
  Scene scene;
  for (int i = 0; i < count; ++i) {
    const double from = -3.0 + i * (length + gap);
    scene.add_fixed(geometry::make_box({from, -2, -1}, {from + length, 2, 0}));
  }
  return scene;
}

int add_cube(Scene& scene, bool rigid, const Vector3& corner) {
  const geometry::Shape cube = geometry::make_box(corner, corner + Vector3(1, 1, 1));
  const int block = rigid ? scene.add_rigid(cube, kRock) : scene.add_block(cube, kRock);
  scene.blocks[static_cast<std::size_t>(block)].velocity = Vector3(kSpeed, 0, 0);
  return block;
}

struct Outcome {
  Vector3 moved = Vector3::Zero(), velocity = Vector3::Zero();
  double highest = 0.0, overlap = 0.0;
};

Outcome slide(const Scene& scene, int block, double time_step) {
  Simulation simulation(scene, {.time_step = time_step});
  const auto b = static_cast<std::size_t>(block);
  const Vector3 start = simulation.state().blocks[b].centroid;
  Outcome outcome;
  for (const long steps = std::lround(kTime / time_step); simulation.state().step < steps;) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    outcome.overlap = std::max(outcome.overlap, report.largest_overlap);
    outcome.highest =
        std::max(outcome.highest, simulation.state().blocks[b].centroid.z() - start.z());
  }
  outcome.moved = simulation.state().blocks[b].centroid - start;
  outcome.velocity = simulation.state().blocks[b].velocity;
  return outcome;
}

template <class Case>
void at_all_steps(const Case& run) {
  for (const bool rigid : {true, false}) {
    for (const double time_step : {0.01, 0.003, 0.001}) {
      INFO((rigid ? "rigid" : "deformable") << ", dt " << time_step);
      run(rigid, time_step);
    }
  }
}

}  // namespace

TEST_CASE("Over the flush tops of two blocks, and of ten") {
  for (const int count : {2, 10}) {
    at_all_steps([&](bool rigid, double time_step) {
      INFO(count << " blocks");
      Scene scene = floor_of(count, count == 2 ? 4.6 : 0.9, 0.0);
      const int block = add_cube(scene, rigid, {0.05, -0.5, 0});
      const Outcome end = slide(scene, block, time_step);
      CHECK_THAT(end.moved.x(), WithinRel(kSpeed * kTime, 1e-6));
      CHECK(end.highest < 1e-6);
      CHECK(end.overlap < 1e-6);
    });
  }
}

TEST_CASE("Over a gap, and down a step of a millimetre") {
  at_all_steps([](bool rigid, double time_step) {
    Scene gap = floor_of(2, 4.6, 0.05);
    const int over = add_cube(gap, rigid, {0.05, -0.5, 0});
    const Outcome crossed = slide(gap, over, time_step);
    CHECK_THAT(crossed.moved.x(), WithinRel(kSpeed * kTime, 1e-4));
    CHECK(crossed.highest < 1e-5);
    Scene step = floor_of(1, 4.6, 0.0);
    step.add_fixed(geometry::make_box({1.6, -2, -1}, {7, 2, -0.001}));
    const int down = add_cube(step, rigid, {0.05, -0.5, 0});
    const Outcome stepped = slide(step, down, time_step);
    CHECK_THAT(stepped.moved.x(), WithinRel(kSpeed * kTime, 1e-2));
    CHECK(stepped.highest < 1e-3);
  });
}

TEST_CASE("A step up of a millimetre stops it") {
  at_all_steps([](bool rigid, double time_step) {
    Scene scene = floor_of(1, 4.6, 0.0);
    scene.add_fixed(geometry::make_box({1.6, -2, -1}, {7, 2, 0.001}));
    const int block = add_cube(scene, rigid, {0.05, -0.5, 0});
    const Outcome end = slide(scene, block, time_step);
    CHECK(end.moved.x() < 0.6 * kSpeed * kTime);
    CHECK(end.overlap < 1e-6);
  });
}

TEST_CASE("Along an inner corner of four flush pieces") {
  at_all_steps([](bool rigid, double time_step) {
    Scene scene = floor_of(2, 4.6, 0.0);
    scene.add_fixed(geometry::make_box({-3, 0.5, 0}, {2, 1, 2}));
    scene.add_fixed(geometry::make_box({2, 0.5, 0}, {7, 1, 2}));
    const int block = add_cube(scene, rigid, {0.05, -0.5, 0});
    const Outcome end = slide(scene, block, time_step);
    CHECK_THAT(end.moved.x(), WithinRel(kSpeed * kTime, 1e-6));
    // Swinging after sudden gravity (g h / c: 7e-3 m/s at the most) pushes a deformable block off
    // the wall.
    CHECK(std::abs(end.moved.y()) < (rigid ? 1e-6 : 1e-3));
    CHECK(end.highest < 1e-6);
  });
}

TEST_CASE("Friction over joints is that of one block") {
  at_all_steps([](bool rigid, double time_step) {
    const auto over = [&](int count, double length) {
      Scene scene = floor_of(count, length, 0.0);
      scene.joint.friction_angle = std::atan(0.2);
      const int block = add_cube(scene, rigid, {0.05, -0.5, 0});
      return slide(scene, block, time_step);
    };
    const Outcome one = over(1, 9.2);
    for (const Outcome& many : {over(2, 4.6), over(10, 0.92)}) {
      CHECK_THAT(many.moved.x(), WithinRel(one.moved.x(), rigid ? 1e-6 : 1e-4));
      CHECK_THAT(many.velocity.x(), WithinAbs(one.velocity.x(), rigid ? 1e-6 : 2e-4));
    }
  });
}
