#include "linear/linear_solver.hpp"

namespace quoin::solver {
namespace {

// Multiplications of the elimination for each block, above which all processes iterate. On walls of
// 10 000 and more bricks (bench/large.md) multigrid then took as long.
constexpr double kWork = 2.2e5;

}  // namespace

bool LinearSolver::is_large(const BlockSystem& system) {
  if (system.frames.empty()) return false;
  if (kind_ != LinearSolverKind::Automatic) return kind_ == LinearSolverKind::Multigrid;
  return elimination_.work(system) / slots_->count() > kWork;
}

bool LinearSolver::factorize(const BlockSystem& system) {
  const bool iterates = distributed_ != nullptr && is_large(system);
  shared_ = iterates || (distributed_ != nullptr && kind_ == LinearSolverKind::Elimination);
  ++(iterates ? counts_.set_ups : counts_.eliminations);
  if (shared_) {
    ++counts_.distributed;
    elimination_.release();
    using enum LinearSolverKind;
    return distributed_->factorize(system, *slots_, iterates ? Multigrid : Elimination);
  }
  return elimination_.factorize(system);
}

bool LinearSolver::solve(const BlockVector& right, BlockVector& solution) {
  if (shared_) return distributed_->solve(right, solution, counts_);
  elimination_.solve(right, solution);
  return true;
}

double LinearSolver::condition_estimate() const {
  return shared_ ? 0.0 : elimination_.condition_estimate();
}

}  // namespace quoin::solver
