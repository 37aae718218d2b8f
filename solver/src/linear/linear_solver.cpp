#include "linear/linear_solver.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "base/index.hpp"
#include "distributed/gathered_contacts.hpp"

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

bool LinearSolver::distributes(const BlockSystem& system) {
  if (distributed_ == nullptr) return false;
  return kind_ == LinearSolverKind::Elimination || is_large(system);
}

/// The pattern of the matrix of all processes, and what they have alike.
void LinearSolver::gather_pairs(const BlockSystem& own) {
  whole_.symmetric = own.symmetric;
  whole_.frames = own.frames;
  whole_.pairs = gather(agreement_, *slots_, own.pairs);
}

/// And its values.
void LinearSolver::gather_blocks(const BlockSystem& own) {
  whole_.diagonal = own.diagonal;
  agreement_.complete(*slots_, whole_.diagonal.area(), whole_.diagonal.values());
  const auto gather = [&](const SquareBlocks& from, SquareBlocks& to) {
    std::vector<double> mine;
    std::vector<std::pair<int, int>> pairs;
    for (std::size_t p = 0; p < from.size(); ++p) {
      const auto& [a, b] = own.pairs[p];
      if (!agreement_.counts(*slots_, a, b)) continue;
      pairs.push_back(own.pairs[p]);
      mine.insert(mine.end(), from[p].data(), from[p].data() + from.area());
    }
    pairs = agreement_.of_all(pairs);
    mine = agreement_.of_all(mine);
    to.resize(pairs.size(), whole_.diagonal.width());
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const auto at = std::ranges::lower_bound(whole_.pairs, pairs[i]) - whole_.pairs.begin();
      std::copy_n(mine.data() + i * to.area(), to.area(), to[static_cast<std::size_t>(at)].data());
    }
  };
  gather(own.off_diagonal, whole_.off_diagonal);
  gather(own.mirrored, whole_.mirrored);
}

bool LinearSolver::eliminate(const BlockSystem& system, const BlockVector* only) {
  return only != nullptr ? elimination_.factorize(system, *only) : elimination_.factorize(system);
}

bool LinearSolver::factorize(const BlockSystem& system, const BlockVector* only) {
  const bool gathers = agreement_.shares() && kind_ != LinearSolverKind::Elimination;
  if (gathers) gather_pairs(system);
  const BlockSystem& pattern = gathers ? whole_ : system;
  shared_ = distributes(pattern);
  if (shared_) {
    const bool iterates = is_large(pattern);
    ++counts_.distributed;
    ++(iterates ? counts_.set_ups : counts_.eliminations);
    release_values();
    using enum LinearSolverKind;
    return distributed_->factorize(system, *slots_, iterates ? Multigrid : Elimination);
  }
  if (gathers) gather_blocks(system);
  ++counts_.eliminations;
  return eliminate(pattern, only);
}

/// What this process alone keeps of a matrix that all of them solve.
void LinearSolver::release_values() {
  elimination_.release();
  whole_.diagonal = {};
  whole_.off_diagonal = {};
  whole_.mirrored = {};
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
