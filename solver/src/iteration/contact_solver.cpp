#include "iteration/contact_solver.hpp"

#include <algorithm>

namespace quoin::solver {
namespace {

// Open-close iterations before the proximal Newton method takes over. On small scenes like those of
// bench/moving.md 15 took an arch and a tower eight times the factorizations, as it came in where
// it was not needed; with 80 a rocking wall took 1.4 times as many.
constexpr int kPatience = 40;

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
                                       std::span<LinearContact> contacts,
                                       const OpenCloseOptions& tuning, BlockVector& increment) {
  const BlockSystem& base = blocks.base;
  const BlockVector& force = blocks.force;
  const bool open_close =
      options.contact_iteration == ContactIteration::OpenClose || !ConeProblem::suits(contacts);
  if (open_close) return open_close_.solve(base, force, contacts, tuning, increment);
  OpenCloseResult total;
  if (options.contact_iteration == ContactIteration::Automatic && !yielding_) {
    const std::vector<LinearContact> start(contacts.begin(), contacts.end());
    const BlockVector guess = increment;
    OpenCloseOptions first = tuning;
    first.max_iterations = std::min(kPatience, tuning.max_iterations);
    total = open_close_.solve(base, force, contacts, first, increment);
    if (total.converged) return total;
    std::ranges::copy(start, contacts.begin());
    increment = guess;
  }
  yielding_ = true;
  OpenCloseOptions rest = tuning;
  rest.max_iterations -= total.iterations;
  add(moving_contacts_.solve(base, force, contacts, rest, increment), total);
  return total;
}

}  // namespace quoin::solver
