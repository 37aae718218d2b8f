/// Springs on a joint's area that changes: a corner that comes down is as stiff as before, and what
/// comes and goes makes no energy.

#include <array>
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
constexpr double kDegree = std::numbers::pi / 180.0;
const Material kStone{.density = 2500, .young = 5e10, .poisson = 0.2};
constexpr double kFace = 0.08;                       // of a brick, m2
constexpr double kWeight = 2500 * 0.016 * kGravity;  // of a brick, N

geometry::Shape brick(const Vector3& low) {
  return geometry::make_box(low, low + Vector3(0.4, 0.2, 0.2));
}

Scene floor_with(const Joint& joint) {
  Scene scene{.joint = joint};
  scene.gravity = VectorOfTime(Vector3(0, 0, -kGravity));
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
  return scene;
}

Joint springs(double friction_angle, double normal, double shear) {
  return {.friction_angle = friction_angle * kDegree,
          .normal_stiffness = normal,
          .shear_stiffness = shear};
}

void run(Simulation& simulation, double time) {
  const double dt = simulation.options().time_step;
  for (int i = 0; i < static_cast<int>(std::lround(time / dt)); ++i) {
    const StepReport report = simulation.advance();
    INFO(describe(report));
    REQUIRE(report.status == StepStatus::Converged);
    for (const StepFlag& flag : report.flags) REQUIRE(flag.kind != FlagKind::EnergyGrowth);
  }
}

void settle(Simulation& simulation) {
  StepOptions options = simulation.options();
  options.analysis = Analysis::Static;
  simulation.set_options(options);
  for (int i = 0; i < 500; ++i) {
    if (simulation.advance().verdict == StaticVerdict::Rest) return;
  }
  FAIL("no equilibrium");
}

}  // namespace

TEST_CASE("a brick on springs that slides and spins comes to rest on the floor") {
  for (const double time_step : {2e-3, 1e-3}) {
    CAPTURE(time_step);
    Scene scene = floor_with(springs(15, 1e9, 1e9));
    scene.add_rigid(brick({0, 0, 0}), kStone);
    scene.blocks[1].velocity = Vector3(0.5, 0, 0);
    scene.blocks[1].angular_velocity = Vector3(0, 0, 2);
    Simulation simulation(scene, {.time_step = time_step});
    run(simulation, 1.2);
    const double sinks = kWeight / (1e9 * kFace);
    CHECK(simulation.vertices(1).row(2).minCoeff() > -3.0 * sinks);
    CHECK(simulation.state().energy.kinetic < 1e-9);
  }
}

TEST_CASE("a brick that has rocked on springs has all its area again") {
  constexpr double kStiffness = 1e8;
  for (const double turns : {0.02, 0.05, 0.1, 0.2}) {
    CAPTURE(turns);
    Scene scene = floor_with(springs(30, kStiffness, kStiffness));
    scene.add_rigid(brick({0, 0, 0}), kStone);
    Simulation simulation(scene, {.time_step = 1e-3});
    settle(simulation);
    StepOptions options = simulation.options();
    options.analysis = Analysis::Dynamic;
    simulation.set_options(options);
    simulation.set_velocities(
        std::array{BlockVelocity{.block = 1, .angular_velocity = {turns, 0.3 * turns, 0}}});
    run(simulation, 0.5);
    settle(simulation);
    const double sinks = kWeight / (kStiffness * kFace);
    for (int corner = 0; corner < 8; ++corner) {
      const Vector3 moved =
          simulation.vertices(1).col(corner) - scene.blocks[1].body().vertices().col(corner);
      CHECK(std::abs(moved.z() + sinks) < 1e-3 * sinks);
    }
    for (const Contact& contact : simulation.state().contacts) {
      const bool inner = contact.point.key.feature_b.kind != geometry::FeatureKind::Vertex;
      CHECK(std::abs(contact.spring_area - (inner ? 5.0 : 1.0) / 24.0 * kFace) < 1e-6 * kFace);
    }
  }
}

TEST_CASE("what falls on springs converges and makes no energy") {
  struct Drop {
    Vector3 place, velocity, axis;
    double angle, stiffness, time_step;
    TimeScheme scheme;
  };
  const Vector3 across = Vector3::UnitY();
  for (const Drop& drop : {Drop{{0.16369616873214543, 0.1, 0.5},
                                {0.32021132522164103, 0, -1},
                                across,
                                19.83826925701287,
                                1e9,
                                2e-3,
                                TimeScheme::ConstantAcceleration},
                           Drop{{0.12858013800881418, 0.1, 0.5},
                                {0.054853199660904094, 0, -1},
                                {-0.8019314252534474, -1.324358995628145, -0.24836162209524854},
                                7.966188630991104,
                                1e9,
                                5e-4,
                                TimeScheme::EnergyMomentum},
                           Drop{{0.1511821624700257, 0.1, 0.5},
                                {0.16521853809169357, 0, -1},
                                across,
                                57.27550329792644,
                                1e8,
                                2e-3,
                                TimeScheme::EnergyMomentum}}) {
    CAPTURE(drop.angle);
    Scene scene = floor_with(springs(30, drop.stiffness, 0.5 * drop.stiffness));
    scene.add_rigid(brick({0, 0, 0}), kStone);
    const Matrix3 turn =
        Eigen::AngleAxisd(drop.angle * kDegree, drop.axis.normalized()).toRotationMatrix();
    geometry::Shape falling = brick({-0.2, -0.1, -0.1});
    const geometry::Points places = (turn * falling.vertices()).colwise() + drop.place;
    falling.set_vertices(places);
    scene.add_rigid(falling, kStone);
    scene.blocks[2].velocity = drop.velocity;
    Simulation simulation(scene, {.time_step = drop.time_step, .scheme = drop.scheme});
    run(simulation, 0.8);
  }
}

TEST_CASE("a brick hangs on bonded springs, however far they stretch within their strength") {
  for (const double sag : {1e-5, 2e-4, 1e-3, 1e-2}) {  // m; a bond was lost beyond 2.5e-5
    CAPTURE(sag);
    const double area = kFace, stiffness = kWeight / (sag * area);
    Joint joint = springs(30, stiffness, stiffness);
    joint.tension = 10.0 * kWeight / area;
    Scene scene{.joint = joint};
    scene.gravity = VectorOfTime(Vector3(0, 0, -kGravity));
    scene.add_fixed(geometry::make_box({-1, -1, 0.2}, {1, 1, 1}));
    scene.add_rigid(brick({0, 0, 0}), kStone);
    const double period = 2.0 * std::numbers::pi * std::sqrt(sag / kGravity);
    const StepOptions options{.time_step = period / 200.0, .scheme = TimeScheme::EnergyMomentum};
    const auto fallen = [](const Simulation& simulation) {
      return 0.1 - simulation.state().blocks[1].centroid.z();
    };
    Simulation hangs(scene, options);
    settle(hangs);
    CHECK(std::abs(fallen(hangs) - sag) <= 1e-8 * sag);
    hangs.set_options(options);
    run(hangs, period);
    CHECK(std::abs(fallen(hangs) - sag) <= 1e-8 * sag);
    Simulation swings(scene, options);
    double lowest = 0.0;
    for (int step = 0; step < 200; ++step) {
      REQUIRE(swings.advance().status == StepStatus::Converged);
      lowest = std::max(lowest, fallen(swings));
    }
    CHECK(std::abs(lowest - 2.0 * sag) <= 1e-3 * sag);
  }
}
