#include "linear/multifrontal.hpp"

#include <algorithm>
#include <atomic>
#include <numeric>

#include "base/index.hpp"

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
// and 1012 bricks and a sliding slope of 512 blocks (bench/tried.md).
constexpr double kAnalysis = 4.6e3;
constexpr double kSaved = 3.0;

// Of a matrix that takes so many multiplications or more, some 2 ms, threads share the work; of
// what is in no subtree they share fronts that take so many, some 0.1 ms.
constexpr double kShared = 2e7, kSharedFront = 1e6;
constexpr double kSubtrees = 4.0;  // by this and the number of threads: the most of a subtree

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
  for (int j = 0; j < to.columns; ++j)
    for (int i = 0; i < to.rows; ++i) to.data[i + j * to.stride] = block(j, i);
}

void add(const double* from, long stride, const Columns& to) {
  for (int j = 0; j < to.columns; ++j) {
    const double* source = from + j * stride;
    double* sum = to.data + j * to.stride;
    for (int i = 0; i < to.rows; i += kNode)
      for (int k = i; k < i + kNode; ++k) sum[k] += source[k];
  }
}

void add_transposed(const double* from, long stride, const Columns& to) {
  for (int j = 0; j < to.columns; ++j)
    for (int i = 0; i < to.rows; ++i) to.data[i + j * to.stride] += from[j + i * stride];
}

/// Of a front that is not symmetric, about.
double multiplications(double own, double below) {
  return own * (own * own / 3.0 + own * below + below * below);
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
  const auto& [node_at, place_of, supernodes, below] = result.elimination;
  result.start.assign(1, 0);
  for (const int slot : node_at)
    result.start.push_back(result.start.back() + slots_->size[index(slot)]);
  result.couplings = make_lists<Coupling>(index(count), [&](const auto& add) {
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      const int first = place_of[index(pairs[p].first)], second = place_of[index(pairs[p].second)];
      add(std::min(first, second), Coupling{coupled[p], std::max(first, second), first > second});
    }
  });
  result.work = 0.0;
  result.fronts.assign(supernodes.size(), {});
  for (std::size_t s = 0; s < supernodes.size(); ++s) {
    const Supernode& node = supernodes[s];
    Front& front = result.fronts[s];
    front.own = result.start[index(node.end)] - result.start[index(node.first)];
    front.first = result.start[index(node.first)];
    for (const int place : below[s]) front.below += slots_->size[index(node_at[index(place)])];
    result.work += multiplications(front.own, front.below);
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

/// Subtrees that take at most a share of all the work each, for several threads.
void Multifrontal::part_tree() {
  const std::vector<Front>& fronts = analysis().fronts;
  const std::vector<Supernode>& supernodes = analysis().elimination.supernodes;
  subtrees_.clear();
  if (workers_ == 1 || analysis().work < kShared) {
    solver::release(rests_);
    return solver::release(pushes_);
  }
  taken_.assign(fronts.size(), 1);  // fronts of the subtree with that root
  subtree_work_.assign(fronts.size(), 0.0);
  for (std::size_t s = 0; s < fronts.size(); ++s) {
    subtree_work_[s] += multiplications(fronts[s].own, fronts[s].below);
    const int parent = supernodes[s].parent;
    if (parent < 0) continue;
    taken_[index(parent)] += taken_[s];
    subtree_work_[index(parent)] += subtree_work_[s];
  }
  const double most = analysis().work / (kSubtrees * workers_);
  for (std::size_t s = fronts.size(); s > 0;) {
    const bool whole = subtree_work_[s - 1] <= most;
    const std::size_t first = s - (whole ? taken_[s - 1] : 1);
    if (whole) subtrees_.push_back({first, s});
    s = first;
  }
  std::ranges::reverse(subtrees_);
  std::size_t rests = 0, pushes = 0;
  for (Subtree& subtree : subtrees_) {
    const int below = fronts[subtree.end - 1].below;
    subtree.rest = rests;
    subtree.pushes = pushes;
    subtree.beyond = analysis().start[index(supernodes[subtree.end - 1].end)];
    rests += area(below, below);
    for (std::size_t s = subtree.first; s < subtree.end; ++s) {
      for (const int place : analysis().elimination.below[s]) {
        const int at = analysis().start[index(place)];
        if (at >= subtree.beyond) pushes += index(analysis().start[index(place) + 1] - at);
      }
    }
  }
  make_room(rests, rests_);
  make_room(pushes, pushes_);
}

/// Memory of a thread that eliminates the fronts from `first` up to `end` but those of subtrees,
/// `subtree` and the next ones, for the rests that wait at the same time.
void Multifrontal::place_lane(std::size_t first, std::size_t end,
                              std::vector<Subtree>::const_iterator subtree, Lane& lane) {
  std::size_t columns = 0, waiting = 0, most = 0;
  taken_.resize(analysis().fronts.size());  // by the rests of a front's children
  std::fill(taken_.begin() + static_cast<long>(first), taken_.begin() + static_cast<long>(end), 0);
  for (std::size_t s = first; s < end; ++s) {
    if (subtree != subtrees_.end() && subtree->first == s) {
      s = subtree++->end - 1;
      continue;
    }
    const Front& front = analysis().fronts[s];
    if (!keeps_lower_) columns = std::max(columns, area(front.own + front.below, front.own));
    const std::size_t rest = area(front.below, front.below);
    most = std::max(most, waiting + rest);
    waiting += rest - taken_[s];
    const int parent = analysis().elimination.supernodes[s].parent;
    if (parent >= 0 && index(parent) < end) taken_[index(parent)] += rest;
  }
  lane.local.resize(index(slots_->count()));
  if (lane.stack.size() < most) make_room(most, lane.stack);
  if (lane.columns.size() < columns) make_room(columns, lane.columns);
}

/// Where the factors of each front stand, and the memory of the threads.
void Multifrontal::place_factors() {
  std::size_t factors = 0;
  for (Front& front : analysis().fronts) {
    front.columns = factors;
    factors += area(keeps_lower_ ? front.own + front.below : front.own, front.own);
    front.rows = factors;
    if (!symmetric_) factors += area(front.own, front.below);
  }
  make_room(factors, factor_);
  pivots_.resize(slots_->unknowns());
  exchanges_.resize(index(slots_->unknowns()));
  vector_.resize(slots_->unknowns());
  part_tree();
  lanes_.resize(subtrees_.empty() ? 1 : 1 + index(workers_));
  place_lane(0, analysis().fronts.size(), subtrees_.begin(), lanes_[0]);
  for (std::size_t w = 1; w < lanes_.size(); ++w)
    for (const Subtree& subtree : subtrees_)
      place_lane(subtree.first, subtree.end, subtrees_.end(), lanes_[w]);
}

void Multifrontal::release() {
  solver::release(factor_);
  solver::release(lanes_);
  solver::release(rests_);
  solver::release(pushes_);
  solver::release(exchanges_);
  placed_ = false;
}

DenseFront Multifrontal::dense(const Front& front, Lane& lane) {
  const int own = front.own, below = front.below;
  double* columns = keeps_lower_ ? factor_.data() + front.columns : lane.columns.data();
  return {{columns, own + below, own + below, own},
          {factor_.data() + front.rows, below, below, symmetric_ ? 0 : own},
          {lane.stack.data() + lane.top, below, below, below}};
}

bool Multifrontal::factorize(const BlockSystem& system, const BlockVector* only) {
  choose_analysis(system);
  threads_ = next_threads_;
  const bool keeps_lower = system.symmetric || only == nullptr;
  const int workers = threads_.workers();
  if (!placed_ || symmetric_ != system.symmetric || keeps_lower_ != keeps_lower ||
      workers_ != workers) {
    symmetric_ = system.symmetric;
    keeps_lower_ = keeps_lower;
    workers_ = workers;
    placed_ = false;
    place_factors();
    placed_ = true;
  }
  if (!keeps_lower_) take(*only);
  return eliminate_subtrees(system) && eliminate_rest(system);
}

/// A front, once its children are.
bool Multifrontal::eliminate(const BlockSystem& system, std::size_t node, const Threads& threads,
                             Lane& lane, Beyond& beyond) {
  if (watch_ != nullptr) watch_->look();
  const Front& front = analysis().fronts[node];
  const DenseFront now = dense(front, lane);
  set_zero(now.columns);
  set_zero(now.rows);
  set_zero(now.rest);
  add_own_blocks(system, node, lane, now);
  add_children(node, lane, now);
  const FrontCrew crew{threads, watch_};
  double* pivots = pivots_.data() + front.first;
  const bool sound = symmetric_
                         ? eliminate_symmetric(now, crew, pivots)
                         : eliminate_general(now, crew, pivots, exchanges_.data() + front.first);
  if (!sound) return false;
  if (!keeps_lower_) {
    forward(node, lane, beyond);
    double* kept = factor_.data() + front.columns;
    for (int j = 0; j < front.own; ++j, kept += front.own)
      std::copy_n(now.columns.data + j * now.columns.stride, front.own, kept);
  }
  const std::size_t rest = area(front.below, front.below);
  double* const top = lane.stack.data() + lane.top;
  std::copy_n(now.rest.data, rest, top);
  lane.top += rest;
  lane.waiting.push_back({node, top, true});
  return true;
}

bool Multifrontal::eliminate_subtree(const BlockSystem& system, const Subtree& subtree,
                                     Lane& lane) {
  Beyond beyond{subtree.beyond, pushes_.data() + subtree.pushes};
  lane.waiting.clear();
  lane.top = 0;
  for (std::size_t s = subtree.first; s < subtree.end; ++s)
    if (!eliminate(system, s, Threads(), lane, beyond)) return false;
  const int below = analysis().fronts[subtree.end - 1].below;
  std::copy_n(lane.stack.data(), area(below, below), rests_.data() + subtree.rest);
  return true;
}

bool Multifrontal::eliminate_subtrees(const BlockSystem& system) {
  std::atomic<bool> sound{true};
  threads_.take(subtrees_.size(), [&](int worker, std::size_t i) {
    if (sound && !eliminate_subtree(system, subtrees_[i], lanes_[1 + index(worker)])) sound = false;
  });
  return sound;
}

/// Calls front(s) for each front that is in no subtree, and leave_out(subtree) for each of these,
/// in the order of the elimination.
template <class OnFront, class OnSubtree>
void Multifrontal::walk(const OnFront& front, const OnSubtree& leave_out) const {
  auto subtree = subtrees_.begin();
  for (std::size_t s = 0; s < analysis().fronts.size(); ++s) {
    if (subtree == subtrees_.end() || subtree->first != s) {
      front(s);
      continue;
    }
    leave_out(*subtree);
    s = subtree++->end - 1;
  }
}

/// The fronts that are in no subtree.
bool Multifrontal::eliminate_rest(const BlockSystem& system) {
  Lane& lane = lanes_[0];
  lane.waiting.clear();
  lane.top = 0;
  Beyond none;
  bool sound = true;
  const auto eliminate_one = [&](std::size_t s) {
    const Front& front = analysis().fronts[s];
    const bool shared = workers_ > 1 && multiplications(front.own, front.below) >= kSharedFront;
    sound = sound && eliminate(system, s, shared ? threads_ : Threads(), lane, none);
  };
  const auto take_subtree = [&](const Subtree& subtree) {
    lane.waiting.push_back({subtree.end - 1, rests_.data() + subtree.rest, false});
    if (!keeps_lower_) take_off_beyond(subtree);
  };
  walk(eliminate_one, take_subtree);
  return sound;
}

void Multifrontal::add_own_blocks(const BlockSystem& system, std::size_t node, Lane& lane,
                                  const DenseFront& front) {
  const Supernode& supernode = analysis().elimination.supernodes[node];
  const int own = analysis().fronts[node].own;
  int at = 0;
  const auto place_next = [&](int place) {
    lane.local[index(place)] = at;
    at += slots_->size[index(analysis().elimination.node_at[index(place)])];
  };
  for (int place = supernode.first; place < supernode.end; ++place) place_next(place);
  for (const int place : analysis().elimination.below[node]) place_next(place);
  for (int place = supernode.first; place < supernode.end; ++place) {
    const std::size_t slot = index(analysis().elimination.node_at[index(place)]);
    const int size = slots_->size[slot], from = lane.local[index(place)];
    copy(std::as_const(system.diagonal)[slot], front.columns.block(from, from, size, size));
    for (const Coupling& coupling : analysis().couplings[index(place)]) {
      const int rows = slots_->size[index(analysis().elimination.node_at[index(coupling.other)])];
      const int to = lane.local[index(coupling.other)];
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
      if (to < own)
        copy(other, front.columns.block(from, to, size, rows));
      else
        copy_transposed(other, front.rows.block(to - own, from, rows, size));
    }
  }
}

/// Of a child in the front of its parent, which eliminates `own` unknowns: a run is of these or of
/// the others.
void Multifrontal::find_runs(std::size_t child, int own, Lane& lane) {
  std::vector<Run>& runs = lane.runs;
  runs.clear();
  int from = 0;
  for (const int place : analysis().elimination.below[child]) {
    const int size = slots_->size[index(analysis().elimination.node_at[index(place)])];
    const int to = lane.local[index(place)];
    const bool continues = !runs.empty() && to != own && runs.back().to + runs.back().count == to;
    if (!continues) runs.push_back({from, to, 0});
    runs.back().count += size;
    from += size;
  }
}

/// What a child left, to where it belongs in the front of its parent; the lower triangle if
/// symmetric.
void Multifrontal::add_rest(const Waiting& child, std::size_t node, Lane& lane,
                            const DenseFront& front) {
  const int own = analysis().fronts[node].own;
  const long stride = analysis().fronts[child.front].below;
  find_runs(child.front, own, lane);
  const std::vector<Run>& runs = lane.runs;
  for (std::size_t j = 0; j < runs.size(); ++j) {
    const Run& right = runs[j];
    for (std::size_t i = symmetric_ ? j : 0; i < runs.size(); ++i) {
      const Run& down = runs[i];
      const double* from = child.rest + down.from + right.from * stride;
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

void Multifrontal::add_children(std::size_t node, Lane& lane, const DenseFront& front) {
  const auto is_child = [&](const Waiting& waiting) {
    return analysis().elimination.supernodes[waiting.front].parent == static_cast<int>(node);
  };
  while (!lane.waiting.empty() && is_child(lane.waiting.back())) {
    const Waiting& child = lane.waiting.back();
    const int below = analysis().fronts[child.front].below;
    if (child.on_stack) lane.top -= area(below, below);
    add_rest(child, node, lane, front);
    lane.waiting.pop_back();
  }
}

void Multifrontal::solve(const BlockVector& right, BlockVector& solution) {
  Lane& lane = lanes_[0];
  if (keeps_lower_) {
    take(right);
    threads_.take(subtrees_.size(), [&](int worker, std::size_t i) {
      const Subtree& subtree = subtrees_[i];
      Beyond beyond{subtree.beyond, pushes_.data() + subtree.pushes};
      for (std::size_t s = subtree.first; s < subtree.end; ++s)
        forward(s, lanes_[1 + index(worker)], beyond);
    });
    Beyond none;
    walk([&](std::size_t s) { forward(s, lane, none); },
         [&](const Subtree& subtree) { take_off_beyond(subtree); });
  }
  auto subtree = subtrees_.rbegin();
  for (std::size_t s = analysis().fronts.size(); s-- > 0;)
    if (subtree == subtrees_.rend() || subtree->end != s + 1)
      backward(s, lane);
    else
      s = subtree++->first;
  threads_.take(subtrees_.size(), [&](int worker, std::size_t i) {
    for (std::size_t s = subtrees_[i].end; s-- > subtrees_[i].first;)
      backward(s, lanes_[1 + index(worker)]);
  });
  for (std::size_t s = 0; s < solution.size(); ++s) {
    solution[s].setZero();
    solution[s].head(slots_->size[s]) = unknowns_of(s);
  }
}

void Multifrontal::take(const BlockVector& right) {
  for (std::size_t s = 0; s < right.size(); ++s) unknowns_of(s) = right[s].head(slots_->size[s]);
}

Eigen::VectorBlock<Eigen::VectorXd> Multifrontal::unknowns_of(std::size_t slot) {
  return vector_.segment(analysis().start[index(analysis().elimination.place_of[slot])],
                         slots_->size[slot]);
}

/// What the fronts of a subtree have taken off unknowns beyond it, in their order.
void Multifrontal::take_off_beyond(const Subtree& subtree) {
  const double* from = pushes_.data() + subtree.pushes;
  for (std::size_t s = subtree.first; s < subtree.end; ++s) {
    for (const int place : analysis().elimination.below[s]) {
      const int at = analysis().start[index(place)];
      if (at < subtree.beyond) continue;
      const int size = analysis().start[index(place) + 1] - at;
      vector_.segment(at, size) -= Eigen::Map<const Eigen::VectorXd>(from, size);
      from += size;
    }
  }
}

void Multifrontal::forward(std::size_t node, Lane& lane, Beyond& beyond) {
  const Front& front = analysis().fronts[node];
  const Columns columns = dense(front, lane).columns;
  const Factor pivot(columns.data, front.own, front.own, Eigen::OuterStride<>(columns.stride));
  auto own = vector_.segment(front.first, front.own);
  if (symmetric_) {
    pivot.triangularView<Eigen::Lower>().solveInPlace(own);
  } else {
    for (int k = 0; k < front.own; ++k) std::swap(own[k], own[exchanges_[index(front.first + k)]]);
    pivot.triangularView<Eigen::UnitLower>().solveInPlace(own);
  }
  if (front.below == 0) return;
  lane.below.noalias() = Factor(columns.data + front.own, front.below, front.own,
                                Eigen::OuterStride<>(columns.stride)) *
                         own;
  int from = 0;
  for (const int place : analysis().elimination.below[node]) {
    const int at = analysis().start[index(place)];
    const int size = analysis().start[index(place) + 1] - at;
    if (at < beyond.first)
      vector_.segment(at, size) -= lane.below.segment(from, size);
    else
      beyond.to = std::copy_n(lane.below.data() + from, size, beyond.to);
    from += size;
  }
}

void Multifrontal::backward(std::size_t node, Lane& lane) {
  const Front& front = analysis().fronts[node];
  const int height = keeps_lower_ ? front.own + front.below : front.own;
  const Factor pivot(factor_.data() + front.columns, front.own, front.own,
                     Eigen::OuterStride<>(height));
  auto own = vector_.segment(front.first, front.own);
  lane.below.resize(front.below);
  int at = 0;
  for (const int place : analysis().elimination.below[node]) {
    const int size = analysis().start[index(place) + 1] - analysis().start[index(place)];
    lane.below.segment(at, size) = vector_.segment(analysis().start[index(place)], size);
    at += size;
  }
  const double* beside = symmetric_ ? pivot.data() + front.own : factor_.data() + front.rows;
  const Factor rows(beside, front.below, front.own,
                    Eigen::OuterStride<>(symmetric_ ? height : front.below));
  own.noalias() -= rows.transpose() * lane.below;
  if (symmetric_)
    pivot.triangularView<Eigen::Lower>().transpose().solveInPlace(own);
  else
    pivot.triangularView<Eigen::Upper>().solveInPlace(own);
}

double Multifrontal::condition_estimate() const {
  return pivots_.size() == 0 ? 1.0 : pivots_.maxCoeff() / pivots_.minCoeff();
}

}  // namespace quoin::solver
