#include "linear/multifrontal.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "index.hpp"

namespace quoin::solver {
namespace {

std::size_t area(int rows, int columns) { return index(rows) * index(columns); }

/// Gives its memory back, which `= {}` does not.
template <class Item>
void release(std::vector<Item>& list) {
  std::vector<Item>().swap(list);
}

/// What stands in the list is not kept: it need not be there twice.
void make_room(std::size_t size, std::vector<double>& list) {
  if (list.capacity() < size) release(list);
  list.resize(size);
}

/// Sizes are multiples of this: a block has 6 or 12 unknowns.
constexpr int kNode = 6;
static_assert(kNode == kPanel);

// An analysis takes as long as so many multiplications of the factors for each block and pair; of
// these a share of zero pairs saves three times its share at least. Measured on shaken walls of 105
// and 1012 bricks and a sliding slope of 512 blocks (bench/trials_large.md).
constexpr double kAnalysis = 4.6e3;
constexpr double kSaved = 3.0;

using Factor = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

/// Whose columns stand one after the other.
void set_zero(const Columns& matrix) {
  std::fill_n(matrix.data, matrix.stride * matrix.columns, 0.0);
}

/// The leading part of a block of the system.
void copy(const SquareBlocks::ConstBlock& block, const Columns& to) {
  for (int j = 0; j < to.columns; ++j) {
    const double* from = block.data() + j * block.outerStride();
    std::copy_n(from, to.rows, to.data + j * to.stride);
  }
}

void copy_transposed(const SquareBlocks::ConstBlock& block, const Columns& to) {
  for (int j = 0; j < to.columns; ++j) {
    for (int i = 0; i < to.rows; ++i) to.data[i + j * to.stride] = block(j, i);
  }
}

void add(const double* from, long stride, const Columns& to) {
  for (int j = 0; j < to.columns; ++j) {
    const double* source = from + j * stride;
    double* sum = to.data + j * to.stride;
    for (int i = 0; i < to.rows; i += kNode) {
      for (int k = i; k < i + kNode; ++k) sum[k] += source[k];
    }
  }
}

void add_transposed(const double* from, long stride, const Columns& to) {
  for (int j = 0; j < to.columns; ++j) {
    for (int i = 0; i < to.rows; ++i) to.data[i + j * to.stride] += from[j + i * stride];
  }
}

/// L U of columns of a square matrix from `at` on, with exchanges of its rows. False: singular.
bool factor_general(const Columns& square, int at, double* reciprocals, int* exchanges) {
  for (int k = at; k < at + kPanel; ++k) {
    double* column = square.data + k * square.stride;
    int best = k;
    for (int i = k + 1; i < square.rows; ++i) {
      if (std::abs(column[i]) > std::abs(column[best])) best = i;
    }
    if (!(std::abs(column[best]) > 0.0)) return false;
    exchanges[k] = best;
    for (int j = 0; best != k && j < square.columns; ++j) {
      std::swap(square.data[k + j * square.stride], square.data[best + j * square.stride]);
    }
    const double reciprocal = reciprocals[k - at] = 1.0 / column[k];
    for (int i = k + 1; i < square.rows; ++i) column[i] *= reciprocal;
    for (int j = k + 1; j < at + kPanel; ++j) {
      double* next = square.data + j * square.stride;
      for (int i = k + 1; i < square.rows; ++i) next[i] -= column[i] * next[k];
    }
  }
  return true;
}

/// L L^T of kPanel columns. False: not positive definite.
bool factor_symmetric(const Columns& square, double* reciprocals) {
  for (int k = 0; k < kPanel; ++k) {
    double* column = square.data + k * square.stride;
    if (!(column[k] > 0.0)) return false;
    column[k] = std::sqrt(column[k]);
    reciprocals[k] = 1.0 / column[k];
    for (int i = k + 1; i < kPanel; ++i) column[i] *= reciprocals[k];
    for (int j = k + 1; j < kPanel; ++j) {
      double* next = square.data + j * square.stride;
      for (int i = j; i < kPanel; ++i) next[i] -= column[i] * column[j];
    }
  }
  return true;
}

/// L x = x with L unit lower triangular.
void solve_unit_lower(const Columns& lower, const Columns& x) {
  for (int j = 0; j < x.columns; ++j) {
    double* column = x.data + j * x.stride;
    for (int k = 0; k < lower.columns; ++k) {
      const double* factor = lower.data + k * lower.stride;
      for (int i = k + 1; i < lower.rows; ++i) column[i] -= factor[i] * column[k];
    }
  }
}

/// Which pairs of a system are not zero.
void find_coupled(const BlockSystem& system, std::vector<int>& coupled) {
  coupled.clear();
  for (std::size_t p = 0; p < system.pairs.size(); ++p) {
    const bool zero =
        system.off_diagonal[p].isZero(0.0) && (system.symmetric || system.mirrored[p].isZero(0.0));
    if (!zero) coupled.push_back(static_cast<int>(p));
  }
}

}  // namespace

/// `coupled`: of the pairs, in their order.
void Multifrontal::analyse(const BlockSystem& system, const std::vector<int>& coupled,
                           Analysis& result) {
  const int count = slots_->count();
  std::vector<std::pair<int, int>> pairs;
  for (const int p : coupled) pairs.push_back(system.pairs[index(p)]);
  result.elimination = make_elimination(count, pairs);
  result.coupled = coupled;
  result.made = true;
  const auto& [node_at, place_of, supernodes] = result.elimination;
  result.start.assign(1, 0);
  for (const int slot : node_at) {
    result.start.push_back(result.start.back() + slots_->size[index(slot)]);
  }
  result.couplings.assign(index(count), {});
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const int first = place_of[index(pairs[p].first)], second = place_of[index(pairs[p].second)];
    result.couplings[index(std::min(first, second))].push_back(
        {coupled[p], std::max(first, second), first > second});
  }
  local_.assign(index(count), 0);
  result.work = 0.0;
  result.fronts.assign(supernodes.size(), {});
  for (std::size_t s = 0; s < supernodes.size(); ++s) {
    const Supernode& node = supernodes[s];
    Front& front = result.fronts[s];
    front.own = result.start[index(node.end)] - result.start[index(node.first)];
    front.first = result.start[index(node.first)];
    for (const int place : node.below) front.below += slots_->size[index(node_at[index(place)])];
    const double own = front.own, below = front.below;
    result.work += own * (own * own / 3.0 + own * below + below * below);
  }
  placed_ = false;
}

void Multifrontal::analyse_pattern(const BlockSystem& system) {
  if (whole_.made && pairs_ == system.pairs) return;
  pairs_ = system.pairs;
  coupled_.resize(pairs_.size());
  std::iota(coupled_.begin(), coupled_.end(), 0);
  analyse(system, coupled_, whole_);
  part_.made = false;
}

/// Contacts that are open couple no blocks: an order for the others takes less work, but has to be
/// found for each set of them.
void Multifrontal::choose_analysis(const BlockSystem& system) {
  analyse_pattern(system);
  const std::size_t count = system.pairs.size();
  find_coupled(system, coupled_);
  const double zeros = static_cast<double>(count - coupled_.size());
  const double size = static_cast<double>(slots_->count()) + static_cast<double>(count);
  const bool pays = kSaved * zeros * whole_.work > kAnalysis * size * static_cast<double>(count);
  if (pays && !(part_.made && part_.coupled == coupled_)) analyse(system, coupled_, part_);
  if (pays != in_part_) placed_ = false;
  in_part_ = pays;
}

double Multifrontal::work(const BlockSystem& system) {
  analyse_pattern(system);
  return system.symmetric ? 0.5 * whole_.work : whole_.work;
}

/// Where the factors of each front stand, and memory for the rests that wait at the same time.
void Multifrontal::place_factors() {
  std::size_t factors = 0, columns = 0, waiting = 0, most = 0;
  std::vector<std::size_t>& taken = waiting_;  // by the rests of a front's children
  taken.assign(analysis().fronts.size(), 0);
  for (std::size_t s = 0; s < analysis().fronts.size(); ++s) {
    Front& front = analysis().fronts[s];
    front.columns = factors;
    factors += area(keeps_lower_ ? front.own + front.below : front.own, front.own);
    if (!keeps_lower_) columns = std::max(columns, area(front.own + front.below, front.own));
    front.rows = factors;
    if (!symmetric_) factors += area(front.own, front.below);
    const std::size_t rest = area(front.below, front.below);
    most = std::max(most, waiting + rest);
    waiting += rest - taken[s];
    const int parent = analysis().elimination.supernodes[s].parent;
    if (parent >= 0) taken[index(parent)] += rest;
  }
  make_room(factors, factor_);
  make_room(columns, columns_);
  make_room(most, stack_);
  pivots_.resize(slots_->unknowns());
  exchanges_.resize(index(slots_->unknowns()));
  vector_.resize(slots_->unknowns());
}

void Multifrontal::release() {
  solver::release(factor_);
  solver::release(columns_);
  solver::release(stack_);
  solver::release(exchanges_);
  placed_ = false;
}

Multifrontal::Parts Multifrontal::parts(const Front& front, double* rest) {
  const int own = front.own, below = front.below;
  double* columns = keeps_lower_ ? factor_.data() + front.columns : columns_.data();
  return {{columns, own + below, own + below, own},
          {factor_.data() + front.rows, below, below, symmetric_ ? 0 : own},
          {rest, below, below, below}};
}

bool Multifrontal::factorize(const BlockSystem& system) { return factorize(system, nullptr); }

bool Multifrontal::factorize(const BlockSystem& system, const BlockVector& only) {
  return factorize(system, &only);
}

bool Multifrontal::factorize(const BlockSystem& system, const BlockVector* only) {
  choose_analysis(system);
  const bool keeps_lower = system.symmetric || only == nullptr;
  if (!placed_ || symmetric_ != system.symmetric || keeps_lower_ != keeps_lower) {
    symmetric_ = system.symmetric;
    keeps_lower_ = keeps_lower;
    place_factors();
    placed_ = true;
  }
  if (!keeps_lower_) take(*only);
  std::vector<std::size_t>& waiting = waiting_;  // supernodes whose rests stand on the stack
  waiting.clear();
  std::size_t top = 0;
  for (std::size_t s = 0; s < analysis().fronts.size(); ++s) {
    look();
    const Front& front = analysis().fronts[s];
    const Parts now = parts(front, stack_.data() + top);
    set_zero(now.columns);
    set_zero(now.rows);
    set_zero(now.rest);
    add_own_blocks(system, s, now);
    while (!waiting.empty() &&
           analysis().elimination.supernodes[waiting.back()].parent == static_cast<int>(s)) {
      const int below = analysis().fronts[waiting.back()].below;
      top -= area(below, below);
      add_rest(waiting.back(), stack_.data() + top, s, now);
      waiting.pop_back();
    }
    if (!(symmetric_ ? eliminate_symmetric(s, now) : eliminate_general(s, now))) return false;
    if (!keeps_lower_) {
      forward(s);
      double* kept = factor_.data() + front.columns;
      for (int j = 0; j < front.own; ++j, kept += front.own) {
        std::copy_n(now.columns.data + j * now.columns.stride, front.own, kept);
      }
    }
    const std::size_t rest = area(front.below, front.below);
    std::copy_n(now.rest.data, rest, stack_.data() + top);
    top += rest;
    waiting.push_back(s);
  }
  return true;
}

void Multifrontal::add_own_blocks(const BlockSystem& system, std::size_t node, const Parts& front) {
  const Supernode& supernode = analysis().elimination.supernodes[node];
  const int own = analysis().fronts[node].own;
  int at = 0;
  const auto place_next = [&](int place) {
    local_[index(place)] = at;
    at += slots_->size[index(analysis().elimination.node_at[index(place)])];
  };
  for (int place = supernode.first; place < supernode.end; ++place) place_next(place);
  for (const int place : supernode.below) place_next(place);
  for (int place = supernode.first; place < supernode.end; ++place) {
    const std::size_t slot = index(analysis().elimination.node_at[index(place)]);
    const int size = slots_->size[slot], from = local_[index(place)];
    copy(std::as_const(system.diagonal)[slot], front.columns.block(from, from, size, size));
    for (const Coupling& coupling : analysis().couplings[index(place)]) {
      const int rows = slots_->size[index(analysis().elimination.node_at[index(coupling.other)])];
      const int to = local_[index(coupling.other)];
      const Columns lower_part = front.columns.block(to, from, rows, size);
      const SquareBlocks::ConstBlock upper = system.off_diagonal[index(coupling.pair)];
      if (symmetric_) {
        coupling.forward ? copy(upper, lower_part) : copy_transposed(upper, lower_part);
        continue;
      }
      const SquareBlocks::ConstBlock mirrored = system.mirrored[index(coupling.pair)];
      const SquareBlocks::ConstBlock &lower = coupling.forward ? upper : mirrored,
                                     &other = coupling.forward ? mirrored : upper;
      copy(lower, lower_part);
      if (to < own) {
        copy(other, front.columns.block(from, to, size, rows));
      } else {
        copy_transposed(other, front.rows.block(to - own, from, rows, size));
      }
    }
  }
}

/// Of a child in the front of its parent, which eliminates `own` unknowns: a run is of these or of
/// the others.
void Multifrontal::find_runs(std::size_t child, int own) {
  runs_.clear();
  int from = 0;
  for (const int place : analysis().elimination.supernodes[child].below) {
    const int size = slots_->size[index(analysis().elimination.node_at[index(place)])];
    const int to = local_[index(place)];
    const bool continues =
        !runs_.empty() && to != own && runs_.back().to + runs_.back().count == to;
    if (!continues) runs_.push_back({from, to, 0});
    runs_.back().count += size;
    from += size;
  }
}

/// What a child left, to where it belongs in the front of its parent; the lower triangle if
/// symmetric.
void Multifrontal::add_rest(std::size_t child, const double* rest, std::size_t node,
                            const Parts& front) {
  const int own = analysis().fronts[node].own;
  const long stride = analysis().fronts[child].below;
  find_runs(child, own);
  for (std::size_t j = 0; j < runs_.size(); ++j) {
    const Run& right = runs_[j];
    for (std::size_t i = symmetric_ ? j : 0; i < runs_.size(); ++i) {
      const Run& down = runs_[i];
      const double* from = rest + down.from + right.from * stride;
      if (right.to < own) {
        add(from, stride, front.columns.block(down.to, right.to, down.count, right.count));
      } else if (down.to < own) {
        const int to = right.to - own;
        add_transposed(from, stride, front.rows.block(to, down.to, right.count, down.count));
      } else {
        const int to = right.to - own;
        add(from, stride, front.rest.block(down.to - own, to, down.count, right.count));
      }
    }
  }
}

bool Multifrontal::eliminate_symmetric(std::size_t node, const Parts& parts) {
  const Front& front = analysis().fronts[node];
  const Columns& columns = parts.columns;
  for (int at = 0; at < front.own; at += kPanel) {
    if (at > 0) look();
    double reciprocals[kPanel];
    const Columns corner = columns.block(at, at, kPanel, kPanel);
    if (!factor_symmetric(corner, reciprocals)) return false;
    for (int k = 0; k < kPanel; ++k) {
      const double root = corner.data[k + k * corner.stride];
      pivots_[front.first + at + k] = root * root;
    }
    const int next = at + kPanel, left = front.own - next, rows = columns.rows - next;
    const Columns panel = columns.block(next, at, rows, kPanel);
    solve_panel(transposed(corner), reciprocals, panel);
    subtract_product(panel, transposed(panel), Triangle::Lower,
                     columns.block(next, next, rows, left));
  }
  const Columns below = columns.block(front.own, 0, front.below, front.own);
  subtract_product(below, transposed(below), Triangle::Lower, parts.rest);
  return true;
}

bool Multifrontal::eliminate_general(std::size_t node, const Parts& parts) {
  const Front& front = analysis().fronts[node];
  const auto& [columns, rows, rest] = parts;
  const Columns square = columns.block(0, 0, front.own, front.own);
  int* exchanges = exchanges_.data() + front.first;
  for (int at = 0; at < front.own; at += kPanel) {
    if (at > 0) look();
    double reciprocals[kPanel];
    if (!factor_general(square, at, reciprocals, exchanges)) return false;
    const Columns corner = square.block(at, at, kPanel, kPanel);
    for (int k = 0; k < kPanel; ++k) {
      pivots_[front.first + at + k] = std::abs(corner.data[k + k * corner.stride]);
    }
    const int next = at + kPanel, left = front.own - next, height = columns.rows - next;
    const Columns right = columns.block(at, next, kPanel, left);
    solve_unit_lower(corner, right);
    solve_panel(as_is(corner), reciprocals, columns.block(front.own, at, front.below, kPanel));
    subtract_product(columns.block(next, at, height, kPanel), as_is(right), Triangle::Both,
                     columns.block(next, next, height, left));
  }
  for (int k = 0; k < front.own; ++k) {
    if (exchanges[k] == k) continue;
    double *one = rows.data + k * rows.stride, *other = rows.data + exchanges[k] * rows.stride;
    std::swap_ranges(one, one + rows.rows, other);
  }
  for (int at = 0; at < front.own; at += kPanel) {
    if (at > 0) look();
    const Columns panel = rows.block(0, at, front.below, kPanel);
    subtract_product(rows.block(0, 0, front.below, at), transposed(square.block(at, 0, kPanel, at)),
                     Triangle::Both, panel);
    solve_panel(transposed(square.block(at, at, kPanel, kPanel)), nullptr, panel);
  }
  subtract_product(columns.block(front.own, 0, front.below, front.own), transposed(rows),
                   Triangle::Both, rest);
  return true;
}

void Multifrontal::solve(const BlockVector& right, BlockVector& solution) {
  if (keeps_lower_) {
    take(right);
    for (std::size_t s = 0; s < analysis().fronts.size(); ++s) forward(s);
  }
  for (std::size_t s = analysis().fronts.size(); s-- > 0;) backward(s);
  for (std::size_t s = 0; s < solution.size(); ++s) {
    solution[s].setZero();
    solution[s].head(slots_->size[s]) = unknowns_of(s);
  }
}

void Multifrontal::take(const BlockVector& right) {
  for (std::size_t s = 0; s < right.size(); ++s) {
    unknowns_of(s) = right[s].head(slots_->size[s]);
  }
}

Eigen::VectorBlock<Eigen::VectorXd> Multifrontal::unknowns_of(std::size_t slot) {
  return vector_.segment(analysis().start[index(analysis().elimination.place_of[slot])],
                         slots_->size[slot]);
}

void Multifrontal::forward(std::size_t node) {
  const Front& front = analysis().fronts[node];
  const Columns& columns = parts(front, nullptr).columns;
  const Factor pivot(columns.data, front.own, front.own, Eigen::OuterStride<>(columns.stride));
  auto own = vector_.segment(front.first, front.own);
  if (symmetric_) {
    pivot.triangularView<Eigen::Lower>().solveInPlace(own);
  } else {
    for (int k = 0; k < front.own; ++k) std::swap(own[k], own[exchanges_[index(front.first + k)]]);
    pivot.triangularView<Eigen::UnitLower>().solveInPlace(own);
  }
  if (front.below == 0) return;
  below_.noalias() = Factor(columns.data + front.own, front.below, front.own,
                            Eigen::OuterStride<>(columns.stride)) *
                     own;
  int at = 0;
  for (const int place : analysis().elimination.supernodes[node].below) {
    const int size = analysis().start[index(place) + 1] - analysis().start[index(place)];
    vector_.segment(analysis().start[index(place)], size) -= below_.segment(at, size);
    at += size;
  }
}

void Multifrontal::backward(std::size_t node) {
  const Front& front = analysis().fronts[node];
  const int height = keeps_lower_ ? front.own + front.below : front.own;
  const Factor pivot(factor_.data() + front.columns, front.own, front.own,
                     Eigen::OuterStride<>(height));
  auto own = vector_.segment(front.first, front.own);
  below_.resize(front.below);
  int at = 0;
  for (const int place : analysis().elimination.supernodes[node].below) {
    const int size = analysis().start[index(place) + 1] - analysis().start[index(place)];
    below_.segment(at, size) = vector_.segment(analysis().start[index(place)], size);
    at += size;
  }
  const double* beside = symmetric_ ? pivot.data() + front.own : factor_.data() + front.rows;
  const Factor rows(beside, front.below, front.own,
                    Eigen::OuterStride<>(symmetric_ ? height : front.below));
  own.noalias() -= rows.transpose() * below_;
  if (symmetric_) {
    pivot.triangularView<Eigen::Lower>().transpose().solveInPlace(own);
  } else {
    pivot.triangularView<Eigen::Upper>().solveInPlace(own);
  }
}

double Multifrontal::condition_estimate() const {
  return pivots_.size() == 0 ? 1.0 : pivots_.maxCoeff() / pivots_.minCoeff();
}

}  // namespace quoin::solver
