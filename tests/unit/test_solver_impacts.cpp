/// What impacts must not hold up. Impacts with known answers are cases V41 to V44; forces of
/// impacts, and what has no solution, cases of tools/scenes/cases.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>
#include <vector>

#include "support/catch.hpp"

using namespace quoin::solver;
namespace geometry = quoin::geometry;

TEST_CASE("Strain of a wall that is pushed slowly does not wait for impacts that are none") {
  // Three courses of two bricks of 1 x 0.5 x 0.5 m in bond, and a heavy slab on top that is pushed.
  constexpr double kFriction = 30.0 * std::numbers::pi / 180.0, kHigh = 0.5, kTop = 3 * kHigh;
  const Material brick{.density = 2000, .young = 1e9, .poisson = 0.2}, slab{.density = 20000};
  Scene scene{.joint = {.friction_angle = kFriction}};
  scene.gravity = Vector3(0, 0, -10);
  scene.add_fixed(geometry::make_box({-2, -1, -1}, {8, 2, 0}));
  for (int course = 0; course < 3; ++course) {
    const std::vector<double> joints =
        course % 2 == 1 ? std::vector<double>{0, 0.5, 1.5, 2} : std::vector<double>{0, 1, 2};
    for (std::size_t k = 1; k < joints.size(); ++k) {
      scene.add_block(geometry::make_box({joints[k - 1], 0, kHigh * course},
                                         {joints[k], 0.5, kHigh * (course + 1)}),
                      brick);
    }
  }
  scene.add_rigid(geometry::make_box({0, 0, kTop}, {2, 0.5, kTop + 0.5}), slab);
  const int top = static_cast<int>(scene.blocks.size()) - 1;
  const double most = 0.95 * std::tan(kFriction) * 10.0 * 20000 * 0.5;
  scene.point_loads.push_back({top, {1, 0.25, kTop}, VectorOfTime([most](double time) {
                                 return Vector3(most * std::min(time / 0.15, 1.0), 0, 0);
                               })});
  Simulation simulation(scene, {.time_step = 1e-3, .analysis = Analysis::Static});
  for (int k = 0; k < 6; ++k) REQUIRE(simulation.advance().status == StepStatus::Converged);
  simulation.set_options({.time_step = 1e-3});
  const auto strains = [&] {
    std::vector<Vector6> all;
    for (const BlockState& block : simulation.state().blocks) all.push_back(block.strain);
    return all;
  };
  int waiting = 0;
  for (int step = 0; step < 250; ++step) {
    const std::vector<Vector6> before = strains();
    REQUIRE(simulation.advance().status == StepStatus::Converged);
    waiting += before == strains();
  }
  CHECK(waiting <= 5);  // 40 where what strain sets free, from rest, was an impact
}
