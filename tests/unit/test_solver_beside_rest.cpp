/// A block that falls beside a wall at rest: the wall is not looked at, and the report is that of
/// the whole scene.

#include <algorithm>
#include <cmath>
#include <memory>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>
#include <sstream>

#include "support/catch.hpp"
#include "support/same_state.hpp"
#include "support/sanitized.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

constexpr Material kRigid{.density = 2000};

/// Ten courses of ten bricks, and a block high up beside them.
Scene wall_and_block(double height) {
  Scene scene{.joint = {.friction_angle = 0.6}};
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {10, 5, 0}));
  for (int row = 0; row < 10; ++row) {
    for (int i = 0; i < 10; ++i) {
      const Vector3 low(0.4 * i + 0.2 * (row % 2), 0, 0.2 * row);
      scene.add_rigid(geometry::make_box(low, low + Vector3(0.4, 0.2, 0.2)), kRigid);
    }
  }
  scene.add_rigid(geometry::make_box({-2, 0, height}, {-1.6, 0.2, height + 0.2}), kRigid);
  return scene;
}

int closed_contacts(const State& state) {
  return static_cast<int>(std::ranges::count_if(
      state.contacts, [](const Contact& c) { return c.mode != ContactMode::Open; }));
}

}  // namespace

TEST_CASE("A wall at rest is not searched while a block falls beside it") {
  Simulation simulation(wall_and_block(50.0), {.time_step = 5e-3});
  for (int i = 0; i < 40; ++i) REQUIRE(simulation.advance().status == StepStatus::Converged);
  for (int i = 0; i < 100; ++i) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    CHECK(report.islands == 2);
    CHECK(report.islands_at_rest == 1);
    CHECK(report.searched_pairs <= 2);  // whatever its speed
    CHECK(report.block_solves <= 2);
  }
}

TEST_CASE("The report of a step beside a wall at rest is that of all blocks and contacts") {
  // The block falls for 0.4 s, lands and comes to rest.
  Simulation simulation(wall_and_block(0.8), {.time_step = 5e-3});
  std::vector<Contact> last;
  bool rested = false;
  for (int i = 0; i < 160; ++i) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    rested = rested || report.islands_at_rest == 1;
    const State& state = simulation.state();
    CHECK(report.closed_count == closed_contacts(state));
    CHECK(report.contact_count == static_cast<int>(state.contacts.size()));
    CHECK(std::ranges::is_sorted(state.contacts, {}, [](const Contact& c) { return c.point.key; }));
    const Vector3& velocity = state.blocks.back().velocity;
    CHECK(report.largest_speed >= velocity.norm());
    CHECK(report.flags.empty());
    double kinetic = 0.0;
    const double mass = 2000 * 0.4 * 0.2 * 0.2;
    for (const BlockState& block : state.blocks)
      kinetic += 0.5 * mass * block.velocity.squaredNorm();
    if (report.islands_at_rest == 1) CHECK(state.energy.kinetic >= kinetic * (1.0 - 1e-12));
  }
  CHECK(rested);
  CHECK(closed_contacts(simulation.state()) >= 4);
  CHECK(simulation.state().blocks.back().centroid.z() + simulation.state().origin.z() < 0.11);
}

TEST_CASE("Fixed blocks far away change nothing of blocks on a moved table") {
  // One block rests on the table, another tumbles over it: each takes sub-steps of its own, and
  // with many fixed blocks their points alone are searched for.
  const auto table = [](int fixed) {
    Scene scene{.joint = {.friction_angle = 0.5, .restitution = 0.3}};
    scene.gravity = VectorOfTime([](double) { return Vector3(0, 0, -9.81); });
    scene.add_fixed(geometry::make_box({-6, -2, -1}, {6, 2, 0}));
    scene.blocks[0].kind = BlockKind::Prescribed;
    scene.blocks[0].motion.value = VectorOfTime([](double t) { return Vector3(0.05 * t, 0, 0); });
    scene.add_rigid(geometry::make_box({-3.5, -0.5, 0}, {-2.5, 0.5, 0.4}), kRigid);
    scene.add_rigid(geometry::make_box({-3.4, -0.4, 0.4}, {-2.6, 0.4, 0.8}), kRigid);
    scene.add_rigid(geometry::make_box({2.5, -0.5, 0.3}, {3.5, 0.5, 0.7}), kRigid);
    scene.blocks[3].velocity = {0.7, 0, 0};
    scene.blocks[3].angular_velocity = {1.0, 2.0, 0.5};
    for (int i = 0; i < fixed; ++i) {
      scene.add_fixed(geometry::make_box({100.0 + 2 * i, 0, 0}, {101.0 + 2 * i, 1, 1}));
    }
    return scene;
  };
  Simulation alone(table(0), {.time_step = 1e-2}), among(table(60), {.time_step = 1e-2});
  for (int i = 0; i < 40; ++i) {
    REQUIRE(alone.advance().status == StepStatus::Converged);
    REQUIRE(among.advance().status == StepStatus::Converged);
    CHECK(alone.state().contacts.size() == among.state().contacts.size());
  }
  for (std::size_t b = 1; b < 4; ++b) {
    const Vector3 apart = alone.state().blocks[b].centroid + alone.state().origin -
                          among.state().blocks[b].centroid - among.state().origin;
    CHECK(apart.norm() < 1e-9);
  }
}

TEST_CASE("A block falls beside a wall at rest as it does alone") {
  Scene alone = wall_and_block(3.0);
  for (std::size_t b = 1; b + 1 < alone.blocks.size(); ++b)
    alone.blocks[b].kind = BlockKind::Absent;
  Simulation with(wall_and_block(3.0), {.time_step = 5e-3}), without(alone, {.time_step = 5e-3});
  for (int i = 0; i < 60; ++i) {
    REQUIRE(with.advance().status == StepStatus::Converged);
    REQUIRE(without.advance().status == StepStatus::Converged);
  }
  CHECK(with.state().blocks.back().centroid == without.state().blocks.back().centroid);
  CHECK(with.state().blocks.back().velocity == without.state().blocks.back().velocity);
}

TEST_CASE("Blocks that fall beside and onto a wall at rest go on from a checkpoint to the bit") {
  // What is known of a wall at rest is not saved: the run that goes on finds everything anew.
  Scene scene = wall_and_block(0.5);
  for (const double x : {0.3, 1.9, -3.1}) {
    const Vector3 low(x, 0.05, x < 0.0 ? 0.3 : 2.0 + 0.2 * x);
    scene.add_rigid(geometry::make_box(low, low + Vector3(0.4, 0.2, 0.2)), kRigid);
  }
  const StepOptions options{.time_step = 5e-3};
  Simulation through(scene, options);
  auto broken = std::make_unique<Simulation>(scene, options);
  bool rested = false, woken = false;
  for (int i = 0; i < unless_sanitized(100, 70); ++i) {
    CAPTURE(i);
    if (i % 9 == 4) {
      std::stringstream saved;
      broken->save(saved);
      broken = std::make_unique<Simulation>(scene, options, saved);
    }
    const StepReport report = through.advance(), again = broken->advance();
    REQUIRE(report.status == StepStatus::Converged);
    rested = rested || report.islands_at_rest > 0;
    woken = woken || (rested && report.islands_at_rest == 0);
    REQUIRE(quoin::tests::same_bits(through.state(), broken->state()));
    CHECK(report.islands == again.islands);
    CHECK(report.islands_at_rest == again.islands_at_rest);
    CHECK(report.closed_count == again.closed_count);
    CHECK(report.largest_overlap == again.largest_overlap);
  }
  CHECK(rested);
  CHECK(woken);
}
