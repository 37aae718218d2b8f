#include "linear/rigid_multigrid.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "index.hpp"

namespace quoin::solver {
namespace {

template <int n>
using Square = Eigen::Matrix<double, n, n>;

constexpr int kCoarsest = 100;       // rows: elimination is then cheaper than another level
constexpr double kStalled = 0.7;     // of the rows are left: another level would not pay
constexpr int kPowerSteps = 8;       // of the estimate of a largest eigenvalue,
constexpr double kPowerShare = 0.9;  // which they reach to that share

/// False where one is singular to rounding.
template <int n>
bool invert_diagonal(MultigridLevel<n>& level) {
  const BlockRows<n, n>& matrix = level.matrix;
  level.inverse.resize(index(matrix.rows()));
  for (std::size_t i = 0; i < level.inverse.size(); ++i) {
    for (std::size_t k = index(matrix.start[i]); k < index(matrix.start[i + 1]); ++k) {
      if (matrix.column[k] == static_cast<int>(i)) level.inverse[i] = matrix.value[k].inverse();
    }
    if (!level.inverse[i].allFinite()) return false;
  }
  return true;
}

/// Rows by colour, each row of the first colour that no neighbour before it has.
template <int n>
void set_order(MultigridLevel<n>& level) {
  const BlockRows<n, n>& matrix = level.matrix;
  const std::size_t rows = index(matrix.rows());
  std::vector<int> colour(rows, -1),
      taken(rows + 1, -1);  // taken: by colour, the last row that saw it
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t k = index(matrix.start[i]); k < index(matrix.start[i + 1]); ++k) {
      const int other = colour[index(matrix.column[k])];
      if (other >= 0) taken[index(other)] = static_cast<int>(i);
    }
    int free = 0;
    while (taken[index(free)] == static_cast<int>(i)) ++free;
    colour[i] = free;
  }
  level.order.resize(rows);
  std::iota(level.order.begin(), level.order.end(), 0);
  std::ranges::stable_sort(level.order, {}, [&](int i) { return colour[index(i)]; });
}

template <int n>
void set_vectors(MultigridLevel<n>& level) {
  for (Blocks<n>* vector : {&level.solution, &level.right, &level.residual}) {
    vector->resize(index(level.matrix.rows()));
  }
}

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
double largest_eigenvalue(MultigridLevel<n>& level) {
  double estimate = 1.0;
  for (std::size_t i = 0; i < level.solution.size(); ++i) {
    for (int k = 0; k < n; ++k) {  // no direction of the matrix is special to this one
      level.solution[i][k] = std::sin(1.0 + 7.0 * static_cast<double>(i) + 3.0 * k);
    }
  }
  for (int step = 0; step < kPowerSteps; ++step) {
    double before = 0.0, after = 0.0;
    for (std::size_t i = 0; i < level.residual.size(); ++i) {
      level.residual[i] =
          level.inverse[i] * level.matrix.times(static_cast<int>(i), level.solution);
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
void set_transfer(const Aggregates& groups, std::span<const Frame> frames,
                  std::span<const Frame> coarse, MultigridLevel<n>& level) {
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
  const double share = 4.0 / 3.0 / largest_eigenvalue(level);
  level.prolongation = product(level.matrix, rigid);
  BlockRows<n, 6>& smooth = level.prolongation;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    for (std::size_t k = index(smooth.start[i]); k < index(smooth.start[i + 1]); ++k) {
      smooth.value[k] = (-share * level.inverse[i] * smooth.value[k]).eval();
      if (smooth.column[k] == groups.of[i]) smooth.value[k] += rigid.value[index(rigid.start[i])];
    }
  }
  level.restriction = transposed(smooth);
}

/// Gauss–Seidel over all rows, there or back.
template <int n>
void relax(MultigridLevel<n>& level, int i) {
  const std::size_t row = index(i);
  level.solution[row] +=
      level.inverse[row] * (level.right[row] - level.matrix.times(i, level.solution));
}

template <int n>
void relax_there(MultigridLevel<n>& level) {
  for (const int i : level.order) relax(level, i);
}

template <int n>
void relax_back(MultigridLevel<n>& level) {
  for (std::size_t k = level.order.size(); k-- > 0;) relax(level, level.order[k]);
}

template <int n>
void restrict_residual(MultigridLevel<n>& level, Blocks<6>& coarse) {
  for (std::size_t i = 0; i < level.residual.size(); ++i) {
    level.residual[i] = level.right[i] - level.matrix.times(static_cast<int>(i), level.solution);
  }
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    coarse[i] = level.restriction.times(static_cast<int>(i), level.residual);
  }
}

template <int n>
void add_correction(const Blocks<6>& coarse, MultigridLevel<n>& level) {
  for (std::size_t i = 0; i < level.solution.size(); ++i) {
    level.solution[i] += level.prolongation.times(static_cast<int>(i), coarse);
  }
}

/// The next coarser level, where there is one that pays; frames become its own.
template <int n>
bool coarsen(MultigridLevel<n>& level, std::vector<Frame>& frames, MultigridLevel<6>& coarse) {
  const int rows = level.matrix.rows();
  if (rows <= kCoarsest) return false;
  const Aggregates groups = aggregate(rigid_part(level.matrix));
  if (groups.count == 0 || groups.count > kStalled * rows) return false;
  std::vector<Frame> coarse_frames = group_frames(groups, frames);
  set_transfer(groups, frames, coarse_frames, level);
  coarse.matrix = product(level.restriction, product(level.matrix, level.prolongation));
  frames = std::move(coarse_frames);
  return true;
}

}  // namespace

template <int n>
BlockRows<n, n> block_rows(const BlockSystem& system, const Slots& slots) {
  struct Entry {
    int column;
    const Matrix12* block;
    bool mirrored;
  };
  const std::size_t count = system.diagonal.size();
  std::vector<std::vector<Entry>> rows(count);
  for (std::size_t i = 0; i < count; ++i) {
    rows[i].push_back({static_cast<int>(i), &system.diagonal[i], false});
  }
  for (std::size_t p = 0; p < system.pairs.size(); ++p) {
    const auto [i, j] = system.pairs[p];
    const Matrix12& upper = system.off_diagonal[p];
    const Matrix12& lower = system.symmetric ? upper : system.mirrored[p];
    if (upper.isZero(0.0) && lower.isZero(0.0)) continue;
    rows[index(i)].push_back({j, &upper, false});
    rows[index(j)].push_back({i, &lower, system.symmetric});
  }
  BlockRows<n, n> result;
  result.columns = static_cast<int>(count);
  for (std::size_t i = 0; i < count; ++i) {
    for (const Entry& entry : rows[i]) {
      Square<n> block = entry.block->template topLeftCorner<n, n>();
      if (entry.mirrored) block.transposeInPlace();
      const int size = slots.size[i], width = slots.size[index(entry.column)];
      if (size < n) block.bottomRows(n - size).setZero();
      if (width < n) block.rightCols(n - width).setZero();
      if (entry.column == static_cast<int>(i)) {
        for (int k = size; k < n; ++k) block(k, k) = 1.0;
      }
      result.push_back(entry.column, block);
    }
    result.end_row();
  }
  return result;
}

template BlockRows<6, 6> block_rows<6>(const BlockSystem&, const Slots&);
template BlockRows<12, 12> block_rows<12>(const BlockSystem&, const Slots&);

template <int n>
BlockSystem block_system(const BlockRows<n, n>& matrix) {
  BlockSystem system;
  system.symmetric = false;
  const std::size_t rows = index(matrix.rows());
  system.diagonal.assign(rows, Matrix12::Zero());
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t k = index(matrix.start[i]); k < index(matrix.start[i + 1]); ++k) {
      const int j = matrix.column[k];
      if (j == static_cast<int>(i)) system.diagonal[i].topLeftCorner<n, n>() = matrix.value[k];
      if (j > static_cast<int>(i)) system.pairs.emplace_back(static_cast<int>(i), j);
    }
  }
  std::ranges::sort(system.pairs);
  system.off_diagonal.assign(system.pairs.size(), Matrix12::Zero());
  system.mirrored = system.off_diagonal;
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t k = index(matrix.start[i]); k < index(matrix.start[i + 1]); ++k) {
      const int row = static_cast<int>(i), j = matrix.column[k];
      if (j == row) continue;
      const std::pair<int, int> pair = std::minmax(row, j);
      const auto at = std::ranges::lower_bound(system.pairs, pair) - system.pairs.begin();
      std::vector<Matrix12>& side = row < j ? system.off_diagonal : system.mirrored;
      side[static_cast<std::size_t>(at)].topLeftCorner<n, n>() = matrix.value[k];
    }
  }
  return system;
}

template BlockSystem block_system(const BlockRows<6, 6>&);
template BlockSystem block_system(const BlockRows<12, 12>&);

template <int n>
bool RigidMultigrid<n>::exchange(BlockRows<n, n> matrix) {
  fine_.matrix = std::move(matrix);
  set_vectors(fine_);
  set_order(fine_);
  return invert_diagonal(fine_);
}

template <int n>
bool RigidMultigrid<n>::set_up(std::span<const Frame> frames) {
  std::vector<Frame> level_frames(frames.begin(), frames.end());
  coarse_.clear();
  MultigridLevel<6> next;
  bool more = coarsen(fine_, level_frames, next);
  while (more) {
    coarse_.push_back(std::move(next));
    MultigridLevel<6>& level = coarse_.back();
    set_vectors(level);
    set_order(level);
    if (!invert_diagonal(level)) return false;
    next = {};
    more = coarsen(level, level_frames, next);
  }
  return set_up_coarsest();
}

namespace {

Slots slots_of(int count, int size) {
  const std::vector<double> lengths(index(count), 1.0);
  return make_slots(std::vector<int>(index(count), size), lengths);
}

}  // namespace

template <int n>
bool RigidMultigrid<n>::set_up_coarsest() {
  const int size = coarse_.empty() ? n : 6;
  const int rows = coarse_.empty() ? fine_.matrix.rows() : coarse_.back().matrix.rows();
  slots_ = slots_of(rows, size);
  direct_ = std::make_unique<Multifrontal>(slots_);
  direct_right_.assign(index(rows), Vector12::Zero());
  direct_solution_ = direct_right_;
  return direct_->factorize(coarse_.empty() ? block_system(fine_.matrix)
                                            : block_system(coarse_.back().matrix));
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
  fine_.right = right;
  for (auto& block : fine_.solution) block.setZero();
  relax_there(fine_);
  restrict_residual(fine_, coarse_.front().right);
  cycle(0);
  add_correction(coarse_.front().solution, fine_);
  relax_back(fine_);
  solution = fine_.solution;
}

template <int n>
void RigidMultigrid<n>::cycle(std::size_t at) {
  MultigridLevel<6>& level = coarse_[at];
  if (at + 1 == coarse_.size()) {
    solve_coarsest();
    return;
  }
  MultigridLevel<6>& next = coarse_[at + 1];
  for (auto& block : level.solution) block.setZero();
  relax_there(level);
  restrict_residual(level, next.right);
  cycle(at + 1);
  add_correction(next.solution, level);
  relax_back(level);
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
  double sum = static_cast<double>(share * fine_.matrix.value.size());
  const double finest = sum;
  for (const MultigridLevel<6>& level : coarse_)
    sum += static_cast<double>(level.matrix.value.size());
  return sum / finest;
}

template class RigidMultigrid<6>;
template class RigidMultigrid<12>;

}  // namespace quoin::solver
