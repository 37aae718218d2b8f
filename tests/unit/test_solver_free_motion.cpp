/// Crowds that no contact has to push: gravity is switched off, or their support goes.

#include "solver/src/iteration/free_motion.hpp"

#include <array>
#include <cmath>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>

#include "solver/src/iteration/open_close.hpp"
#include "support/catch.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

constexpr double kG = 9.81;  // m/s2

/// Three courses of bricks on the ground, no two of one density.
Scene pyramid() {
  constexpr std::array<double, 6> kDensities{118, 146, 129, 152, 154, 105};  // kg/m3
  Scene scene{.joint = {.friction_angle = std::atan(0.6)}};
  scene.add_fixed(geometry::make_box({-10, -10, -1}, {10, 10, 0}));
  std::size_t brick = 0;
  for (int row = 0; row < 3; ++row) {
    for (int i = 0; i < 3 - row; ++i, ++brick) {
      const Vector3 low(0.8 * i + 0.4 * row, 0.0, 0.25 * row);
      scene.add_rigid(geometry::make_box(low, low + Vector3(0.8, 0.8, 0.25)),
                      {.density = kDensities[brick]});
    }
  }
  return scene;
}

/// All blocks and gravity about an axis through the origin, and away from there.
Scene turned(Scene scene, double angle, const Vector3& away) {
  const Matrix3 turn = Eigen::AngleAxisd(angle, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  for (Block& block : scene.blocks) {
    block.placement.linear = turn * block.placement.linear;
    block.placement.translation = turn * block.placement.translation + away;
  }
  scene.gravity = Vector3(turn * scene.gravity.at(0.0));
  return scene;
}

Simulation settled(const Scene& scene, StepOptions options) {
  options.analysis = Analysis::Static;
  Simulation simulation(scene, options);
  REQUIRE(simulation.advance().status == StepStatus::Converged);
  options.analysis = Analysis::Dynamic;
  simulation.set_options(options);
  return simulation;
}

/// Without a flag. Returns what was solved.
int run(Simulation& simulation, int steps) {
  int solves = 0;
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    REQUIRE(report.flags.empty());
    solves += report.linear_solves;
  }
  return solves;
}

double largest_speed(const State& state) {
  double largest = 0.0;
  for (const BlockState& block : state.blocks) largest = std::max(largest, block.velocity.norm());
  return largest;
}

}  // namespace

// Without is_unforced() steps of 20 ms do not converge.
TEST_CASE("Bricks at rest stay where they are when gravity is switched off") {
  for (const double dt : {1e-3, 2e-2}) {
    for (const double tolerance : {1e-8, 1e-12}) {
      for (const double away : {0.0, 1e4}) {
        CAPTURE(dt, tolerance, away);
        Scene scene = turned(pyramid(), away > 0.0 ? 0.7 : 0.0, {away, -2 * away, 3 * away});
        Simulation simulation = settled(scene, {.time_step = dt, .tolerance = tolerance});
        scene.gravity = Vector3(0, 0, 0);
        simulation.change(scene);
        CHECK(run(simulation, 10) == 0);
        CHECK(largest_speed(simulation.state()) == 0.0);
      }
    }
  }
}

// A ramp's last step was flagged for energy: what gaps leave was judged by gravity at its end,
// zero.
TEST_CASE("Bricks at rest stay where they are while gravity fades, and afterwards") {
  constexpr double kEnd = 0.1;  // s
  Scene scene = pyramid();
  scene.gravity = VectorOfTime(
      [](double time) { return Vector3(0, 0, -kG * std::max(0.0, 1.0 - time / kEnd)); });
  Simulation simulation = settled(scene, {.time_step = 2e-2});
  run(simulation, 10);
  CHECK(largest_speed(simulation.state()) < 1e-12);
}

// Without is_unforced() bricks part by more than rounding.
TEST_CASE("A pile whose ground is taken away falls as one, however densities differ") {
  for (const ContactIteration iteration :
       {ContactIteration::Automatic, ContactIteration::ProximalNewton}) {
    Scene scene = pyramid();
    scene.blocks[1].material.density *= 100.0;
    scene.blocks[4].material.density *= 30.0;
    Simulation simulation = settled(scene, {.time_step = 5e-3, .contact_iteration = iteration});
    const std::vector<BlockState> before = simulation.state().blocks;
    scene.blocks[0].kind = BlockKind::Absent;
    simulation.change(scene);
    CHECK(run(simulation, 40) == 0);
    const double fallen = 0.5 * kG * 0.2 * 0.2;
    for (std::size_t b = 1; b < before.size(); ++b) {
      const Vector3 moved = simulation.state().blocks[b].centroid - before[b].centroid;
      CHECK((moved + Vector3(0, 0, fallen)).norm() < 1e-14);
    }
  }
}

namespace {

/// A block of 2 kg over fixed ground, dt 1 s: K = 2 m/dt2. It moves by x, and its contact by that
/// along the normal.
struct OneContact {
  Slots slots = make_slots({6}, {1.0});
  BlockSystem base;
  SquareBlocks compliance;
  BlockVector force{Vector12::Zero()}, coasting{Vector12::Zero()}, increment{Vector12::Zero()};
  std::vector<LinearContact> contacts{1};
  FreeMotion free{compliance, coasting};

  OneContact() {
    base.diagonal.resize(1, 6);
    base.diagonal[0] = 4.0 * Eigen::MatrixXd::Identity(6, 6);
    compliance.resize(1, 6);
    compliance[0] = 0.25 * Eigen::MatrixXd::Identity(6, 6);
    LinearContact& c = contacts[0];
    c.slot_b = 0;
    c.jacobian_b.rigid(0, 0) = c.jacobian_b.rigid(1, 1) = c.jacobian_b.rigid(2, 2) = 1.0;
    c.rounding = 1e-16;
    c.normal_stiffness = c.shear_stiffness = 1e6;
  }
  /// `push`: of loads on the block along the normal, N.
  void set(double gap, double velocity, double push) {
    contacts[0].start[0] = contacts[0].offset[0] = gap;
    coasting[0][0] = velocity;
    force[0][0] = 4.0 * velocity + push;
  }
  bool unforced() const { return is_unforced(free, force, contacts, 1e-10); }
};

}  // namespace

TEST_CASE("A contact has nothing to do where it opens, or lies still and is not pressed") {
  OneContact one;
  one.set(0.0, 0.0, 0.0);
  CHECK(one.unforced());
  one.set(0.0, 0.0, 1.0);
  CHECK(one.unforced());
  one.set(0.0, 0.0, -1e-200);  // pressed, however little
  CHECK_FALSE(one.unforced());
  one.set(1e-3, 0.0, -1e-3);  // not yet closed
  CHECK(one.unforced());
  one.set(0.0, -1e-17, 0.0);  // rounding of the gap
  CHECK(one.unforced());
  one.set(0.0, -1e-15, 0.0);
  CHECK_FALSE(one.unforced());
  one.set(-5e-11, 0.0, 0.0);  // an overlap within the limit
  CHECK(one.unforced());
  one.set(-2e-10, 0.0, 0.0);
  CHECK_FALSE(one.unforced());
}

TEST_CASE("Bonded contacts have something to do where they would open, springs always") {
  OneContact one;
  one.contacts[0].bonded = true;
  one.set(0.0, 0.0, 0.0);
  CHECK(one.unforced());
  one.set(0.0, 0.0, 1.0);
  CHECK_FALSE(one.unforced());
  one.contacts[0].bonded = false;
  one.contacts[0].compliant = true;
  CHECK_FALSE(one.unforced());
}

TEST_CASE("What contacts bore stays where it holds the blocks") {
  OneContact one;
  OpenClose iteration(one.slots);
  const OpenCloseOptions options{.gap_tolerance = 1e-10, .free = &one.free};
  const BlockEquations blocks{one.base, one.force};
  LinearContact opposite = one.contacts[0];  // a block wedged in, with no load
  opposite.jacobian_b.rigid *= -1.0;
  one.contacts.push_back(opposite);
  for (LinearContact& c : one.contacts) c.multiplier[0] = 5.0;
  CHECK_FALSE(iteration.fly(blocks, one.contacts, options, 1e-10, one.increment));
  one.contacts[1].multiplier[0] = 4.0;
  CHECK(iteration.fly(blocks, one.contacts, options, 1e-10, one.increment));
  CHECK(one.contacts[0].force.isZero(0.0));
  CHECK(one.increment[0].isZero(0.0));
}

// A wall that had stopped took up to 250 solves a step, for ever.
TEST_CASE("What the last forces hold stays, with the gaps that they left within the tolerance") {
  constexpr double kTolerance = 1e-10;  // m
  const auto iterations = [](double gap, double moved, double bore) {
    OneContact one;
    one.set(gap, 0.0, -5.0);
    one.contacts[0].offset[0] += moved;
    one.contacts[0].multiplier[0] = bore;
    OpenClose iteration(one.slots);
    const OpenCloseOptions options{
        .gap_tolerance = kTolerance, .predicted = true, .free = &one.free};
    const OpenCloseResult result =
        iteration.solve(one.base, one.force, one.contacts, options, one.increment);
    CHECK(result.converged);
    CHECK(std::abs(one.contacts[0].force[0] - 5.0) < 1e-6);
    return result.iterations;
  };
  CHECK(iterations(0.0, 0.0, 5.0) == 0);
  CHECK(iterations(-5.0 * kTolerance, 0.0, 5.0) == 0);
  CHECK(iterations(-20.0 * kTolerance, 0.0, 5.0) > 0);
  CHECK(iterations(0.0, -kTolerance, 5.0) > 0);  // a support that moves
  CHECK(iterations(0.0, 0.0, 4.0) > 0);          // loads have changed
}
