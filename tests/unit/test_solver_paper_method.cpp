/// The source's own method and its penalty method: how they fail. Where they end and what they cost
/// are cases tools/scenes/cases/paper_*.json and penalty_*.json.

#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>

#include "support/catch.hpp"

using namespace quoin::solver;
using quoin::geometry::make_box;

namespace {

/// A cube of 1 m on the ground.
Scene cube_on_ground(bool rigid, double friction_angle) {
  const Material rock{.density = 2500, .young = 5e9, .poisson = 0.25};
  Scene scene{.joint = {.friction_angle = friction_angle}};
  scene.add_fixed(make_box({-3, -3, -1}, {3, 3, 0}));
  rigid ? scene.add_rigid(make_box({0, 0, 0}, {1, 1, 1}), rock)
        : scene.add_block(make_box({0, 0, 0}, {1, 1, 1}), rock);
  return scene;
}

}  // namespace

TEST_CASE("The source's loop asks whether to go on, too") {
  Scene scene = cube_on_ground(true, 0.2);
  int asked = 0;
  Simulation simulation(scene, {.time_step = 1e-2,
                                .method = ContactMethod::Paper,
                                .penalty = 1e2,  // hundreds of thousands of solves
                                .max_iterations = 1000000000,
                                .watch = [&](const StepReport&) { return ++asked < 2; }});
  CHECK(simulation.advance().status == StepStatus::Stopped);
  CHECK(asked == 2);
  CHECK(simulation.state().time == 0.0);
}

TEST_CASE("Too few solves: the step ends, the state stays, and the report says so") {
  for (const ContactMethod method : {ContactMethod::Paper, ContactMethod::Penalty}) {
    Scene scene = cube_on_ground(false, 0.2);
    scene.blocks[1].velocity = Vector3(1, 0, 0);
    Simulation simulation(scene, {.time_step = 1e-2,
                                  .method = method,
                                  .penalty = 1e6,
                                  .max_iterations = 2,
                                  .smallest_time_step = 5e-3});
    const StepReport report = simulation.advance();
    CHECK(report.status == StepStatus::NotConverged);
    CHECK(report.linear_solves <= 4);
    CHECK(simulation.state().time == 0.0);
  }
}

TEST_CASE("The source has one time scheme") {
  CHECK_THROWS_AS(Simulation(cube_on_ground(true, 0.0), {.method = ContactMethod::Paper,
                                                         .scheme = TimeScheme::EnergyMomentum}),
                  InputError);
}
