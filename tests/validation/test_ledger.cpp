/// The energy ledger of whole runs: it closes, nothing is lost below zero, and rebounds reach the
/// height that restitution leaves.

#include <algorithm>
#include <cmath>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>

#include "support/catch.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

constexpr Material kRock{.density = 2500, .young = 5e9, .poisson = 0.25};
constexpr double kGravity = 9.81;
constexpr double kRounding = 1e-9;  // of the energy that moved

int add(Scene& scene, geometry::Shape shape, bool rigid) {
  return rigid ? scene.add_rigid(std::move(shape), kRock)
               : scene.add_block(std::move(shape), kRock);
}

geometry::Shape cube(const Vector3& corner) {
  return geometry::make_box(corner, corner + Vector3::Ones());
}

Scene with_ground(double friction, double restitution) {
  Scene scene;
  scene.joint.friction_angle = friction;
  scene.joint.restitution = restitution;
  scene.add_fixed(geometry::make_box({-20, -20, -1}, {20, 20, 0}));
  return scene;
}

/// Slides over rough ground until it stops.
Scene slide(bool rigid) {
  Scene scene = with_ground(0.4, 0.0);
  add(scene, cube({0, 0, 0}), rigid);
  scene.blocks[1].velocity = Vector3(1.5, 0.5, 0);
  return scene;
}

/// Four cubes that turn, fall on the ground and on each other.
Scene heap(bool rigid, double restitution) {
  Scene scene = with_ground(0.5, restitution);
  for (int i = 0; i < 4; ++i) {
    const int b = add(scene, cube({0.4 * i, 0.2 * i, 0.2 + 1.3 * i}), rigid);
    scene.blocks[static_cast<std::size_t>(b)].angular_velocity = Vector3(1 - 0.7 * i, 0.5 * i, 0.3);
  }
  return scene;
}

/// Shares of the energy that moved.
struct Allowed {
  double closure = 0.0;
  double gain = 0.0;  ///< of a loss, in one step
};

/// The ledger after every step. A step whose impacts gain energy says so.
void check_ledger(const Scene& scene, const StepOptions& options, int steps,
                  const Allowed& allowed) {
  Simulation simulation(scene, options);
  double scale = simulation.state().energy.kinetic;
  EnergyLedger last = simulation.state().energy;
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    const bool flagged = std::ranges::any_of(
        report.flags, [](const StepFlag& f) { return f.kind == FlagKind::EnergyGrowth; });
    const EnergyLedger& now = simulation.state().energy;
    scale = std::max(scale, now.kinetic - std::min(now.potential, 0.0));
    CAPTURE(i, scale);
    REQUIRE_THAT(now.closure, WithinAbs(0.0, allowed.closure * scale));
    const auto lost = [](const EnergyLedger& e) {
      return e.friction_loss + e.impact_loss + e.algorithmic_loss;
    };
    REQUIRE((lost(now) >= lost(last) - allowed.gain * scale || flagged));
    REQUIRE(std::min({now.friction_loss, now.impact_loss, now.algorithmic_loss}) >=
            -kRounding * scale);
    last = now;
  }
  CHECK(last.friction_loss + last.impact_loss + last.algorithmic_loss > 1e-3 * scale);
}

}  // namespace

TEST_CASE("The ledger closes and no loss is negative: sliding to a stop") {
  for (const bool rigid : {true, false}) {
    for (const ContactMethod method :
         {ContactMethod::AugmentedLagrangian, ContactMethod::Springs}) {
      CAPTURE(rigid, name(method));
      check_ledger(slide(rigid), {.time_step = 5e-3, .method = method, .penalty = 1e9}, 150,
                   {.closure = 1e-8, .gain = 1e-9});
    }
  }
}

TEST_CASE("The ledger closes and no loss is negative: blocks fall on each other") {
  for (const bool rigid : {true, false}) {
    for (const double restitution : {0.0, 0.5}) {
      CAPTURE(rigid, restitution);
      // A block that turns and strains keeps its energy to the order of its strain, step by step.
      check_ledger(heap(rigid, restitution), {.time_step = 5e-3}, 300,
                   {.closure = rigid ? 1e-8 : 1e-4, .gain = 1e-5});
    }
  }
}

TEST_CASE("The ledger of a static analysis closes by every method") {
  const auto method = GENERATE(ContactMethod::AugmentedLagrangian, ContactMethod::Springs,
                               ContactMethod::Paper, ContactMethod::Penalty);
  const bool falls = GENERATE(false, true);
  CAPTURE(method, falls);
  Scene scene = with_ground(0.5, 0.0);
  add(scene, cube({0, 0, falls ? 5.0 : 0.0}), false);
  if (!falls) {
    scene.gravity = Vector3(Vector3::Zero());
    for (int face = 0; face < scene.blocks[1].shape->topology().face_count(); ++face) {
      if (scene.blocks[1].shape->face_normal(face).z() > 0.5)
        scene.face_loads.push_back({1, face, Vector3(0, 0, -1e6)});
    }
    REQUIRE(scene.face_loads.size() == 1);
  }
  Simulation simulation(scene, {.time_step = 1e-2, .analysis = Analysis::Static, .method = method});
  for (int k = 0; k < 10; ++k) {
    REQUIRE(simulation.advance().status == StepStatus::Converged);
    const EnergyLedger& energy = simulation.state().energy;
    const double scale = std::max({energy.work, -energy.potential, 1.0});
    CHECK(std::abs(energy.closure) <= 1e-9 * scale);
    CHECK(energy.algorithmic_loss >= 0.0);
  }
}

TEST_CASE("The ledger of springs closes where velocities are set or the scene is changed") {
  const bool of_joints = GENERATE(true, false), changes = GENERATE(false, true);
  const double turn = GENERATE(0.0, 1.0), friction = GENERATE(0.0, 0.5);
  const int when = GENERATE(5, 6, 7);  // the blocks press and rub from 3 to 8
  CAPTURE(of_joints, changes, turn, friction, when);
  Scene scene;
  scene.gravity = Vector3(Vector3::Zero());
  scene.joint.friction_angle = std::atan(friction);
  StepOptions options{.time_step = 2e-3};
  if (of_joints) {
    scene.joint.normal_stiffness = 1e8;
    scene.joint.shear_stiffness = 5e7;
  } else {
    options.method = ContactMethod::Springs;
    options.penalty = 1e7;
  }
  scene.add_rigid(geometry::make_box({0, 0, 0}, {1, 0.8, 0.5}), kRock);
  scene.add_rigid(geometry::make_box({1.003, 0, 0}, {2.003, 0.8, 0.5}), kRock);
  scene.add_rigid(geometry::make_box({10, 0, 0}, {11, 1, 1}), kRock);
  scene.blocks[0].velocity = Vector3(1, 0.5, 0);
  scene.blocks[0].angular_velocity = Vector3(0, 0, turn);
  scene.blocks[2].kind = BlockKind::Absent;
  Simulation simulation(scene, options);
  for (int step = 0; step < 15; ++step) {
    if (step == when && changes) {
      scene.blocks[2].kind = BlockKind::Rigid;
      simulation.change(scene);
    } else if (step == when) {
      const Vector3 now = simulation.state().blocks[0].velocity;
      simulation.set_velocities(
          std::vector<BlockVelocity>{{0, now + Vector3(0.2, 0.3, 0), Vector3(0, 0, turn)}});
    }
    REQUIRE(simulation.advance().status == StepStatus::Converged);
    const EnergyLedger& energy = simulation.state().energy;
    CHECK(std::abs(energy.closure) <= 1e-6 * energy.mechanical());
  }
}

TEST_CASE("A block that falls flat rebounds to the square of the restitution") {
  for (const bool rigid : {true, false}) {
    for (const double restitution : {0.3, 0.7, 1.0}) {
      Scene scene = with_ground(0.5, restitution);
      add(scene, cube({0, 0, 0.5}), rigid);
      Simulation simulation(scene, {.time_step = 1e-3});
      const double low = simulation.state().blocks[1].centroid.z() - 0.5;
      double highest = 0.0, fastest_down = 0.0;
      for (int i = 0; i < 2000; ++i) {
        REQUIRE(simulation.advance().status == StepStatus::Converged);
        const BlockState& block = simulation.state().blocks[1];
        fastest_down = std::min(fastest_down, block.velocity.z());
        const bool rebounds = fastest_down < -3.0 && block.velocity.z() > 0.0;
        if (rebounds) highest = std::max(highest, block.centroid.z() - low);
        if (rebounds && block.velocity.z() < kGravity * 2e-3) break;  // its first height
      }
      CAPTURE(rigid, restitution);
      CHECK_THAT(highest, WithinRel(0.5 * restitution * restitution, 2e-3));
    }
  }
}

TEST_CASE("An island whose restitution would make energy bounces less, its neighbour does not") {
  // A plate that spins hits with two corners; with friction Newton's restitution would make energy.
  // A cube far away lands flat in the same step.
  const double height = 0.5 * kGravity * 0.3275 * 0.3275;
  const auto speed_after_impact = [&](bool with_plate) {
    Scene scene = with_ground(0.6, 0.9);
    add(scene, cube({-10, 0, height}), true);
    if (with_plate) {
      const int plate = add(scene, geometry::make_box({0, 0, 0.5}, {1, 0.3, 1.0}), true);
      scene.blocks[static_cast<std::size_t>(plate)].angular_velocity =
          Vector3(3.179014, 2.990510, 3.162679);
      scene.blocks[static_cast<std::size_t>(plate)].velocity = Vector3(3.895168, 0, 0);
    }
    Simulation simulation(scene, {.time_step = 5e-3});
    for (int i = 0; i < 66; ++i) REQUIRE(simulation.advance().status == StepStatus::Converged);
    return simulation.state().blocks[1].velocity.z();
  };
  const double alone = speed_after_impact(false);
  CHECK_THAT(alone, WithinRel(0.9 * kGravity * 0.3275 - kGravity * 0.0025, 1e-9));
  CHECK_THAT(speed_after_impact(true), WithinRel(alone, 1e-12));
}
