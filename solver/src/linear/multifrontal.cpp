#include "linear/multifrontal.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

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

constexpr int kPanel = 32;  // unknowns of a triangular solve at a time; what is left are products

Strided view(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  return {matrix.data(), 1, matrix.outerStride()};
}

Strided transposed(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  return {matrix.data(), matrix.outerStride(), 1};
}

}  // namespace

void Multifrontal::analyse(const BlockSystem& system) {
  const int count = slots_->count();
  pairs_ = system.pairs;
  elimination_ = make_elimination(count, pairs_);
  const auto& [node_at, place_of, supernodes] = elimination_;
  start_.assign(1, 0);
  for (const int slot : node_at) start_.push_back(start_.back() + slots_->size[index(slot)]);
  couplings_.assign(index(count), {});
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    const int first = place_of[index(pairs_[p].first)], second = place_of[index(pairs_[p].second)];
    couplings_[index(std::min(first, second))].push_back(
        {static_cast<int>(p), std::max(first, second), first > second});
  }
  local_.assign(index(count), 0);
  fronts_.assign(supernodes.size(), {});
  for (std::size_t s = 0; s < supernodes.size(); ++s) {
    const Supernode& node = supernodes[s];
    fronts_[s].own = start_[index(node.end)] - start_[index(node.first)];
    fronts_[s].first = start_[index(node.first)];
    for (const int place : node.below)
      fronts_[s].below += slots_->size[index(node_at[index(place)])];
  }
  analysed_ = true;
}

double Multifrontal::work(const BlockSystem& system) {
  if (!analysed_ || pairs_ != system.pairs) {
    analyse(system);
    placed_ = false;
  }
  double sum = 0.0;
  for (const Front& front : fronts_) {
    const double own = front.own, below = front.below;
    sum += own * (own * own / 3.0 + own * below + below * below);
  }
  return system.symmetric ? 0.5 * sum : sum;
}

/// Where the factors of each front stand, and memory for the rests that wait at the same time.
void Multifrontal::place_factors() {
  std::size_t factors = 0, columns = 0, waiting = 0, most = 0;
  std::vector<std::size_t>& taken = waiting_;  // by the rests of a front's children
  taken.assign(fronts_.size(), 0);
  for (std::size_t s = 0; s < fronts_.size(); ++s) {
    Front& front = fronts_[s];
    front.columns = factors;
    factors += area(keeps_lower_ ? front.own + front.below : front.own, front.own);
    if (!keeps_lower_) columns = std::max(columns, area(front.own + front.below, front.own));
    front.rows = factors;
    if (!symmetric_) factors += area(front.own, front.below);
    const std::size_t rest = area(front.below, front.below);
    most = std::max(most, waiting + rest);
    waiting += rest - taken[s];
    const int parent = elimination_.supernodes[s].parent;
    if (parent >= 0) taken[index(parent)] += rest;
  }
  make_room(factors, factor_);
  make_room(columns, columns_);
  make_room(most, stack_);
  pivots_.resize(slots_->unknowns());
  exchanges_.resize(fronts_.size());
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
  const int rows = symmetric_ ? 0 : front.own;
  double* columns = keeps_lower_ ? factor_.data() + front.columns : columns_.data();
  return {Matrix(columns, front.own + front.below, front.own),
          Matrix(factor_.data() + front.rows, rows, front.below),
          Matrix(rest, front.below, front.below)};
}

bool Multifrontal::factorize(const BlockSystem& system) { return factorize(system, nullptr); }

bool Multifrontal::factorize(const BlockSystem& system, const BlockVector& only) {
  return factorize(system, &only);
}

bool Multifrontal::factorize(const BlockSystem& system, const BlockVector* only) {
  if (!analysed_ || pairs_ != system.pairs) {
    analyse(system);
    placed_ = false;
  }
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
  for (std::size_t s = 0; s < fronts_.size(); ++s) {
    look();
    const Front& front = fronts_[s];
    Parts now = parts(front, stack_.data() + top);
    now.columns.setZero();
    now.rows.setZero();
    now.rest.setZero();
    add_own_blocks(system, s, now);
    while (!waiting.empty() &&
           elimination_.supernodes[waiting.back()].parent == static_cast<int>(s)) {
      const int below = fronts_[waiting.back()].below;
      top -= area(below, below);
      add_rest(waiting.back(), Matrix(stack_.data() + top, below, below), s, now);
      waiting.pop_back();
    }
    if (!(symmetric_ ? eliminate_symmetric(s, now) : eliminate_general(s, now))) return false;
    if (!keeps_lower_) {
      forward(s);
      Matrix(factor_.data() + front.columns, front.own, front.own) = now.columns.topRows(front.own);
    }
    std::copy(now.rest.data(), now.rest.data() + now.rest.size(), stack_.data() + top);
    top += area(front.below, front.below);
    waiting.push_back(s);
  }
  return true;
}

void Multifrontal::add_own_blocks(const BlockSystem& system, std::size_t node, Parts& front) {
  const Supernode& supernode = elimination_.supernodes[node];
  const int own = fronts_[node].own;
  int at = 0;
  const auto place_next = [&](int place) {
    local_[index(place)] = at;
    at += slots_->size[index(elimination_.node_at[index(place)])];
  };
  for (int place = supernode.first; place < supernode.end; ++place) place_next(place);
  for (const int place : supernode.below) place_next(place);
  for (int place = supernode.first; place < supernode.end; ++place) {
    const std::size_t slot = index(elimination_.node_at[index(place)]);
    const int size = slots_->size[slot], from = local_[index(place)];
    front.columns.block(from, from, size, size) = system.diagonal[slot].topLeftCorner(size, size);
    for (const Coupling& coupling : couplings_[index(place)]) {
      const int rows = slots_->size[index(elimination_.node_at[index(coupling.other)])];
      const int to = local_[index(coupling.other)];
      const SquareBlocks::ConstBlock upper = system.off_diagonal[index(coupling.pair)];
      auto lower_part = front.columns.block(to, from, rows, size);
      if (symmetric_) {
        if (coupling.forward) {
          lower_part = upper.topLeftCorner(rows, size);
        } else {
          lower_part = upper.topLeftCorner(size, rows).transpose();
        }
        continue;
      }
      const SquareBlocks::ConstBlock mirrored = system.mirrored[index(coupling.pair)];
      const SquareBlocks::ConstBlock &lower = coupling.forward ? upper : mirrored,
                                     &other = coupling.forward ? mirrored : upper;
      lower_part = lower.topLeftCorner(rows, size);
      if (to < own) {
        front.columns.block(from, to, size, rows) = other.topLeftCorner(size, rows);
      } else {
        front.rows.block(from, to - own, size, rows) = other.topLeftCorner(size, rows);
      }
    }
  }
}

/// What a child left, to where it belongs in the front of its parent; the lower triangle if
/// symmetric.
void Multifrontal::add_rest(std::size_t child, const Matrix& rest, std::size_t node, Parts& front) {
  const int own = fronts_[node].own;
  target_.clear();
  for (const int place : elimination_.supernodes[child].below) {
    const int size = slots_->size[index(elimination_.node_at[index(place)])];
    for (int i = 0; i < size; ++i) target_.push_back(local_[index(place)] + i);
  }
  const int count = static_cast<int>(target_.size());
  const int inside =
      static_cast<int>(std::lower_bound(target_.begin(), target_.end(), own) - target_.begin());
  for (int j = 0; j < count; ++j) {
    const double* from = rest.col(j).data();
    const int first = symmetric_ ? j : 0;
    const int column = target_[index(j)];
    if (j < inside) {
      double* to = front.columns.col(column).data();
      for (int i = first; i < count; ++i) to[target_[index(i)]] += from[i];
      continue;
    }
    if (!symmetric_) {
      double* to = front.rows.col(column - own).data();
      for (int i = 0; i < inside; ++i) to[target_[index(i)]] += from[i];
    }
    double* to = front.rest.col(column - own).data() - own;
    for (int i = std::max(first, inside); i < count; ++i) to[target_[index(i)]] += from[i];
  }
}

bool Multifrontal::eliminate_symmetric(std::size_t node, Parts& parts) {
  const Front& front = fronts_[node];
  Eigen::Ref<Eigen::MatrixXd> pivot = parts.columns.topRows(front.own);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(pivot);  // in place
  const bool positive = (pivot.diagonal().array() > 0.0).all();   // false of NaN
  if (cholesky.info() != Eigen::Success || !positive) return false;
  pivots_.segment(front.first, front.own) = pivot.diagonal().array().square();
  if (front.below == 0) return true;
  Eigen::Ref<Eigen::MatrixXd> below = parts.columns.bottomRows(front.below);
  for (int at = 0; at < front.own; at += kPanel) {
    look();
    const int width = std::min(kPanel, front.own - at);
    auto panel = below.middleCols(at, width);
    subtract_(view(below), transposed(pivot.middleRows(at, width)), at, Triangle::Both, panel);
    pivot.block(at, at, width, width)
        .triangularView<Eigen::Lower>()
        .transpose()
        .solveInPlace<Eigen::OnTheRight>(panel);
  }
  subtract_(view(below), transposed(below), front.own, Triangle::Lower, parts.rest);
  return true;
}

bool Multifrontal::eliminate_general(std::size_t node, Parts& parts) {
  const Front& front = fronts_[node];
  Eigen::Ref<Eigen::MatrixXd> pivot = parts.columns.topRows(front.own);
  const Eigen::PartialPivLU<Eigen::Ref<Eigen::MatrixXd>> lu(pivot);  // in place
  pivots_.segment(front.first, front.own) = pivot.diagonal().cwiseAbs();
  exchanges_[node] = lu.permutationP();
  if (!(pivots_.segment(front.first, front.own).minCoeff() > 0.0)) return false;
  if (front.below == 0) return true;
  Eigen::Ref<Eigen::MatrixXd> below = parts.columns.bottomRows(front.below);
  Matrix& rows = parts.rows;
  rows = exchanges_[node] * rows;
  for (int at = 0; at < front.own; at += kPanel) {
    look();
    const int width = std::min(kPanel, front.own - at);
    const auto corner = pivot.block(at, at, width, width);
    auto right = below.middleCols(at, width);
    subtract_(view(below), view(pivot.middleCols(at, width)), at, Triangle::Both, right);
    corner.triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(right);
    auto down = rows.middleRows(at, width);
    subtract_(view(pivot.middleRows(at, width)), view(rows), at, Triangle::Both, down);
    corner.triangularView<Eigen::UnitLower>().solveInPlace(down);
  }
  subtract_(view(below), view(rows), front.own, Triangle::Both, parts.rest);
  return true;
}

void Multifrontal::solve(const BlockVector& right, BlockVector& solution) {
  if (keeps_lower_) {
    take(right);
    for (std::size_t s = 0; s < fronts_.size(); ++s) forward(s);
  }
  for (std::size_t s = fronts_.size(); s-- > 0;) backward(s);
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
  return vector_.segment(start_[index(elimination_.place_of[slot])], slots_->size[slot]);
}

void Multifrontal::forward(std::size_t node) {
  const Front& front = fronts_[node];
  const Parts factors = parts(front, nullptr);
  const auto pivot = factors.columns.topRows(front.own);
  auto own = vector_.segment(front.first, front.own);
  if (symmetric_) {
    pivot.triangularView<Eigen::Lower>().solveInPlace(own);
  } else {
    own = exchanges_[node] * own;
    pivot.triangularView<Eigen::UnitLower>().solveInPlace(own);
  }
  if (front.below == 0) return;
  below_.noalias() = factors.columns.bottomRows(front.below) * own;
  int at = 0;
  for (const int place : elimination_.supernodes[node].below) {
    const int size = start_[index(place) + 1] - start_[index(place)];
    vector_.segment(start_[index(place)], size) -= below_.segment(at, size);
    at += size;
  }
}

void Multifrontal::backward(std::size_t node) {
  const Front& front = fronts_[node];
  const Parts factors = parts(front, nullptr);
  const Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>> pivot(
      factor_.data() + front.columns, front.own, front.own,
      Eigen::OuterStride<>(keeps_lower_ ? front.own + front.below : front.own));
  auto own = vector_.segment(front.first, front.own);
  below_.resize(front.below);
  int at = 0;
  for (const int place : elimination_.supernodes[node].below) {
    const int size = start_[index(place) + 1] - start_[index(place)];
    below_.segment(at, size) = vector_.segment(start_[index(place)], size);
    at += size;
  }
  if (symmetric_) {
    own.noalias() -= factors.columns.bottomRows(front.below).transpose() * below_;
    pivot.triangularView<Eigen::Lower>().transpose().solveInPlace(own);
  } else {
    own.noalias() -= factors.rows * below_;
    pivot.triangularView<Eigen::Upper>().solveInPlace(own);
  }
}

double Multifrontal::condition_estimate() const {
  return pivots_.size() == 0 ? 1.0 : pivots_.maxCoeff() / pivots_.minCoeff();
}

}  // namespace quoin::solver
