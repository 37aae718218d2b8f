#include "linear/linear_solver.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "base/index.hpp"
#include "distributed/gathered_contacts.hpp"

namespace quoin::solver {
namespace {

// Multiplications of the elimination for each block, above which multigrid is taken. On the
// matrices of bench/large.md it takes, with its set-up shared by five, as long as 2.2e5 of them
// where all joints are closed, 3.8e5 where 30 % are weak.
constexpr double kWork = 2.2e5;

// More iterations than with a new hierarchy cost as much as another set-up: it is made for the next
// matrix.
constexpr int kLag = 6;

// Multiplications of an elimination, for each block, that take as long as one iteration, for each
// unit of complexity: 8.5e3 to 1.1e4 on the walls of 10 083 bricks of bench/large.md.
constexpr double kIteration = 9e3;

// A set-up takes as long as so many iterations, there and at any share of weak joints.
constexpr int kSetUp = 13;

// Eliminations that iterations may take longer in all than those that they save, at most, and what
// a matrix that is eliminated adds to that: so they are tried again.
constexpr double kCredit = 1.0, kRetry = 0.05;

}  // namespace

void LinearSolver::forget() {
  prepared_ = false;
  credit_ = kCredit;
}

bool LinearSolver::wants_multigrid(const BlockSystem& system) {
  if (system.frames.empty()) return false;
  if (kind_ != LinearSolverKind::Automatic) return kind_ == LinearSolverKind::Multigrid;
  work_ = elimination_.work(system) / slots_->count();
  return work_ > kWork;
}

/// Where iterations have taken longer the matrix is eliminated.
bool LinearSolver::iterates(const BlockSystem& system) {
  if (!wants_multigrid(system)) return false;
  if (kind_ != LinearSolverKind::Automatic || credit_ >= 1.0) return true;
  credit_ += kRetry;
  return false;
}

bool LinearSolver::distributes(const BlockSystem& system) {
  if (distributed_ == nullptr) return false;
  return kind_ == LinearSolverKind::Elimination || wants_multigrid(system);
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

template <int n>
bool LinearSolver::prepare(RigidMultigrid<n>& multigrid) {
  lagging_ = prepared_ = false;
  prepared_ = multigrid.set_up(frames_, watch_);
  fresh_iterations_ = 0;
  ++counts_.set_ups;
  pay(kSetUp, multigrid.complexity());
  counts_.complexity = std::max(counts_.complexity, multigrid.complexity());
  return prepared_;
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
    iterates_ = wants_multigrid(pattern);
    ++counts_.distributed;
    ++(iterates_ ? counts_.set_ups : counts_.eliminations);
    release_values();
    using enum LinearSolverKind;
    return distributed_->factorize(system, *slots_, iterates_ ? Multigrid : Elimination);
  }
  if (gathers) gather_blocks(system);
  return factorize_here(pattern, only);
}

/// By this process alone.
bool LinearSolver::factorize_here(const BlockSystem& system, const BlockVector* only) {
  once_ = only != nullptr && !system.symmetric;
  iterates_ = iterates(system);
  if (!iterates_) {
    ++counts_.eliminations;
    release_multigrid();
    return eliminate(system, only);
  }
  elimination_.release();
  has_multigrid_ = saves_ = true;
  frames_ = system.frames;
  const auto take = [&](auto& iterations, auto rows) {
    auto& multigrid = iterations.multigrid;
    multigrid.use(threads_);
    if (!multigrid.exchange(std::move(rows))) return false;
    lagging_ = prepared_;
    return prepared_ || prepare(multigrid);
  };
  return slots_->rigid() ? take(rigid_, block_rows<6>(threads_, system, *slots_))
                         : take(deformable_, block_rows<12>(threads_, system, *slots_));
}

/// What this process alone keeps of a matrix that all of them solve.
void LinearSolver::release_values() {
  elimination_.release();
  release_multigrid();
  whole_.diagonal = {};
  whole_.off_diagonal = {};
  whole_.mirrored = {};
}

void LinearSolver::release_multigrid() {
  if (!has_multigrid_) return;
  rigid_ = {};
  deformable_ = {};
  has_multigrid_ = prepared_ = false;
}

/// As many as take the time of an elimination.
int LinearSolver::most_iterations(double complexity) const {
  constexpr int most = KrylovOptions{}.most;
  if (kind_ != LinearSolverKind::Automatic) return most;
  return std::clamp(static_cast<int>(work_ / (kIteration * complexity)), 1, most);
}

/// For iterations, in eliminations.
void LinearSolver::pay(int iterations, double complexity) {
  if (kind_ == LinearSolverKind::Automatic) credit_ -= iterations * kIteration * complexity / work_;
}

/// A hierarchy of an earlier matrix is tried first, then, where elimination takes longer than all
/// iterations, one of this matrix.
template <int n>
bool LinearSolver::iterate(Iterations<n>& with, const BlockVector& right, BlockVector& solution) {
  RigidMultigrid<n>& multigrid = with.multigrid;
  Blocks<n>&from = with.right, &to = with.solution;
  from.resize(right.size());
  to.resize(right.size());
  for (std::size_t s = 0; s < right.size(); ++s) from[s] = right[s].template head<n>();
  for (;;) {
    const int most = most_iterations(multigrid.complexity());
    const KrylovOptions options{.most = most, .watch = watch_};
    const KrylovResult result = with.krylov.solve(multigrid, from, options, to);
    counts_.iterations += result.iterations;
    if (fresh_iterations_ == 0) fresh_iterations_ = result.iterations;
    if (result.iterations > fresh_iterations_ + kLag) prepared_ = false;
    pay(result.iterations, multigrid.complexity());
    if (result.converged) break;
    if (!lagging_ || most < KrylovOptions{}.most || !prepare(multigrid)) {
      ++counts_.fallbacks;
      iterates_ = false;
      const BlockSystem system = block_system(multigrid.matrix());
      release_multigrid();
      return eliminate(system, once_ ? &right : nullptr) && solve(right, solution);
    }
  }
  if (std::exchange(saves_, false)) credit_ = std::min(kCredit, credit_ + 1.0);
  for (std::size_t s = 0; s < right.size(); ++s) {
    solution[s].setZero();
    const int size = slots_->size[s];
    solution[s].head(size) = to[s].head(size);
  }
  return true;
}

bool LinearSolver::solve(const BlockVector& right, BlockVector& solution) {
  if (shared_) return distributed_->solve(right, solution, counts_);
  if (iterates_) {
    return slots_->rigid() ? iterate(rigid_, right, solution)
                           : iterate(deformable_, right, solution);
  }
  elimination_.solve(right, solution);
  return true;
}

double LinearSolver::condition_estimate() const {
  return iterates_ || shared_ ? 0.0 : elimination_.condition_estimate();
}

}  // namespace quoin::solver
