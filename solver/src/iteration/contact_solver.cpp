#include "iteration/contact_solver.hpp"

#include <algorithm>

namespace quoin::solver {
namespace {

// Open-close iterations on one problem before it counts as unsolved. All rows of validate are
// solved in 80, all but 6 of the 176 000 problems of `quoin stability --quick` in 400, and five of
// these not at all. With 100 a wall shaken in its plane went over to yielding contacts, and gained
// 2e-3 of its energy, where the open-close iteration solves all.
constexpr int kPatience = 400;
// Attempts in a row that were not solved, a whole and a half step, before the proximal Newton
// method takes over from the whole one: walls near their limit load, which gain energy where
// contacts yield, are solved in half steps.
constexpr int kFailures = 2;
// Sub-steps without another try of the open-close iteration after one that failed. A wall of 105 in
// steps of 5 ms, most of which it does not solve, takes a quarter more solves with it, and twice as
// many without; where the tries succeed, in steps of 2 ms and less, energy grows 4 to 50 times
// less.
constexpr int kNoTries = 20;

}  // namespace

OpenCloseResult ContactSolver::solve(const StepOptions& options, const BlockEquations& blocks,
                                     std::span<LinearContact> contacts, OpenCloseOptions tuning,
                                     BlockVector& increment) {
  tuning.max_iterations = iterations_left_;
  const OpenCloseResult solved = iterate(options, blocks, contacts, tuning, increment);
  iterations_left_ -= solved.iterations;
  return solved;
}

OpenCloseResult ContactSolver::iterate(const StepOptions& options, const BlockEquations& blocks,
                                       std::span<LinearContact> contacts, OpenCloseOptions tuning,
                                       BlockVector& increment) {
  using enum ContactIteration;
  const bool automatic = automatic_ = options.contact_iteration == Automatic;
  const bool asked =
      automatic ? crowd_ && hard_ != Hard::Now : options.contact_iteration == ProximalNewton;
  yielding_ = asked && ConeProblem::suits(contacts);
  if (yielding_) {
    return moving_contacts_.solve(blocks.base, blocks.force, contacts, tuning, increment);
  }
  if (automatic && options.analysis == Analysis::Dynamic) {
    tuning.max_iterations = std::min(kPatience, tuning.max_iterations);
  }
  return open_close_.solve(blocks.base, blocks.force, contacts, tuning, increment);
}

bool ContactSolver::try_hard() {
  if (!automatic_ || hard_ != Hard::Untried || sub_steps_left_ > 0) return false;
  hard_ = Hard::Now;
  return true;
}

bool ContactSolver::leave_hard() {
  if (hard_ != Hard::Now) return false;
  hard_ = Hard::Failed;
  return true;
}

int ContactSolver::crowd() const {
  if (hard_ == Hard::Failed) return 1 + kNoTries;
  const bool crowd = yielding_ || hard_ == Hard::Now;
  return crowd ? 1 + std::max(0, sub_steps_left_ - 1) : 0;
}

void ContactSolver::start(int crowd) {
  crowd_ = crowd > 0 || failures_ == kFailures;
  sub_steps_left_ = std::max(0, crowd - 1);
}

bool ContactSolver::note(bool solved) {
  if (failures_ == kFailures) return false;  // for what is left of the step
  failures_ = solved ? 0 : failures_ + 1;
  return failures_ == kFailures && !yielding_;
}

}  // namespace quoin::solver
