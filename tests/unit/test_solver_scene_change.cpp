/// Simulation::change: bits through a checkpoint, what springs know of their area, what is refused.
/// Closed forms are tools/scenes/cases/stage_*.json.
#include <array>
#include <cmath>
#include <quoin/geometry/build.hpp>
#include <quoin/solver/simulation.hpp>
#include <sstream>

#include "support/catch.hpp"
#include "support/same_state.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

constexpr double kG = 9.81;  // m/s2
const Material kStone{.density = 2000, .young = 1e9, .poisson = 0.2};

geometry::Shape cube_at(double x, double z) {
  return geometry::make_box({x, 0, z}, {x + 1, 1, z + 1});
}

/// Ground, a cube on it, and another that stands on that.
Scene stack() {
  Scene scene{.joint = {.friction_angle = 0.6}};
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
  scene.add_rigid(cube_at(0, 0), kStone);
  scene.add_rigid(cube_at(0, 1), kStone);
  return scene;
}

void run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) REQUIRE(simulation.advance().status == StepStatus::Converged);
}

}  // namespace

TEST_CASE("what is laid is bonded, and goes on from a checkpoint to the bit") {
  Scene without = stack();
  without.joint.tension = 1e5;
  without.joint.cohesion = 1e5;
  without.initial_overlap = InitialOverlap::Zero;
  without.blocks[2].shape = std::make_shared<const geometry::Shape>(
      geometry::make_box({0, 0, 0.99}, {1, 1, 2}));  // 10 mm into the lower one
  Scene with = without;
  without.blocks[2].kind = BlockKind::Absent;
  with.fixed_points = {{.block = 1, .point = {0.5, 0.5, 0.5}, .displacement = {}}};
  with.gravity = VectorOfTime(Vector3(0, 0, kG));
  Simulation simulation(without, {});
  run(simulation, 3);
  simulation.change(with);
  const std::string middle = saved(simulation);
  run(simulation, 20);
  REQUIRE(std::abs(simulation.state().blocks[2].centroid.z() - 1.495) <
          1e-6);  // hangs by its joint
  std::istringstream in(middle);
  Simulation other(with, {}, in);
  run(other, 20);
  REQUIRE(quoin::tests::same_bits(simulation.state(), other.state()));
  REQUIRE(simulation.state().energy.work == other.state().energy.work);
}

TEST_CASE(
    "a block that was held for a while has the joints it had before, also from a checkpoint") {
  // A cube lies on the ground, tied by a bond or not, and is fixed or prescribed without a motion;
  // another one flies, so that steps go on.
  for (const auto& [bonded, kind] :
       {std::pair(true, BlockKind::Fixed), std::pair(true, BlockKind::Prescribed),
        std::pair(false, BlockKind::Fixed)}) {
    Scene scene{.joint = {.friction_angle = 0.6, .cohesion = 1e5, .tension = 1e5}};
    if (!bonded) scene.joint = {.friction_angle = 0.6};
    scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
    scene.add_rigid(cube_at(0, 0), kStone);
    scene.add_rigid(cube_at(3, 20), kStone);
    Simulation simulation(scene, {.time_step = 1e-2});
    run(simulation, 3);
    scene.blocks[1].kind = kind;
    simulation.change(scene);
    run(simulation, 3);
    std::ostringstream out;
    simulation.save(out);
    std::istringstream in(out.str());
    Simulation other(scene, {.time_step = 1e-2}, in);
    scene.blocks[1].kind = BlockKind::Rigid;
    scene.gravity = VectorOfTime(Vector3(0, 0, kG));
    for (Simulation* freed : {&simulation, &other}) {
      freed->change(scene);
      run(*freed, 10);
      const double rise = freed->state().blocks[1].centroid.z() - 0.5;
      REQUIRE(std::abs(rise - (bonded ? 0.0 : 0.5 * kG * 0.01)) < 1e-9);
    }
  }
}

TEST_CASE("a fixed block that a support has come into is not set free") {
  Scene scene{.joint = {.friction_angle = 0.6}};
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
  scene.add_rigid(cube_at(0, 0), kStone);
  scene.blocks[0].kind = BlockKind::Prescribed;
  scene.blocks[0].motion = {MotionKind::Velocity, VectorOfTime(Vector3(0, 0, 0.5))};
  scene.blocks[1].kind = BlockKind::Fixed;
  Simulation simulation(scene, {.time_step = 1e-2});
  run(simulation, 10);
  const std::string before = saved(simulation);
  scene.blocks[1].kind = BlockKind::Rigid;
  REQUIRE_THROWS_AS(simulation.change(scene), InputError);
  REQUIRE((saved(simulation) == before));
}

TEST_CASE(
    "an edge that a block stands on has its corners' share of the face when a stiffness is given "
    "later") {
  constexpr double kStiffness = 1e8;  // Pa/m
  Scene scene;
  scene.joint = {.friction_angle = 0.6};
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
  scene.add_rigid(cube_at(0, 0), kStone);
  Simulation simulation(scene, {.time_step = 1e-3});
  run(simulation, 1);
  simulation.set_velocities(std::array{
      BlockVelocity{.block = 1, .velocity = {0.25, 0, 0.25}, .angular_velocity = {0, 0.5, 0}}});
  run(simulation, 50);
  scene.joint.normal_stiffness = scene.joint.shear_stiffness = kStiffness;
  simulation.change(scene);
  run(simulation, 1);
  int closed = 0;
  for (const Contact& contact : simulation.state().contacts) {
    if (contact.mode == ContactMode::Open) continue;
    ++closed;
    CHECK(contact.point.area == 0.0);
    CHECK(std::abs(contact.spring_area - 1.0 / 24.0) < 1e-4);
  }
  CHECK(closed == 2);
}

TEST_CASE("a change that can't be is refused and changes nothing") {
  Scene without = stack();
  without.blocks[2].kind = BlockKind::Absent;
  without.blocks[2].shape = std::make_shared<const geometry::Shape>(
      geometry::make_box({0, 0, 0.5}, {1, 1, 2}));  // within the lower cube
  Simulation simulation(without, {});
  run(simulation, 2);
  const std::string before = saved(simulation);
  Scene with = without;
  with.blocks[2].kind = BlockKind::Rigid;
  REQUIRE_THROWS_AS(simulation.change(with), InputError);
  Scene fewer = without;
  fewer.blocks.pop_back();
  REQUIRE_THROWS_AS(simulation.change(fewer), InputError);
  Scene other = without;
  other.blocks[1].shape = std::make_shared<const geometry::Shape>(cube_at(0.1, 0));
  REQUIRE_THROWS_AS(simulation.change(other), InputError);
  Scene moved = without;
  moved.blocks[1].placement.translation.x() = 0.1;
  REQUIRE_THROWS_AS(simulation.change(moved), InputError);
  REQUIRE((saved(simulation) == before));
}
