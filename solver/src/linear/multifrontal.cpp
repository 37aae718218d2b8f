#include "linear/multifrontal.hpp"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/index.hpp"

namespace quoin::solver {
namespace {

constexpr double kZeros = 0.05;  // share of a supernode that may be zeros; 0.1 and 0.25 were slower
constexpr int kWidest = 24;      // nodes in one: the most of the work is then in products of fronts

/// Node at each place.
std::vector<int> minimum_degree(int count, std::span<const std::pair<int, int>> pairs) {
  Lists upper = make_lists(index(count), [&](const auto& add) {  // by column
    for (const auto& [i, j] : pairs) add(std::max(i, j), std::min(i, j));
    for (int i = 0; i < count; ++i) add(i, i);
  });
  for (std::size_t j = 0; j < upper.size(); ++j)
    std::sort(upper.entries.begin() + upper.start[j], upper.entries.begin() + upper.start[j + 1]);
  const std::vector<double> ones(upper.entries.size(), 1.0);
  const Eigen::Map<const Eigen::SparseMatrix<double>> graph(
      count, count, static_cast<long>(ones.size()), upper.start.data(), upper.entries.data(),
      ones.data());
  Eigen::AMDOrdering<int>::PermutationType order;
  Eigen::AMDOrdering<int>()(graph.selfadjointView<Eigen::Upper>(), order);
  return {order.indices().data(), order.indices().data() + count};
}

std::vector<int> inverse(const std::vector<int>& order) {
  std::vector<int> places(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) places[index(order[i])] = static_cast<int>(i);
  return places;
}

/// Of each place, the places it is coupled with: the earlier ones, or the later ones.
enum class Side : char { Earlier, Later };
Lists neighbours(std::span<const std::pair<int, int>> pairs, const std::vector<int>& place_of,
                 Side side) {
  return make_lists(place_of.size(), [&](const auto& add) {
    for (const auto& [i, j] : pairs) {
      const auto [low, high] = std::minmax(place_of[index(i)], place_of[index(j)]);
      side == Side::Earlier ? add(high, low) : add(low, high);
    }
  });
}

/// Parent of each place: the first later one that its elimination changes, -1: none.   [Liu 1990]
std::vector<int> elimination_tree(const Lists& earlier) {
  std::vector<int> parent(earlier.size(), -1), root(earlier.size(), -1);
  for (std::size_t j = 0; j < earlier.size(); ++j) {
    for (int i : earlier[j]) {
      while (i != -1 && i < static_cast<int>(j)) {  // up to the root, which j becomes
        const int next = std::exchange(root[index(i)], static_cast<int>(j));
        if (next == -1) parent[index(i)] = static_cast<int>(j);
        i = next;
      }
    }
  }
  return parent;
}

/// Of each place, those that it is the parent of, ascending.
Lists children_of(const std::vector<int>& parent) {
  return make_lists(parent.size(), [&](const auto& add) {
    for (std::size_t i = 0; i < parent.size(); ++i)
      if (parent[i] >= 0) add(parent[i], static_cast<int>(i));
  });
}

/// Places in the order of a walk that leaves each tree by its root, the deepest branch of it last.
std::vector<int> postorder(const std::vector<int>& parent) {
  const std::size_t n = parent.size();
  std::vector<int> weight(n, 1);
  for (std::size_t i = 0; i < n; ++i)
    if (parent[i] >= 0)
      weight[index(parent[i])] = std::max(weight[index(parent[i])], weight[i] + 1);
  Lists children = children_of(parent);
  const auto lighter = [&](int a, int b) {
    return std::pair(weight[index(a)], a) < std::pair(weight[index(b)], b);
  };
  std::vector<int> open, order;
  for (std::size_t i = 0; i < n; ++i) {
    if (parent[i] < 0) open.push_back(static_cast<int>(i));
    std::sort(children.entries.begin() + children.start[i],
              children.entries.begin() + children.start[i + 1], lighter);
  }
  order.reserve(n);
  while (!open.empty()) {  // a walk from the roots, the last child first, read backwards
    const int place = open.back();
    open.pop_back();
    order.push_back(place);
    for (const int child : children[index(place)]) open.push_back(child);
  }
  std::reverse(order.begin(), order.end());
  return order;
}

/// Of each place, the later ones that are coupled with it once all before it are eliminated,
/// ascending: its own, and its children's.
Lists filled_columns(const Lists& later, const std::vector<int>& parent) {
  const Lists children = children_of(parent);
  Lists below;
  below.start.reserve(later.start.size());
  below.entries.reserve(2 * later.entries.size());
  std::vector<std::size_t> seen_by(later.size(), later.size());
  for (std::size_t j = 0; j < later.size(); ++j) {
    const auto add = [&](int place) {
      if (place == static_cast<int>(j) || std::exchange(seen_by[index(place)], j) == j) return;
      below.entries.push_back(place);
    };
    for (const int place : later[j]) add(place);
    for (const int child : children[j]) {
      const auto end = index(below.start[index(child) + 1]);  // entries move as they grow
      for (auto i = index(below.start[index(child)]); i < end; ++i) add(below.entries[i]);
    }
    std::sort(below.entries.begin() + below.start[j], below.entries.end());
    below.start.push_back(static_cast<int>(below.entries.size()));
  }
  return below;
}

/// Joins each place with the one before it where that adds few zeros. `below`: by place.
std::vector<Supernode> join(const Lists& below, const std::vector<int>& parent) {
  std::vector<Supernode> supernodes;
  std::vector<double> zeros;                      // of each, in its columns
  const auto rows = [&](const Supernode& node) {  // below it: those of its last place
    return static_cast<double>(below[index(node.end) - 1].size());
  };
  for (std::size_t j = 0; j < below.size(); ++j) {
    Supernode next{static_cast<int>(j), static_cast<int>(j) + 1};
    const double below_rows = rows(next);
    double next_zeros = 0.0;
    while (!supernodes.empty()) {
      const Supernode& child = supernodes.back();
      const int above = parent[index(child.end - 1)];
      if (above < next.first || above >= next.end) break;
      const double width = child.end - child.first;
      const double columns = next.end - child.first;
      const double added =
          zeros.back() + next_zeros + width * (columns - width + below_rows - rows(child));
      if (columns > kWidest || added > kZeros * columns * (0.5 * columns + below_rows)) break;
      next.first = child.first;
      next_zeros = added;
      supernodes.pop_back();
      zeros.pop_back();
    }
    supernodes.push_back(next);
    zeros.push_back(next_zeros);
  }
  return supernodes;
}

/// `below`: by place.
void set_below(const Lists& below, Elimination& result) {
  std::vector<int> supernode_of(below.size());
  for (std::size_t s = 0; s < result.supernodes.size(); ++s) {
    const Supernode& node = result.supernodes[s];
    std::fill(supernode_of.begin() + node.first, supernode_of.begin() + node.end,
              static_cast<int>(s));
    const std::span<const int> rows = below[index(node.end) - 1];
    result.below.entries.insert(result.below.entries.end(), rows.begin(), rows.end());
    result.below.start.push_back(static_cast<int>(result.below.entries.size()));
  }
  for (std::size_t s = 0; s < result.supernodes.size(); ++s) {
    const std::span<const int> rows = result.below[s];
    if (!rows.empty()) result.supernodes[s].parent = supernode_of[index(rows.front())];
  }
}

/// For `count` nodes of which `pairs` (i < j) are coupled: minimum degree, then a postorder of the
/// elimination tree, then supernodes that may hold a few zeros.
/// Sources: [Amestoy, Davis & Duff 1996]; [Liu 1990] for tree and supernodes.
Elimination make_elimination(int count, std::span<const std::pair<int, int>> pairs) {
  Elimination result;
  const std::vector<int> order = minimum_degree(count, pairs);
  const Lists first = neighbours(pairs, inverse(order), Side::Earlier);
  result.node_at.reserve(index(count));
  for (const int place : postorder(elimination_tree(first)))
    result.node_at.push_back(order[index(place)]);
  result.place_of = inverse(result.node_at);
  const std::vector<int> parent =
      elimination_tree(neighbours(pairs, result.place_of, Side::Earlier));
  const Lists below = filled_columns(neighbours(pairs, result.place_of, Side::Later), parent);
  result.supernodes = join(below, parent);
  set_below(below, result);
  return result;
}

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

// An analysis takes as long as so many multiplications of the factors for each block and pair; of
// these a share of zero pairs saves three times its share at least. Measured on shaken walls of 105
// and 1012 bricks and a sliding slope of 512 blocks (bench/tried.md).
constexpr double kAnalysis = 4.6e3;
constexpr double kSaved = 3.0;
constexpr int kNode = 6;     // sizes are multiples of this: a block has 6 or 12 unknowns
constexpr long kStrip = 24;  // rows that a thread takes at a time: a tile of the widest kernels
constexpr long kShared = 8;  // strips of a front that threads share: some 0.1 ms

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

enum class Diagonal { Own, Ones };

/// x U = x by rows, with U upper triangular.
void solve_rows(Strided upper, Diagonal diagonal, Eigen::Ref<Eigen::MatrixXd> x) {
  for (Eigen::Index at = 0; at < x.cols(); at += kNode) {
    subtract_product(x.leftCols(at), upper.at(0, at), x.middleCols(at, kNode));
    for (Eigen::Index j = at; j < at + kNode; ++j) {
      for (Eigen::Index k = at; k < j; ++k) x.col(j) -= *upper.at(k, j).data * x.col(k);
      if (diagonal == Diagonal::Own) x.col(j) *= 1.0 / *upper.at(j, j).data;
    }
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

int Multifrontal::size_at(int place) const {
  return analysis().start[index(place) + 1] - analysis().start[index(place)];
}

/// Where the factors of each front stand, and room for the rests that wait at the same time.
void Multifrontal::place_factors() {
  std::size_t factors = 0, waiting = 0, most = 0;
  std::vector<Front>& fronts = (in_part_ ? part_ : whole_).fronts;
  taken_.assign(fronts.size(), 0);
  for (std::size_t s = 0; s < fronts.size(); ++s) {
    Front& front = fronts[s];
    front.columns = factors;
    factors += area(front.own + front.below, front.own);
    front.rows = factors;
    if (!symmetric_) factors += area(front.own, front.below);
    const std::size_t rest = area(front.below, front.below);
    most = std::max(most, waiting + rest);
    waiting += rest - taken_[s];
    const int parent = analysis().elimination.supernodes[s].parent;
    if (parent >= 0) taken_[index(parent)] += rest;
  }
  make_room(factors, factor_);
  if (stack_.size() < most) make_room(most, stack_);
  local_.resize(index(slots_->count()));
  pivots_.resize(slots_->unknowns());
  exchanges_.resize(index(slots_->unknowns()));
  vector_.resize(slots_->unknowns());
}

void Multifrontal::release() {
  solver::release(factor_);
  solver::release(stack_);
  placed_ = false;
}

Multifrontal::Dense Multifrontal::dense(const Front& front) {
  const int own = front.own, below = front.below;
  return {
      Matrix(factor_.data() + front.columns, own + below, own, Eigen::OuterStride<>(own + below)),
      Matrix(factor_.data() + front.rows, below, symmetric_ ? 0 : own, Eigen::OuterStride<>(below)),
      Matrix(stack_.data() + top_, below, below, Eigen::OuterStride<>(below))};
}

bool Multifrontal::factorize(const BlockSystem& system) {
  choose_analysis(system);
  if (!placed_ || symmetric_ != system.symmetric) {
    symmetric_ = system.symmetric;
    place_factors();
    placed_ = true;
  }
  waiting_.clear();
  top_ = 0;
  for (std::size_t s = 0; s < analysis().fronts.size(); ++s)
    if (!eliminate(system, s)) return false;
  return true;
}

/// A front, once its children are.
bool Multifrontal::eliminate(const BlockSystem& system, std::size_t node) {
  const Front& front = analysis().fronts[node];
  Dense now = dense(front);
  for (Matrix* part : {&now.columns, &now.rows, &now.rest}) part->setZero();
  add_own_blocks(system, node, now);
  const auto is_child = [&](const Waiting& waiting) {
    return analysis().elimination.supernodes[waiting.front].parent == static_cast<int>(node);
  };
  for (; !waiting_.empty() && is_child(waiting_.back()); waiting_.pop_back()) {
    top_ = waiting_.back().rest;
    add_rest(waiting_.back(), node, now);
  }
  double* pivots = pivots_.data() + front.first;
  const bool sound = symmetric_ ? eliminate_symmetric(now, pivots)
                                : eliminate_general(now, pivots, exchanges_.data() + front.first);
  if (!sound) return false;
  const std::size_t rest = area(front.below, front.below);
  std::copy_n(now.rest.data(), rest, stack_.data() + top_);
  waiting_.push_back({node, top_});
  top_ += rest;
  return true;
}

/// Calls work(first, count) for strips that make up `rows`, the same for any number of threads.
template <class Work>
void Multifrontal::each_strip(long rows, const Work& work) const {
  const long strips = (rows + kStrip - 1) / kStrip;
  const auto take = [&](int, std::size_t i) {
    if (watch_ != nullptr && strips > 1) watch_->look();  // small fronts take less than a look
    const long first = (strips - 1 - static_cast<long>(i)) * kStrip;  // triangles: longest first
    work(first, std::min(kStrip, rows - first));
  };
  (strips > kShared ? threads_ : Threads()).take(static_cast<std::size_t>(strips), take);
}

/// L L^T. Sets `pivots` of the own unknowns. False: not positive definite.
bool Multifrontal::eliminate_symmetric(Dense& front, double* pivots) const {
  const Eigen::Index own = front.columns.cols(), below = front.rest.rows();
  auto square = front.columns.topRows(own);
  auto under = front.columns.bottomRows(below);
  for (Eigen::Index at = 0; at < own; at += kNode) {
    for (Eigen::Index k = at; k < at + kNode; ++k) {
      if (!(square(k, k) > 0.0)) return false;
      const double root = square(k, k) = std::sqrt(square(k, k));
      pivots[k] = root * root;
      square.col(k).segment(k + 1, at + kNode - k - 1) *= 1.0 / root;
      for (Eigen::Index j = k + 1; j < at + kNode; ++j)
        for (Eigen::Index i = j; i < at + kNode; ++i) square(i, j) -= square(i, k) * square(j, k);
    }
    const Eigen::Index left = own - at - kNode;
    auto panel = square.block(at + kNode, at, left, kNode);
    solve_rows(transposed(square.block(at, at, kNode, kNode)), Diagonal::Own, panel);
    subtract_product(panel, transposed(panel), square.bottomRightCorner(left, left));
  }
  each_strip(below, [&](long first, long count) {
    solve_rows(transposed(square), Diagonal::Own, under.middleRows(first, count));
  });
  each_strip(below, [&](long first, long count) {
    subtract_product(under.middleRows(first, count), transposed(under),
                     front.rest.block(first, 0, count, first + count));
  });
  return true;
}

/// L U with exchanges of own rows; `exchanges`: with which row each has changed. False: singular.
bool Multifrontal::eliminate_general(Dense& front, double* pivots, int* exchanges) const {
  const Eigen::Index own = front.columns.cols(), below = front.rest.rows();
  auto square = front.columns.topRows(own);
  auto under = front.columns.bottomRows(below);
  for (Eigen::Index at = 0; at < own; at += kNode) {
    const Eigen::Index next = at + kNode, left = own - next;
    for (Eigen::Index k = at; k < next; ++k) {
      Eigen::Index best = 0;
      pivots[k] = square.col(k).tail(own - k).cwiseAbs().maxCoeff(&best);
      if (!(pivots[k] > 0.0)) return false;
      best += k;
      exchanges[k] = static_cast<int>(best);
      if (best != k) {
        square.row(k).swap(square.row(best));
        front.rows.col(k).swap(front.rows.col(best));
      }
      auto lower = square.col(k).tail(own - k - 1);
      lower *= 1.0 / square(k, k);
      for (Eigen::Index j = k + 1; j < next; ++j)
        square.col(j).tail(own - k - 1) -= square(k, j) * lower;
    }
    auto right = square.block(at, next, kNode, left);
    for (Eigen::Index k = 0; k + 1 < kNode; ++k)
      for (Eigen::Index j = 0; j < left; ++j)
        right.col(j).tail(kNode - k - 1) -=
            right(k, j) * square.col(at + k).segment(at + k + 1, kNode - k - 1);
    subtract_product(square.block(next, at, left, kNode), as_is(right),
                     square.bottomRightCorner(left, left));
  }
  each_strip(below, [&](long first, long count) {
    solve_rows(as_is(square), Diagonal::Own, under.middleRows(first, count));
    solve_rows(transposed(square), Diagonal::Ones, front.rows.middleRows(first, count));
  });
  each_strip(below, [&](long first, long count) {
    subtract_product(under.middleRows(first, count), transposed(front.rows),
                     front.rest.middleRows(first, count));
  });
  return true;
}

void Multifrontal::add_own_blocks(const BlockSystem& system, std::size_t node, Dense& front) {
  const Supernode& supernode = analysis().elimination.supernodes[node];
  const int own = analysis().fronts[node].own;
  int at = 0;
  const auto place_next = [&](int place) {
    local_[index(place)] = at;
    at += size_at(place);
  };
  for (int place = supernode.first; place < supernode.end; ++place) place_next(place);
  for (const int place : analysis().elimination.below[node]) place_next(place);
  for (int place = supernode.first; place < supernode.end; ++place) {
    const std::size_t slot = index(analysis().elimination.node_at[index(place)]);
    const int size = slots_->size[slot], from = local_[index(place)];
    front.columns.block(from, from, size, size) = system.diagonal[slot].topLeftCorner(size, size);
    for (const Coupling& coupling : analysis().couplings[index(place)]) {
      const int rows = size_at(coupling.other), to = local_[index(coupling.other)];
      const std::size_t pair = index(coupling.pair);
      const auto upper = system.off_diagonal[pair];
      const auto mirrored = symmetric_ ? upper : system.mirrored[pair];
      auto lower_part = front.columns.block(to, from, rows, size);
      if (coupling.forward)
        lower_part = upper.topLeftCorner(rows, size);
      else if (symmetric_)
        lower_part = upper.topLeftCorner(size, rows).transpose();
      else
        lower_part = mirrored.topLeftCorner(rows, size);
      if (symmetric_) continue;
      const auto other = (coupling.forward ? mirrored : upper).topLeftCorner(size, rows);
      if (to < own)
        front.columns.block(from, to, size, rows) = other;
      else
        front.rows.block(to - own, from, rows, size) = other.transpose();
    }
  }
}

/// What a child left, to where it belongs in the front of its parent; the lower triangle if
/// symmetric.
void Multifrontal::add_rest(const Waiting& child, std::size_t node, Dense& front) {
  const int own = analysis().fronts[node].own, below = analysis().fronts[child.front].below;
  const Matrix rest(stack_.data() + child.rest, below, below, Eigen::OuterStride<>(below));
  const std::span<const int> places = analysis().elimination.below[child.front];
  const auto take_run =
      [&](std::size_t& k) {  // of places that stand side by side, on one side of own
        const int at = local_[index(places[k])];
        int size = size_at(places[k++]);
        while (k < places.size() && local_[index(places[k])] == at + size && at + size != own)
          size += size_at(places[k++]);
        return std::pair(at, size);
      };
  int right = 0;
  for (std::size_t j = 0; j < places.size();) {
    const std::size_t first = symmetric_ ? j : 0;
    const auto [to, columns] = take_run(j);
    int down = symmetric_ ? right : 0;
    for (std::size_t i = first; i < places.size();) {
      const auto [at, rows] = take_run(i);
      const auto part = rest.block(down, right, rows, columns);
      if (to < own)
        front.columns.block(at, to, rows, columns) += part;
      else if (at < own)
        front.rows.block(to - own, at, columns, rows) += part.transpose();
      else
        front.rest.block(at - own, to - own, rows, columns) += part;
      down += rows;
    }
    right += columns;
  }
}

void Multifrontal::solve(const BlockVector& right, BlockVector& solution) {
  top_ = 0;
  for (std::size_t s = 0; s < right.size(); ++s) unknowns_of(s) = right[s].head(slots_->size[s]);
  for (std::size_t s = 0; s < analysis().fronts.size(); ++s) forward(s);
  for (std::size_t s = analysis().fronts.size(); s-- > 0;) backward(s);
  for (std::size_t s = 0; s < solution.size(); ++s) {
    solution[s].setZero();
    solution[s].head(slots_->size[s]) = unknowns_of(s);
  }
}

Eigen::VectorBlock<Eigen::VectorXd> Multifrontal::unknowns_of(std::size_t slot) {
  return vector_.segment(analysis().start[index(analysis().elimination.place_of[slot])],
                         slots_->size[slot]);
}

void Multifrontal::forward(std::size_t node) {
  const Front& front = analysis().fronts[node];
  const Dense factors = dense(front);
  const auto pivot = factors.columns.topRows(front.own);
  auto own = vector_.segment(front.first, front.own);
  if (symmetric_) {
    pivot.triangularView<Eigen::Lower>().solveInPlace(own);
  } else {
    for (int k = 0; k < front.own; ++k) std::swap(own[k], own[exchanges_[index(front.first + k)]]);
    pivot.triangularView<Eigen::UnitLower>().solveInPlace(own);
  }
  below_.noalias() = factors.columns.bottomRows(front.below) * own;
  int from = 0;
  for (const int place : analysis().elimination.below[node]) {
    vector_.segment(analysis().start[index(place)], size_at(place)) -=
        below_.segment(from, size_at(place));
    from += size_at(place);
  }
}

void Multifrontal::backward(std::size_t node) {
  const Front& front = analysis().fronts[node];
  const Dense factors = dense(front);
  const auto pivot = factors.columns.topRows(front.own);
  auto own = vector_.segment(front.first, front.own);
  below_.resize(front.below);
  int at = 0;
  for (const int place : analysis().elimination.below[node]) {
    below_.segment(at, size_at(place)) =
        vector_.segment(analysis().start[index(place)], size_at(place));
    at += size_at(place);
  }
  if (symmetric_) {
    own.noalias() -= factors.columns.bottomRows(front.below).transpose() * below_;
    pivot.triangularView<Eigen::Lower>().transpose().solveInPlace(own);
  } else {
    own.noalias() -= factors.rows.transpose() * below_;
    pivot.triangularView<Eigen::Upper>().solveInPlace(own);
  }
}

double Multifrontal::condition_estimate() const {
  return pivots_.size() == 0 ? 1.0 : pivots_.maxCoeff() / pivots_.minCoeff();
}

}  // namespace quoin::solver
