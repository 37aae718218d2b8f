#include "linear/rigid_multigrid.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/index.hpp"

namespace quoin::solver {
namespace {

template <int n>
using Square = Eigen::Matrix<double, n, n>;

constexpr int kCoarsest = 100;       // rows: elimination is then cheaper than another level
constexpr double kStalled = 0.7;     // of the rows are left: another level would not pay
constexpr int kPowerSteps = 8;       // of the estimate of a largest eigenvalue,
constexpr double kPowerShare = 0.9;  // which they reach to that share

BlockRows<6, 6> rigid_part(const BlockRows<6, 6>& matrix) { return matrix; }

BlockRows<6, 6> rigid_part(const BlockRows<12, 12>& matrix) {
  BlockRows<6, 6> result{matrix.columns, matrix.start, matrix.column, {}};
  for (const Square<12>& block : matrix.value) {
    result.value.push_back(block.topLeftCorner<6, 6>());
  }
  return result;
}

/// What a block does when its group moves as a rigid body, `arm` away from the group's own place.
template <int n>
Eigen::Matrix<double, n, 6> rigid_motion(const Vector3& arm, const Matrix3& rotation) {
  Eigen::Matrix<double, n, 6> motion = Eigen::Matrix<double, n, 6>::Zero();
  motion.template topLeftCorner<3, 3>().setIdentity();
  motion.template topRightCorner<3, 3>() = -cross_matrix(arm);
  motion.template block<3, 3>(3, 3) = rotation.transpose();
  return motion;
}

std::vector<Frame> group_frames(const Aggregates& groups, std::span<const Frame> frames) {
  std::vector<Frame> result(index(groups.count));
  std::vector<int> members(result.size(), 0);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (groups.of[i] < 0) continue;
    result[index(groups.of[i])].place += frames[i].place;
    ++members[index(groups.of[i])];
  }
  for (std::size_t g = 0; g < result.size(); ++g) result[g].place /= members[g];
  return result;
}

/// Largest eigenvalue of D^-1 A, about.
template <int n>
double largest_eigenvalue(const Threads& threads, MultigridLevel<n>& level) {
  const GaussSeidel<n>& smoother = level.smoother;
  double estimate = 1.0;
  for (std::size_t i = 0; i < level.solution.size(); ++i) {
    for (int k = 0; k < n; ++k) {  // no direction of the matrix is special to this one
      level.solution[i][k] = std::sin(1.0 + 7.0 * static_cast<double>(i) + 3.0 * k);
    }
  }
  for (int step = 0; step < kPowerSteps; ++step) {
    threads.each(smoother.rows(), [&](std::size_t i) {
      level.residual[i] =
          smoother.inverse()[i] * smoother.matrix().times(static_cast<int>(i), level.solution);
    });
    double before = 0.0, after = 0.0;
    for (std::size_t i = 0; i < level.residual.size(); ++i) {
      before += level.solution[i].squaredNorm();
      after += level.residual[i].squaredNorm();
    }
    estimate = std::sqrt(after / before);
    for (std::size_t i = 0; i < level.residual.size(); ++i) {
      level.solution[i] = level.residual[i] / std::sqrt(after);
    }
  }
  return estimate / kPowerShare;
}

/// (I - 4/3 D^-1 A / largest eigenvalue) T, T the rigid motions of the groups.
template <int n>
void set_transfer(const Threads& threads, const Aggregates& groups, std::span<const Frame> frames,
                  std::span<const Frame> coarse, StepWatch* watch, MultigridLevel<n>& level) {
  BlockRows<n, 6> rigid;
  rigid.columns = groups.count;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const int group = groups.of[i];
    if (group >= 0) {
      const Vector3 arm = frames[i].place - coarse[index(group)].place;
      rigid.push_back(group, rigid_motion<n>(arm, frames[i].rotation));
    }
    rigid.end_row();
  }
  const double share = 4.0 / 3.0 / largest_eigenvalue(threads, level);
  level.prolongation = product(threads, level.smoother.matrix(), rigid, watch);
  BlockRows<n, 6>& smooth = level.prolongation;
  threads.each(frames.size(), [&](std::size_t i) {
    for (std::size_t k = index(smooth.start[i]); k < index(smooth.start[i + 1]); ++k) {
      smooth.value[k] = (-share * level.smoother.inverse()[i] * smooth.value[k]).eval();
      if (smooth.column[k] == groups.of[i]) smooth.value[k] += rigid.value[index(rigid.start[i])];
    }
  });
  level.restriction = transposed(smooth);
}

template <int r, int c>
void multiply(const Threads& threads, const BlockRows<r, c>& matrix, const Blocks<c>& x,
              Blocks<r>& result) {
  threads.each(result.size(),
               [&](std::size_t i) { result[i] = matrix.times(static_cast<int>(i), x); });
}

template <int n>
void add_correction(const Threads& threads, const BlockRows<n, 6>& prolongation,
                    const Blocks<6>& coarse, Blocks<n>& solution) {
  threads.each(solution.size(), [&](std::size_t i) {
    solution[i] += prolongation.times(static_cast<int>(i), coarse);
  });
}

/// The next coarser level, where there is one that pays; frames become its own.
template <int n>
bool coarsen(const Threads& threads, StepWatch* watch, MultigridLevel<n>& level,
             std::vector<Frame>& frames, BlockRows<6, 6>& coarse) {
  const BlockRows<n, n>& matrix = level.smoother.matrix();
  if (matrix.rows() <= kCoarsest) return false;
  const Aggregates groups = aggregate(rigid_part(matrix));
  if (groups.count == 0 || groups.count > kStalled * matrix.rows()) return false;
  std::vector<Frame> coarse_frames = group_frames(groups, frames);
  set_transfer(threads, groups, frames, coarse_frames, watch, level);
  const BlockRows<n, 6> moved = product(threads, matrix, level.prolongation, watch);
  coarse = product(threads, level.restriction, moved, watch);
  frames = std::move(coarse_frames);
  return true;
}

}  // namespace

namespace {

/// An entry of a row: which block of the system, and whether its transpose.
struct Source {
  const SquareBlocks* blocks;
  std::size_t block;
  bool transposed;
};

/// Where the system has entries: of each row its own first, then in the order of the pairs.
template <int n>
BlockRows<n, n> pattern(const BlockSystem& system, const std::vector<char>& coupled,
                        std::vector<Source>& sources) {
  BlockRows<n, n> rows;
  const std::size_t count = system.diagonal.size();
  rows.columns = static_cast<int>(count);
  rows.start.assign(count + 1, 0);
  for (std::size_t i = 0; i < count; ++i) ++rows.start[i + 1];
  for (std::size_t p = 0; p < coupled.size(); ++p) {
    rows.start[index(system.pairs[p].first) + 1] += coupled[p];
    rows.start[index(system.pairs[p].second) + 1] += coupled[p];
  }
  std::partial_sum(rows.start.begin(), rows.start.end(), rows.start.begin());
  rows.column.resize(index(rows.start.back()));
  rows.value.resize(rows.column.size());
  sources.resize(rows.column.size());
  std::vector<int> next(rows.start.begin(), rows.start.end() - 1);
  const auto put = [&](int row, int column, Source source) {
    const std::size_t at = index(next[index(row)]++);
    rows.column[at] = column;
    sources[at] = source;
  };
  for (int i = 0; i < rows.columns; ++i) put(i, i, {&system.diagonal, index(i), false});
  for (std::size_t p = 0; p < coupled.size(); ++p) {
    if (!coupled[p]) continue;
    const auto [i, j] = system.pairs[p];
    put(i, j, {&system.off_diagonal, p, false});
    put(j, i, {system.symmetric ? &system.off_diagonal : &system.mirrored, p, system.symmetric});
  }
  return rows;
}

}  // namespace

template <int n>
BlockRows<n, n> block_rows(const Threads& threads, const BlockSystem& system, const Slots& slots) {
  std::vector<char> coupled(system.pairs.size());
  threads.each(coupled.size(), [&](std::size_t p) {
    const bool none =
        system.off_diagonal[p].isZero(0.0) && (system.symmetric || system.mirrored[p].isZero(0.0));
    coupled[p] = none ? 0 : 1;
  });
  std::vector<Source> sources;
  BlockRows<n, n> rows = pattern<n>(system, coupled, sources);
  threads.each(index(rows.columns), [&](std::size_t i) {
    for (std::size_t k = index(rows.start[i]); k < index(rows.start[i + 1]); ++k) {
      Square<n>& block = rows.value[k];
      block = sources[k].blocks->template part<n>(sources[k].block);
      if (sources[k].transposed) block.transposeInPlace();
      const int size = slots.size[i], width = slots.size[index(rows.column[k])];
      if (size < n) block.bottomRows(n - size).setZero();
      if (width < n) block.rightCols(n - width).setZero();
      if (rows.column[k] != static_cast<int>(i)) continue;
      for (int d = size; d < n; ++d) block(d, d) = 1.0;
    }
  });
  return rows;
}

template BlockRows<6, 6> block_rows<6>(const Threads&, const BlockSystem&, const Slots&);
template BlockRows<12, 12> block_rows<12>(const Threads&, const BlockSystem&, const Slots&);

template <int n>
BlockSystem block_system(const BlockRows<n, n>& matrix) {
  BlockSystem system;
  system.symmetric = false;
  const std::size_t rows = index(matrix.rows());
  system.diagonal.resize(rows, n);
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t k = index(matrix.start[i]); k < index(matrix.start[i + 1]); ++k) {
      const int j = matrix.column[k];
      if (j == static_cast<int>(i)) system.diagonal[i] = matrix.value[k];
      if (j > static_cast<int>(i)) system.pairs.emplace_back(static_cast<int>(i), j);
    }
  }
  std::ranges::sort(system.pairs);
  system.off_diagonal.resize(system.pairs.size(), n);
  system.mirrored = system.off_diagonal;
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t k = index(matrix.start[i]); k < index(matrix.start[i + 1]); ++k) {
      const int row = static_cast<int>(i), j = matrix.column[k];
      if (j == row) continue;
      const std::pair<int, int> pair = std::minmax(row, j);
      const auto at = std::ranges::lower_bound(system.pairs, pair) - system.pairs.begin();
      SquareBlocks& side = row < j ? system.off_diagonal : system.mirrored;
      side[static_cast<std::size_t>(at)] = matrix.value[k];
    }
  }
  return system;
}

template BlockSystem block_system(const BlockRows<6, 6>&);
template BlockSystem block_system(const BlockRows<12, 12>&);

template <int n>
bool RigidMultigrid<n>::exchange(BlockRows<n, n> matrix) {
  const bool regular = fine_.smoother.set(std::move(matrix), threads_);
  fine_.make_room();
  return regular;
}

template <int n>
bool RigidMultigrid<n>::set_up(std::span<const Frame> frames, StepWatch* watch) {
  std::vector<Frame> level_frames(frames.begin(), frames.end());
  coarse_.clear();
  BlockRows<6, 6> next;
  bool more = coarsen(threads_, watch, fine_, level_frames, next);
  while (more) {
    MultigridLevel<6>& level = coarse_.emplace_back();
    if (!level.smoother.set(std::move(next), threads_)) return false;
    level.make_room();
    next = {};
    more = coarsen(threads_, watch, level, level_frames, next);
  }
  return set_up_coarsest(watch);
}

namespace {

Slots slots_of(int count, int size) {
  const std::vector<double> lengths(index(count), 1.0);
  return make_slots(std::vector<int>(index(count), size), lengths);
}

}  // namespace

template <int n>
bool RigidMultigrid<n>::set_up_coarsest(StepWatch* watch) {
  const int size = coarse_.empty() ? n : 6;
  const auto rows =
      static_cast<int>(coarse_.empty() ? fine_.smoother.rows() : coarse_.back().smoother.rows());
  slots_ = slots_of(rows, size);
  direct_ = std::make_unique<Multifrontal>(slots_, watch);
  direct_right_.assign(index(rows), Vector12::Zero());
  direct_solution_ = direct_right_;
  return direct_->factorize(coarse_.empty() ? block_system(fine_.smoother.matrix())
                                            : block_system(coarse_.back().smoother.matrix()));
}

template <int n>
void RigidMultigrid<n>::apply(const Blocks<n>& right, Blocks<n>& solution) {
  if (coarse_.empty()) {
    for (std::size_t i = 0; i < right.size(); ++i) direct_right_[i].template head<n>() = right[i];
    direct_->solve(direct_right_, direct_solution_);
    for (std::size_t i = 0; i < right.size(); ++i) {
      solution[i] = direct_solution_[i].template head<n>();
    }
    return;
  }
  fine_.smoother.there(threads_, right, solution, fine_.residual);
  solver::multiply(threads_, fine_.restriction, fine_.residual, coarse_.front().right);
  cycle(0);
  add_correction(threads_, fine_.prolongation, coarse_.front().solution, solution);
  fine_.smoother.back(threads_, right, solution);
}

template <int n>
void RigidMultigrid<n>::multiply(const Blocks<n>& solution, Blocks<n>& product) const {
  if (coarse_.empty()) {
    solver::multiply(threads_, matrix(), solution, product);
  } else {
    fine_.smoother.multiply(threads_, solution, product);
  }
}

template <int n>
void RigidMultigrid<n>::cycle(std::size_t at) {
  if (at + 1 == coarse_.size()) {
    solve_coarsest();
    return;
  }
  MultigridLevel<6>&level = coarse_[at], &next = coarse_[at + 1];
  level.smoother.there(threads_, level.right, level.solution, level.residual);
  solver::multiply(threads_, level.restriction, level.residual, next.right);
  cycle(at + 1);
  add_correction(threads_, level.prolongation, next.solution, level.solution);
  level.smoother.back(threads_, level.right, level.solution);
}

template <int n>
void RigidMultigrid<n>::solve_coarsest() {
  MultigridLevel<6>& level = coarse_.back();
  for (std::size_t i = 0; i < level.right.size(); ++i) direct_right_[i].head<6>() = level.right[i];
  direct_->solve(direct_right_, direct_solution_);
  for (std::size_t i = 0; i < level.right.size(); ++i) {
    level.solution[i] = direct_solution_[i].head<6>();
  }
}

template <int n>
double RigidMultigrid<n>::complexity() const {
  constexpr int share = n * n / 36;
  double sum = static_cast<double>(share * matrix().value.size());
  const double finest = sum;
  for (const MultigridLevel<6>& level : coarse_)
    sum += static_cast<double>(level.smoother.matrix().value.size());
  return sum / finest;
}

template class RigidMultigrid<6>;
template class RigidMultigrid<12>;

}  // namespace quoin::solver
