/// Which iteration has an attempt, and what the proximal Newton method mends of gaps.

#include "solver/src/iteration/contact_solver.hpp"
#include "solver/src/iteration/interior_point.hpp"
#include "support/catch.hpp"

using namespace quoin::solver;

namespace {

/// Unit masses that weigh 1 N, each on a point of the ground below its centre.
struct Resting {
  Slots slots;
  BlockSystem base;
  BlockVector force, increment;
  std::vector<LinearContact> contacts;

  /// `gaps`: of each at the start, m.
  explicit Resting(const std::vector<double>& gaps)
      : slots(make_slots(std::vector<int>(gaps.size(), 6), std::vector<double>(gaps.size(), 1.0))) {
    base.diagonal.resize(gaps.size(), 6);
    for (std::size_t i = 0; i < gaps.size(); ++i) {
      base.diagonal[i] = Eigen::MatrixXd::Identity(6, 6);
      force.push_back(-Vector12::Unit(2));
      increment.push_back(Vector12::Zero());
      LinearContact& c = contacts.emplace_back();
      c.slot_b = static_cast<int>(i);
      c.jacobian_b.rigid.leftCols<3>() << 0, 0, 1, 1, 0, 0, 0, 1, 0;
      c.friction = 0.5;
      c.start = c.offset = {gaps[i], 0, 0};
      c.multiplier = {1, 0, 0};
      c.assumed = ContactMode::Stick;
      c.normal_stiffness = c.shear_stiffness = 1.0;
    }
    set_pairs(contacts, base);
  }

  OpenCloseResult solve(ContactIteration iteration, ContactSolver& solver) {
    StepOptions options;
    options.contact_iteration = iteration;
    OpenCloseOptions tuning;
    tuning.mended_apart = 1e-6;
    tuning.predicted = true;
    solver.allow(1000);
    return solver.solve(options, {base, force}, contacts, tuning, increment);
  }
};

}  // namespace

TEST_CASE("the interior point method finds what stands, slides and leaves the ground") {
  Resting blocks({0.0, 0.0, 0.0, 2.0});  // m; free ones would fall by 1 m
  blocks.force[1][0] = 3.0;              // friction of 0.5 N holds less
  blocks.force[2][0] = 0.3;
  InteriorPoint interior_point(blocks.slots);
  const OpenCloseResult result =
      interior_point.solve(blocks.base, blocks.force, blocks.contacts, 100, blocks.increment);
  REQUIRE(result.converged);
  REQUIRE(result.residual <= 1e-5);
  REQUIRE(result.iterations <= 30);
  const auto differs = [&](std::size_t i, const Vector3& force, double along, double up) {
    const Vector12& moved = blocks.increment[i];
    return (blocks.contacts[i].force - force).norm() + std::abs(moved[0] - along) +
           std::abs(moved[2] - up);
  };
  CHECK(differs(0, {1.0, 0.0, 0.0}, 0.0, 0.0) <= 1e-4);
  CHECK(differs(1, {1.0, -0.5, 0.0}, 2.5, 0.0) <= 1e-4);
  CHECK(differs(2, {1.0, -0.3, 0.0}, 0.0, 0.0) <= 1e-4);
  CHECK(differs(3, {0.0, 0.0, 0.0}, 0.0, -1.0) <= 1e-4);
}

TEST_CASE("an overlap beyond the limit is mended alone, not by a share of all") {
  Resting blocks({-3e-6, -0.9e-6});  // the limit: a millionth of a block
  ContactSolver solver(blocks.slots, nullptr);
  REQUIRE(blocks.solve(ContactIteration::ProximalNewton, solver).converged);
  CHECK(std::abs(blocks.increment[0][2] - 2e-6) <= 1e-7);
  CHECK(std::abs(blocks.increment[1][2]) <= 1e-9);  // by a share of all gaps 6e-7
}

TEST_CASE("of what contacts push another iteration's answer is taken where it gains nothing") {
  Resting blocks({0.0});
  ContactSolver solver(blocks.slots, nullptr);
  const auto attempt = [&](AttemptOutcome outcome) {
    solver.start(0);
    outcome.solved = blocks.solve(ContactIteration::Automatic, solver).converged;
    return solver.judge(outcome);
  };
  const auto gains = [](double gained, double contact_work) {
    return AttemptOutcome{.gains = gained, .allowed = 1.0, .contact_work = contact_work};
  };
  solver.begin();
  REQUIRE(attempt(gains(2.0, 0.0)) == Fate::End);  // of a block that spins free
  REQUIRE_FALSE(solver.yielding());
  solver.move_on();
  REQUIRE(attempt(gains(3.0, 3.0)) == Fate::Again);
  REQUIRE(attempt(gains(0.5, 0.5)) == Fate::End);
  REQUIRE(solver.yielding());
  solver.move_on();
  REQUIRE(attempt(gains(3.0, 3.0)) == Fate::Again);
  REQUIRE(attempt(gains(4.0, 4.0)) == Fate::Again);
  REQUIRE(attempt(gains(3.0, 3.0)) == Fate::End);
  REQUIRE_FALSE(solver.yielding());
}

TEST_CASE("a crowd's sub-step that gains energy is halved") {
  Resting blocks({0.0});
  ContactSolver solver(blocks.slots, nullptr);
  const auto attempt = [&](double gained, bool can_cut) {
    solver.start(2);  // the sub-step before was the proximal Newton method's
    const bool solved = blocks.solve(ContactIteration::Automatic, solver).converged;
    REQUIRE(solver.yielding());
    return solver.judge({.solved = solved, .can_cut = can_cut, .gains = gained, .allowed = 1.0});
  };
  solver.begin();
  REQUIRE(attempt(5.0, true) == Fate::Halved);
  REQUIRE(attempt(0.5, true) == Fate::End);
  REQUIRE(attempt(5.0, false) == Fate::End);
  REQUIRE(solver.crowd() == 2);
}

TEST_CASE("a crowd is one for good after two steps in a row that open-close has not solved") {
  Resting blocks({0.0});
  ContactSolver solver(blocks.slots, nullptr);
  int crowd = 0;
  const auto step = [&](bool open_close_fails) {
    solver.begin();
    solver.start(crowd);
    const auto attempt = [&](double gained) {
      const bool solved = blocks.solve(ContactIteration::Automatic, solver).converged;
      return solver.judge({.solved = solved, .gains = gained, .contact_work = gained});
    };
    if (attempt(open_close_fails ? 5.0 : 0.0) == Fate::Again) {
      solver.start(crowd);
      REQUIRE(attempt(0.0) == Fate::End);
    }
    crowd = solver.crowd();
    return solver.yielding();
  };
  REQUIRE(step(true));
  REQUIRE_FALSE(step(false));
  REQUIRE(step(true));
  REQUIRE_FALSE(step(false));
  REQUIRE(step(true));
  REQUIRE(step(true));
  REQUIRE(step(false));
}
