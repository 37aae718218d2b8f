/// What no contact has to push. Scenes of it are cases gravity_off, gravity_fades and ground_gone.

#include "solver/src/iteration/open_close.hpp"

#include <cmath>

#include "solver/src/iteration/open_close.hpp"
#include "support/catch.hpp"

using namespace quoin::solver;
using namespace quoin::tests;

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
