/// A step works in memory that is kept: once the lists of a scene have their length, blocks that
/// slide allocate nothing.

#include <cmath>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>

#include "support/catch.hpp"
#include "support/counted_allocations.hpp"

using namespace quoin::solver;
namespace geometry = quoin::geometry;

namespace {

constexpr Material kRigid{.density = 2500};
constexpr Material kRock{.density = 2500, .young = 5e9, .poisson = 0.25};

/// Gravity down a slope, on ground that lies flat.
Vector3 along_slope(double angle) { return {9.81 * std::sin(angle), 0, -9.81 * std::cos(angle)}; }

void add_ground(Scene& scene) { scene.add_fixed(geometry::make_box({-5, -5, -1}, {50, 50, 0})); }

/// Of `steps` steps after as many to warm up.
long allocations_of(Simulation& simulation, int steps) {
  long before = 0;
  for (int i = 0; i < 2 * steps; ++i) {
    if (i == steps) before = quoin::tests::allocations;
    REQUIRE(simulation.advance().status == StepStatus::Converged);
  }
  return quoin::tests::allocations - before;
}

/// Piles of two cubes that slide down a slope, each an island.
Scene sliding_piles(int count, const Material& material) {
  Scene scene;
  scene.joint.friction_angle = 0.2;
  scene.gravity = along_slope(0.4);
  add_ground(scene);
  for (int i = 0; i < count; ++i) {
    for (const double z : {0.0, 1.0}) {
      const Vector3 low(0, 3.0 * i, z);
      const geometry::Shape cube = geometry::make_box(low, low + Vector3::Ones());
      material.young > 0.0 ? scene.add_block(cube, material) : scene.add_rigid(cube, material);
    }
  }
  return scene;
}

}  // namespace

TEST_CASE("A block that slides allocates nothing in a step") {
  Scene scene;
  scene.joint.friction_angle = 0.2;
  scene.gravity = along_slope(0.4);
  add_ground(scene);
  scene.add_rigid(geometry::make_box({0, 0, 0}, {1, 1, 1}), kRigid);
  Simulation simulation(scene, {.time_step = 0.01});
  CHECK(allocations_of(simulation, 20) == 0);
}

TEST_CASE("Islands that slide allocate nothing in a step, rigid or not") {
  for (const Material& material : {kRigid, kRock}) {
    Simulation simulation(sliding_piles(3, material), {.time_step = 0.01});
    CHECK(allocations_of(simulation, 20) == 0);
    CHECK(simulation.advance().islands == 3);
  }
}

TEST_CASE("A wall of twelve bricks allocates lists of planes alone, for bricks that do not touch") {
  for (const double shaking : {0.0, 1.0}) {
    Scene scene;
    scene.joint.friction_angle = 0.6;
    scene.gravity = VectorOfTime(
        [shaking](double t) { return Vector3(shaking * std::sin(20.0 * t), 0, -9.81); });
    add_ground(scene);
    for (int row = 0; row < 3; ++row) {
      for (int i = 0; i < 4; ++i) {
        const Vector3 low(0.4 * i + 0.2 * (row % 2), 0, 0.2 * row);
        scene.add_rigid(geometry::make_box(low, low + Vector3(0.4, 0.2, 0.2)), kRigid);
      }
    }
    Simulation simulation(scene, {.time_step = 0.01});
    // Measured: 4 a step at rest, 11 shaken.
    CHECK(allocations_of(simulation, 20) <= (shaking > 0.0 ? 12 : 4) * 20);
  }
}
