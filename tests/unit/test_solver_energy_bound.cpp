#include <cmath>
#include <quoin/geometry/build.hpp>

#include "solver/src/step/energy_bound.hpp"
#include "solver/src/step/form_islands.hpp"
#include "support/catch.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

/// Two free blocks of 1000 kg, at rest at the start; block 0 is given `work` (J).
struct Step {
  CompiledScene compiled;
  StepOptions options{.time_step = kTimeStep};
  IslandBlocks island;
  State start, end;
  StepEnergy energy;
  BlockVector positions{2, Vector12::Zero()};
  std::vector<double> pushed{0.0, 0.0};
  std::vector<char> bouncing{0, 0}, grounded{0, 0}, driven{0, 0};

  Step(double work, const Vector3& by_positions, const Vector3& by_law)
      : compiled(compile(scene())),
        island(island_blocks(compiled, std::vector<int>(2, 0)).front()),
        start(initial_state(compiled)) {
    end = start;
    energy.work_on = {work, 0.0};
    positions[0].head<3>() = kTimeStep * by_positions;
    end.blocks[0].velocity = by_law;
  }
  static Scene scene() {
    Scene scene;
    for (const double x : {0.0, 5.0})
      scene.add_rigid(geometry::make_box({x, 0, 0}, {x + 1, 1, 1}), {.density = 1000});
    return scene;
  }
  void bound(std::vector<int> groups) {
    const SubStep step{.compiled = compiled,
                       .options = options,
                       .island = island,
                       .slot_of_block = compiled.slots.slot_of_block,
                       .state = start.blocks,
                       .length = kTimeStep};
    std::vector<GroupEnergy> of_group;
    bound_energy(step, {positions, groups, pushed, 5e-7, bouncing, grounded, driven}, end.blocks,
                 energy, of_group);
  }
  double kinetic() const {
    return kinetic_energy(compiled.models[0], end.blocks[0]) +
           kinetic_energy(compiled.models[1], end.blocks[1]);
  }
  Vector3 linear_momentum() const {
    return compiled.models[0].mass * (end.blocks[0].velocity + end.blocks[1].velocity);
  }
  Vector3 angular_momentum() const {
    Vector3 sum = Vector3::Zero();
    for (std::size_t b = 0; b < 2; ++b) {
      sum += compiled.models[b].mass * end.blocks[b].centroid.cross(end.blocks[b].velocity) +
             compiled.models[b].inertia * end.blocks[b].angular_velocity;
    }
    return sum;
  }
  static constexpr double kTimeStep = 0.01;
};

}  // namespace

TEST_CASE("Velocities within the energy that there is are left as they are, to the bit") {
  Step step(500.0, {1, 0, 0}, {0.3, 0.7, 0});
  step.bound({0, 1});
  CHECK(step.end.blocks[0].velocity == Vector3(0.3, 0.7, 0));
}

TEST_CASE("Velocities beyond it go as far as it lasts, and keep to the line to them") {
  Step step(600.0, {1, 0, 0}, {1, 2, 0});  // 500 J by the positions, 2500 J by the law
  step.bound({0, 1});
  CHECK_THAT(step.kinetic(), WithinRel(600.0, 1e-6));
  CHECK_THAT(step.end.blocks[0].velocity.x(), WithinRel(1.0, 1e-12));
  CHECK_THAT(step.end.blocks[0].velocity.y(), WithinRel(std::sqrt(0.2), 2e-6));
}

TEST_CASE("Where the positions have all the energy that there is, they have the last word") {
  Step step(500.0, {1, 0, 0}, {2, 0, 0});
  step.bound({0, 1});
  CHECK_THAT(step.kinetic(), WithinRel(500.0, 1e-6));
}

TEST_CASE("Where the positions have more energy than there is, the least on the line is left") {
  Step step(300.0, {1, 0, 0}, {0, 2, 0});  // 500 J, 2000 J, and 400 J a fifth of the way
  step.bound({0, 1});
  CHECK_THAT(step.kinetic(), WithinRel(400.0, 1e-12));
  CHECK_THAT(step.end.blocks[0].velocity.y(), WithinRel(0.4, 1e-12));
}

TEST_CASE("A group that bounces keeps its momentum, and its relative motion has the energy left") {
  Step step(900.0, {2, 0, 0}, {1, 1, 0});  // 2000 J by the positions, 1083 J by the law
  step.bouncing = {1, 0};
  step.grounded = {0, 0};
  step.end.blocks[0].angular_velocity = Vector3(0, 0, 1);
  const Vector3 linear = step.linear_momentum(), angular = step.angular_momentum();
  step.bound({0, 0});
  CHECK_THAT(step.kinetic(), WithinRel(900.0, 1e-12));
  CHECK((step.linear_momentum() - linear).norm() < 1e-10 * linear.norm());
  CHECK((step.angular_momentum() - angular).norm() < 1e-10 * angular.norm());
}

TEST_CASE("A group that bounces on a support keeps its mean translation") {
  Step step(550.0, {2, 0, 0}, {0, 1, 0});
  step.bouncing = step.grounded = {1, 0};
  step.end.blocks[0].angular_velocity = Vector3(0, 0, 2);
  step.bound({0, 1});
  CHECK_THAT(step.kinetic(), WithinRel(550.0, 1e-12));
  CHECK(step.end.blocks[0].velocity == Vector3(0, 1, 0));
}

TEST_CASE("An island is judged by its own energy") {
  const auto kinetic = [](std::vector<int> islands) {
    Step step(500.0, {1, 0, 0}, {0, 0, 0});
    step.end.blocks[1].velocity = Vector3(1, 0, 0);  // of what block 0 was given
    step.bound(std::move(islands));
    return step.kinetic();
  };
  CHECK_THAT(kinetic({0, 0}), WithinRel(500.0, 1e-12));
  CHECK_THAT(kinetic({0, 1}), WithinAbs(0.0, 1e-9));
}

TEST_CASE("A support that moves gives energy; what it gives is booked as work") {
  Step step(0.0, {0, 0, 0}, {1, 0, 0});
  step.pushed[0] = 500.0;
  step.bound({0, 1});
  CHECK_THAT(step.kinetic(), WithinRel(500.0, 1e-12));
  CHECK_THAT(step.energy.load_work, WithinRel(500.0, 1e-12));
  CHECK_THAT(step.energy.impact_loss, WithinRel(500.0, 1e-12));
}
