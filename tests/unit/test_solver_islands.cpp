/// Groups of blocks that contacts join are solved each by itself: what one does is nothing to the
/// others.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>

#include "support/catch.hpp"
#include "support/same_state.hpp"

using namespace quoin::solver;
using quoin::tests::same_bits;
namespace geometry = quoin::geometry;

namespace {

constexpr Material kRock{.density = 2500, .young = 5e9, .poisson = 0.25};
constexpr Material kRigid{.density = 2500};

/// Appends blocks to a scene.
using Part = void (*)(Scene&, const Vector3& at);

geometry::Shape box(const Vector3& low, const Vector3& size) {
  return geometry::make_box(low, low + size);
}

/// The block that was added last is given a motion.
void set_moving(Scene& scene, const Vector3& velocity, const Vector3& spin = Vector3::Zero()) {
  scene.blocks.back().velocity = velocity;
  scene.blocks.back().angular_velocity = spin;
}

Scene empty_scene() {
  Scene scene;
  scene.joint.friction_angle = 0.6;
  return scene;
}

void add_ground(Scene& scene, const Vector3& at) {
  scene.add_fixed(box(at + Vector3(-2, -2, -1), {4, 4, 1}));
}

/// Three cubes on each other.
void add_tower(Scene& scene, const Vector3& at) {
  add_ground(scene, at);
  for (int k = 0; k < 3; ++k)
    scene.add_block(box(at + Vector3(-0.5, -0.5, k), Vector3::Ones()), kRock);
}

/// A cube that falls on another one.
void add_impact(Scene& scene, const Vector3& at) {
  add_ground(scene, at);
  scene.add_block(box(at + Vector3(-0.5, -0.5, 0), Vector3::Ones()), kRock);
  scene.add_block(box(at + Vector3(-0.3, -0.4, 1.02), Vector3::Ones()), kRock);
  set_moving(scene, Vector3(0.3, 0, -1));
}

/// A cube that slides and turns.
void add_slider(Scene& scene, const Vector3& at) {
  add_ground(scene, at);
  scene.add_block(box(at + Vector3(-0.2, -0.2, 0), {0.4, 0.4, 0.4}), kRock);
  set_moving(scene, Vector3(0.5, 0.2, 0), Vector3(0, 0, 1));
}

/// A cube that falls through the air and turns.
void add_faller(Scene& scene, const Vector3& at) {
  add_ground(scene, at);
  scene.add_block(box(at + Vector3(0, 0, 9), Vector3::Ones()), kRock);
  set_moving(scene, Vector3::Zero(), Vector3(0.3, 0.2, 1));
}

/// A cube that flies at another one by most of itself in 20 ms: the step is cut.
void add_bullet(Scene& scene, const Vector3& at) {
  scene.add_rigid(box(at, Vector3::Ones()), kRigid);
  scene.add_rigid(box(at + Vector3(0.2, -1.6, 0.1), Vector3::Ones()), kRigid);
  set_moving(scene, Vector3(0, 40, 0));
}

/// A grain of a millimetre that slides on its own ground, in metres.
void add_grain(Scene& scene, const Vector3& at) {
  add_ground(scene, at);
  scene.add_rigid(box(at, {1e-3, 1e-3, 1e-3}), kRigid);
  set_moving(scene, Vector3(0.05, 0, 0));
}

/// A cube so fast that the search reaches far beyond every other block.
void add_shot(Scene& scene, const Vector3& at) {
  scene.add_rigid(box(at + Vector3(0, 0, 3), Vector3::Ones()), kRigid);
  set_moving(scene, Vector3(-900, 0, 0));
}

/// A cube that is put down on an edge and rocks: its face is tilted by less than a reach.
void add_rocker(Scene& scene, const Vector3& at) {
  add_ground(scene, at);
  scene.add_block(box(at + Vector3(-0.3, -0.3, 0), {0.6, 0.6, 1.2}), kRock);
  set_moving(scene, Vector3(0.2, 0, 0.05), Vector3(0.1, 0.4, 0));
}

/// A heap of small blocks, dropped: hard to solve.
void add_heap(Scene& scene, const Vector3& at) {
  add_ground(scene, at);
  for (int k = 0; k < 6; ++k) {
    const Vector3 low = at + Vector3(0.13 * (k % 3) - 0.4, 0.11 * (k % 2) - 0.3, 0.32 * k + 0.01);
    scene.add_rigid(box(low, {0.5, 0.4, 0.3}), kRigid);
  }
}

const Vector3 kHere(-8, 0, 0), kThere(8, 0, 0);

/// Steps until blocks `first` … of `both` and 0 … of `alone` differ.
int steps_alike(Simulation& both, Simulation& alone, std::size_t first, int steps) {
  for (int step = 0; step < steps; ++step) {
    const StepReport of_both = both.advance(), of_alone = alone.advance();
    if (of_both.status != StepStatus::Converged || of_alone.status != StepStatus::Converged)
      return step;
    for (std::size_t b = 0; b < alone.state().blocks.size(); ++b)
      if (!same_bits(both.state().blocks[first + b], alone.state().blocks[b])) return step;
  }
  return steps;
}

/// How long `watched` moves to the bit as alone while `other` stands beside it.
int steps_alike(Part watched, Part other, const StepOptions& options, int steps) {
  Scene both = empty_scene(), alone = empty_scene();
  other(both, kHere);
  const std::size_t first = both.blocks.size();
  watched(both, kThere);
  watched(alone, kThere);
  Simulation together(both, options), apart(alone, options);
  REQUIRE(together.state().origin == apart.state().origin);
  return steps_alike(together, apart, first, steps);
}

/// `rows` × `rows` towers of `height` cubes, each pushed over its ground at its own speed.
Scene towers(int rows, int height) {
  Scene scene = empty_scene();
  const double span = 2.0 * rows;
  scene.add_fixed(box({-2, -2, -1}, {span + 4, span + 4, 1}));
  for (int i = 0; i < rows * rows; ++i) {
    const Vector3 at(2.0 * (i % rows), 2.0 * (i / rows), 0);
    for (int k = 0; k < height; ++k) {
      scene.add_rigid(box(at + Vector3(0, 0, k), {1, 1, 1}), kRigid);
      set_moving(scene, Vector3(0.01 * (i + 1), 0.02 * k, 0));
    }
  }
  return scene;
}

}  // namespace

TEST_CASE("islands: a part moves to the bit as if the other one were not there") {
  const StepOptions options{.time_step = 2e-3};
  CHECK(steps_alike(add_tower, add_impact, options, 30) == 30);
  CHECK(steps_alike(add_slider, add_impact, options, 60) == 60);
  CHECK(steps_alike(add_impact, add_slider, options, 60) == 60);
  CHECK(steps_alike(add_slider, add_heap, options, 40) == 40);
  CHECK(steps_alike(add_tower, add_grain, options, 30) == 30);
  CHECK(steps_alike(add_rocker, add_grain, options, 200) == 200);
  CHECK(steps_alike(add_tower, add_shot, options, 30) == 30);
  CHECK(steps_alike(add_rocker, add_shot, options, 200) == 200);
  CHECK(steps_alike(add_heap, add_grain, options, 120) == 120);
  CHECK(steps_alike(add_heap, add_shot, options, 120) == 120);
}

TEST_CASE("islands: cuts of one are not those of another") {
  const StepOptions options{.time_step = 2e-2};
  Scene scene = empty_scene();
  add_bullet(scene, kHere);
  const std::size_t faller = scene.blocks.size() + 1;  // after its ground
  add_faller(scene, kThere);
  Scene alone = empty_scene();
  add_faller(alone, kThere);
  Simulation both(scene, options), apart(alone, options);
  REQUIRE(both.state().origin == apart.state().origin);
  int cuts = 0;
  for (int step = 0; step < 5; ++step) {
    const StepReport report = both.advance();
    REQUIRE(report.status == StepStatus::Converged);
    REQUIRE(apart.advance().sub_steps == 1);
    cuts += report.cuts_by_convergence + report.cuts_by_contact;
    CHECK(same_bits(both.state().blocks[faller], apart.state().blocks[1]));
  }
  CHECK(cuts > 0);
}

TEST_CASE("islands: an impact holds the strain of its own island alone") {
  Scene scene = empty_scene();
  add_impact(scene, kHere);
  const std::size_t tower = scene.blocks.size();
  add_tower(scene, kThere);
  Simulation simulation(scene, {.time_step = 1e-2});
  bool hit = false;
  for (int step = 0; step < 5; ++step) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    for (const Contact& contact : simulation.state().contacts) {
      if (contact.impact) hit = hit || contact.point.key.a < static_cast<int>(tower);
      if (contact.point.key.a >= static_cast<int>(tower)) CHECK_FALSE(contact.impact);
    }
    // Strains of the tower go on oscillating in every step.
    CHECK(simulation.state().blocks[tower + 1].strain_rate.norm() > 0.0);
  }
  CHECK(hit);
}

TEST_CASE("islands: blocks that meet within a step are one island's") {
  Scene scene = empty_scene();
  scene.gravity = Vector3(0, 0, 0);
  scene.add_rigid(box({-0.5, -0.5, -0.5}, Vector3::Ones()), kRigid);
  // Pushed harder than its speed tells: found by the overlap at the end alone.
  const int b = scene.add_rigid(box({0.6, -0.45, -0.4}, Vector3::Ones()), kRigid);
  scene.point_loads.push_back({b, {1.1, 0.05, 0.1}, Vector3(-2e7, 0, 0)});
  Simulation simulation(scene, {.time_step = 1e-2});
  const StepReport report = simulation.advance();
  REQUIRE(report.status == StepStatus::Converged);
  CHECK(report.islands == 1);
  CHECK(simulation.state().blocks[0].velocity.x() < -1e-3);
  CHECK(report.largest_overlap < 1e-9);
}

TEST_CASE("islands: any number of threads gives the same bits") {
  const Scene scene = towers(10, 10);
  StepOptions options{.time_step = 5e-3};
  Simulation one(scene, options);
  options.threads = 2;
  Simulation two(scene, options);
  options.threads = 5;
  Simulation five(scene, options);
  for (int step = 0; step < 2; ++step) {
    const auto start = std::chrono::steady_clock::now();
    const StepReport report = one.advance();
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
    REQUIRE(report.status == StepStatus::Converged);
    CHECK(report.islands == 100);
    const PhaseSeconds& phases = report.seconds;
    CHECK(phases.detect + phases.assemble + phases.solve + phases.update <= passed.count());
    REQUIRE(two.advance().block_solves == report.block_solves);
    REQUIRE(five.advance().block_solves == report.block_solves);
    CHECK(same_bits(one.state(), two.state()));
    CHECK(same_bits(one.state(), five.state()));
    CHECK(std::memcmp(&one.state().energy, &five.state().energy, sizeof(EnergyLedger)) == 0);
  }
}

TEST_CASE("islands: a step that one island cannot take leaves all at one time") {
  StepOptions options{.time_step = 1e-2, .max_iterations = 1, .smallest_time_step = 5e-3};
  Scene scene = empty_scene();
  add_heap(scene, kHere);
  add_slider(scene, kThere);
  Simulation simulation(scene, options);
  StepReport report;
  for (int step = 0; step < 40 && report.status == StepStatus::Converged; ++step)
    report = simulation.advance();
  REQUIRE(report.status == StepStatus::NotConverged);
  CHECK(simulation.best_try().blocks.size() == scene.blocks.size());
  CHECK(simulation.best_try().time > simulation.state().time);
}
