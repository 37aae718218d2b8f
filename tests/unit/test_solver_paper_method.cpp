/// The source's own method and its penalty method: where they end, what they cost, how they fail.

#include <cmath>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>

#include "support/catch.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

constexpr double kGravity = 9.81;
constexpr Material kRock{.density = 2500, .young = 5e9, .poisson = 0.25};

/// A cube of 1 m on the ground.
Scene cube_on_ground(bool rigid, double friction_angle) {
  Scene scene;
  scene.joint.friction_angle = friction_angle;
  scene.add_fixed(geometry::make_box({-3, -3, -1}, {3, 3, 0}));
  const geometry::Shape cube = geometry::make_box({0, 0, 0}, {1, 1, 1});
  rigid ? scene.add_rigid(cube, kRock) : scene.add_block(cube, kRock);
  return scene;
}

struct Totals {
  long solves = 0, factorizations = 0;
  double overlap = 0.0;
};

Totals run(Simulation& simulation, int steps) {
  Totals totals;
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    totals.solves += report.linear_solves;
    totals.factorizations += report.factorizations;
    totals.overlap = report.largest_overlap;
  }
  return totals;
}

double weight_carried(const State& state) {
  double sum = 0.0;
  for (const Contact& contact : state.contacts) sum += contact.normal_force;
  return sum;
}

}  // namespace

TEST_CASE("Penalty sinks in by weight over its four springs, Algorithm 1 does not") {
  const double weight = kRock.density * kGravity;
  for (const bool rigid : {true, false}) {
    for (const double penalty : {1e7, 1e9}) {
      StepOptions options{.time_step = 0.1,
                          .analysis = Analysis::Static,
                          .method = ContactMethod::Penalty,
                          .penalty = penalty};
      Simulation springs(cube_on_ground(rigid, 0.5), options);
      const Totals sunk = run(springs, 60);
      CHECK_THAT(weight_carried(springs.state()), WithinRel(weight, 1e-6));
      CHECK_THAT(sunk.overlap, WithinRel(weight / (4 * penalty), 1e-6));
      options.method = ContactMethod::Paper;
      Simulation paper(cube_on_ground(rigid, 0.5), options);
      const Totals exact = run(paper, 60);
      CHECK_THAT(weight_carried(paper.state()), WithinRel(weight, 1e-8));
      CHECK(exact.overlap < 1e-9 * sunk.overlap + 1e-12);
    }
  }
}

TEST_CASE("Algorithm 1 needs more solves the softer its penalty, and one matrix") {
  long last = 0;
  for (const double penalty : {1e10, 1e8, 1e7}) {
    Simulation simulation(cube_on_ground(true, 0.0),
                          {.time_step = 0.01, .method = ContactMethod::Paper, .penalty = penalty});
    const Totals totals = run(simulation, 5);
    CHECK(totals.solves > last);
    CHECK(totals.factorizations <= 6);
    last = totals.solves;
  }
}

TEST_CASE(
    "A cube slides with friction as the formula says, and its energy goes where it is booked") {
  for (const ContactMethod method : {ContactMethod::Paper, ContactMethod::Penalty}) {
    Scene scene = cube_on_ground(true, std::atan(0.2));
    const double slope = 0.4;  // rad
    scene.gravity = Vector3(kGravity * Vector3(std::sin(slope), 0, -std::cos(slope)));
    Simulation simulation(scene, {.time_step = 1e-2, .method = method, .penalty = 1e9});
    run(simulation, 60);
    const double way = 0.5 * kGravity * (std::sin(slope) - 0.2 * std::cos(slope)) * 0.36;
    const State& state = simulation.state();
    CHECK_THAT(state.blocks[1].centroid.x() - 0.5, WithinRel(way, 1e-5));
    const double loss = 0.2 * kRock.density * kGravity * std::cos(slope) * way;
    CHECK_THAT(state.energy.friction_loss, WithinRel(loss, 1e-3));
    CHECK(std::abs(state.energy.closure) < 1e-5 * loss);
  }
}

TEST_CASE("A prescribed ground lifts a cube: its work is booked") {
  for (const ContactMethod method : {ContactMethod::Paper, ContactMethod::Penalty}) {
    Scene scene = cube_on_ground(true, 0.5);
    scene.blocks[0].kind = BlockKind::Prescribed;
    scene.blocks[0].motion = {MotionKind::Acceleration, Vector3(1.0, 0, 2.0)};
    Simulation simulation(scene, {.time_step = 1e-3, .method = method, .penalty = 1e9});
    run(simulation, 300);
    const State& state = simulation.state();
    CHECK_THAT(state.blocks[1].centroid.z() - 0.5, WithinAbs(0.09, 1e-3));
    CHECK_THAT(state.blocks[1].centroid.x() - 0.5, WithinAbs(0.045, 1e-3));
    CHECK(state.energy.work > 0.0);
    CHECK(std::abs(state.energy.closure) < 1e-5 * state.energy.work);
  }
}

TEST_CASE("A cube hangs from a held point by its spring") {
  Scene scene;
  scene.add_rigid(geometry::make_box({0, 0, 0}, {1, 1, 1}), kRock);
  scene.fixed_points.push_back({0, {0.5, 0.5, 1}, {}});
  const double penalty = 1e8;
  Simulation simulation(scene, {.time_step = 1.0,
                                .analysis = Analysis::Static,
                                .method = ContactMethod::Penalty,
                                .penalty = penalty});
  run(simulation, 20);
  CHECK_THAT(simulation.state().blocks[0].centroid.z() - 0.5,
             WithinRel(-kRock.density * kGravity / penalty, 1e-6));
}

TEST_CASE("A block set in motion on a rough floor slides until friction has stopped it") {
  for (const ContactMethod method : {ContactMethod::Paper, ContactMethod::Penalty}) {
    for (const double time_step : {1e-3, 1e-2}) {
      CAPTURE(static_cast<int>(method), time_step);
      Scene scene = cube_on_ground(true, std::atan(0.2));
      scene.blocks[1].velocity = Vector3(1, 0, 0);
      Simulation simulation(scene, {.time_step = time_step, .method = method, .penalty = 1e9});
      run(simulation, static_cast<int>(std::lround(1.0 / time_step)));
      const double way = 1.0 / (2.0 * 0.2 * kGravity);  // 0.25 m in 0.51 s
      CHECK_THAT(simulation.state().blocks[1].centroid.x() - 0.5, WithinRel(way, 0.02));
      CHECK(simulation.state().blocks[1].velocity.norm() < 0.02);
    }
  }
}

TEST_CASE("Rounding keeps no step from its end: a cube rests on a slope, turned and far away") {
  const Matrix3 turn = Eigen::AngleAxisd(0.9, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  const double slope = 20.0 * std::numbers::pi / 180.0;
  for (const bool rigid : {true, false}) {
    for (const double away : {0.0, 4e5}) {
      CAPTURE(rigid, away);
      Scene scene = cube_on_ground(rigid, 30.0 * std::numbers::pi / 180.0);
      scene.gravity = Vector3(kGravity * turn * Vector3(std::sin(slope), 0, -std::cos(slope)));
      for (Block& block : scene.blocks) {
        block.placement = {.linear = turn, .translation = Vector3(away, away, -away)};
      }
      for (const Analysis analysis : {Analysis::Settle, Analysis::Static}) {
        CAPTURE(static_cast<int>(analysis));
        Simulation simulation(
            scene, {.time_step = 1e-3, .analysis = analysis, .method = ContactMethod::Paper});
        run(simulation, 20);
        CHECK_THAT(weight_carried(simulation.state()),
                   WithinRel(kRock.density * kGravity * std::cos(slope), 1e-6));
      }
    }
  }
}

TEST_CASE("A laid joint has its cohesion from the first step on") {
  for (const ContactMethod method : {ContactMethod::Paper, ContactMethod::Penalty}) {
    // Of what the cohesion has to bear; the pull takes 0.6 of the friction off the back edge.
    for (const double share : {0.9, 1.2}) {
      CAPTURE(static_cast<int>(method), share);
      constexpr double kPull = 30.0, kThick = 0.2, kFriction = 0.5;
      const double left = kRock.density * kThick * (kPull - kFriction * kGravity);
      Scene scene{.joint = {.friction_angle = std::atan(kFriction), .cohesion = share * left}};
      scene.gravity = VectorOfTime(Vector3(kPull, 0, -kGravity));
      scene.add_fixed(geometry::make_box({-3, -3, -1}, {3, 3, 0}));
      scene.add_rigid(geometry::make_box({-0.5, -0.5, 0}, {0.5, 0.5, kThick}), kRock);
      Simulation simulation(scene, {.time_step = 0.01, .method = method, .penalty = 1e9});
      run(simulation, 10);
      const double moved = simulation.state().blocks[1].centroid.x();
      CHECK((share > 1.0 ? moved < 1e-4 : moved > 0.05));
    }
  }
}

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
