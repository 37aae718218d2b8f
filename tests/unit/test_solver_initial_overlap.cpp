/// Blocks whose shared faces are warped: their convex hulls overlap at the start.

#include <algorithm>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/solver.hpp>

#include "support/catch.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

constexpr Material kStone{.density = 2400};
constexpr double kWarp = 0.01;  // m
constexpr int kCourses = 6;

/// Corners of the bed between course i - 1 and i: two opposite ones up, the others down.
geometry::Points bed(int i) {
  const double warp = i == 0 || i == kCourses ? 0.0 : (i % 2 == 0 ? kWarp : -kWarp);
  geometry::Points corners(3, 4);
  corners << 0, 1, 1, 0, 0, 0, 1, 1, i + warp, i - warp, i + warp, i - warp;
  return corners;
}

Scene warped_tower() {
  Scene scene{.joint = {.friction_angle = 0.6}};
  scene.initial_overlap = InitialOverlap::Zero;
  scene.add_fixed(geometry::make_box({-1, -1, -1}, {2, 2, 0}));
  for (int i = 0; i < kCourses; ++i) {
    geometry::Points corners(3, 8);
    corners << bed(i), bed(i + 1);
    scene.add_rigid(geometry::make_hull(corners).polyhedron, kStone);
  }
  return scene;
}

double weight(const Scene& scene) {
  double sum = 0.0;
  for (const Block& block : scene.blocks) {
    if (block.kind == BlockKind::Rigid) {
      sum += 9.81 * block.material.density * geometry::mass_properties(block.body()).volume;
    }
  }
  return sum;
}

/// Upwards, by the ground.
double base_reaction(const State& state) {
  double sum = 0.0;
  for (const Contact& contact : state.contacts) {
    if (contact.point.key.a == 0) {
      sum += (contact.normal_force * contact.point.normal - contact.shear_force).z();
    }
  }
  return sum;
}

double largest_displacement(const Simulation& simulation) {
  double largest = 0.0;
  for (std::size_t b = 0; b < simulation.scene().blocks.size(); ++b) {
    const Vector3 start = geometry::mass_properties(simulation.scene().blocks[b].body()).centroid;
    const State& state = simulation.state();
    largest = std::max(largest, (state.origin + state.blocks[b].centroid - start).norm());
  }
  return largest;
}

}  // namespace

TEST_CASE("Overlap of the start taken as touching: a warped tower stands as it is") {
  Simulation simulation(warped_tower(), {.time_step = 1e-2, .analysis = Analysis::Static});
  REQUIRE(simulation.advance().status == StepStatus::Converged);
  simulation.set_options({.time_step = 1e-2});
  for (int step = 0; step < 20; ++step) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    CHECK(report.largest_overlap < 1e-9);
  }
  CHECK(largest_displacement(simulation) < 1e-9);
  const double wanted = weight(simulation.scene());
  CHECK_THAT(base_reaction(simulation.state()), WithinRel(wanted, 1e-8));
}

TEST_CASE("The same tower is refused, or pushed apart, when it is not") {
  Scene scene = warped_tower();
  scene.initial_overlap = InitialOverlap::Refuse;
  CHECK_THROWS_WITH(Simulation(scene, {}), ContainsSubstring("overlap by"));
  scene.initial_overlap = InitialOverlap::Keep;
  Simulation simulation(scene, {.time_step = 1e-2, .analysis = Analysis::Static});
  REQUIRE(simulation.advance().status == StepStatus::Converged);
  CHECK(largest_displacement(simulation) > kWarp / 2);
}

TEST_CASE(
    "Only the depth of the start is taken off: blocks that meet later do not pass into each "
    "other") {
  Scene scene = warped_tower();
  scene.blocks.back().velocity = Vector3(0, 0, 0.5);  // hops, and lands where it stood
  Simulation simulation(scene, {.time_step = 5e-3});
  double highest = 0.0;
  for (int step = 0; step < 60; ++step) {
    REQUIRE(simulation.advance().status == StepStatus::Converged);
    highest = std::max(highest, largest_displacement(simulation));
  }
  CHECK(highest > 0.01);
  CHECK(largest_displacement(simulation) < 2 * kWarp);
}
