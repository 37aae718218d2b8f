#pragma once
/// Sparse matrix of 6×6 and 12×12 blocks, and the vectors that go with it.

#include <algorithm>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "block/displacement.hpp"

namespace quoin::solver {

/// Which blocks have unknowns and where they stand in the global vector.
struct Slots {
  std::vector<int> slot_of_block;  ///< -1: no unknowns
  std::vector<int> block_of_slot;
  std::vector<int> size;       ///< 6 or 12, per slot
  std::vector<int> start;      ///< per slot, and the total at the end
  std::vector<double> length;  ///< block size, per slot, m: turns moments into forces
  int count() const { return static_cast<int>(size.size()); }
  int unknowns() const { return start.empty() ? 0 : start.back(); }
  bool rigid() const { return unknowns() == 6 * count(); }  ///< no block deforms
  int width() const { return rigid() ? 6 : 12; }
};

/// Calls work(n), n the unknowns of each block, at most, as a constant: 6 or 12.
template <class Work>
decltype(auto) at_width(const Slots& slots, const Work& work) {
  if (slots.rigid()) return work(std::integral_constant<int, 6>());
  return work(std::integral_constant<int, 12>());
}

Slots make_slots(const std::vector<int>& unknowns_of_block,
                 const std::vector<double>& size_of_block);

/// Largest of |force|, |moment| / length and |strain moment| / length, N.
double force_size(const Vector12& force, double length);

/// Of a block's points, m.
double motion_of(const Vector12& increment, double length);

/// Where a block stands and how its own axes do: what its rigid motions are taken from.
struct Frame {
  Vector3 place = Vector3::Zero();         ///< of the centroid, m
  Matrix3 rotation = Matrix3::Identity();  ///< own axes to the world's
};

/// A square part of a block.
template <int n>
using Part = Eigen::Map<Eigen::Matrix<double, n, n>, Eigen::Unaligned, Eigen::OuterStride<>>;
template <int n>
using ConstPart =
    Eigen::Map<const Eigen::Matrix<double, n, n>, Eigen::Unaligned, Eigen::OuterStride<>>;

/// Square matrices of one width, one after the other.
class SquareBlocks {
 public:
  using Block = Eigen::Map<Eigen::MatrixXd>;
  using ConstBlock = Eigen::Map<const Eigen::MatrixXd>;

  /// Values are kept while the width stays, those of new blocks are zero.
  void resize(std::size_t count, int width) {
    if (width != width_) values_.clear();
    width_ = width;
    count_ = count;
    values_.resize(count * area());
  }
  void set_zero() { std::ranges::fill(values_, 0.0); }

  std::size_t size() const { return count_; }
  int width() const { return width_; }
  std::size_t area() const { return static_cast<std::size_t>(width_ * width_); }  ///< of a matrix
  std::span<double> values() { return values_; }  ///< of all, one matrix after the other
  Block operator[](std::size_t i) { return {values_.data() + i * area(), width_, width_}; }
  ConstBlock operator[](std::size_t i) const {
    return {values_.data() + i * area(), width_, width_};
  }
  /// Block i, or its transpose, by the leading entries of `v`; the others of the result are zero.
  Vector12 times(std::size_t i, const Vector12& v, bool transposed = false) const;
  /// Of block i, n×n from row and column `first` on.
  template <int n>
  Part<n> part(std::size_t i, int first = 0) {
    return Part<n>(values_.data() + i * area() + corner(first), Eigen::OuterStride<>(width_));
  }
  template <int n>
  ConstPart<n> part(std::size_t i, int first = 0) const {
    return ConstPart<n>(values_.data() + i * area() + corner(first), Eigen::OuterStride<>(width_));
  }

 private:
  std::size_t corner(int first) const { return static_cast<std::size_t>(first * (width_ + 1)); }

  int width_ = 6;
  std::size_t count_ = 0;
  std::vector<double> values_;
};

/// Diagonal blocks by slot, off-diagonal blocks (i < j) by pair, all of Slots::width(). Only the
/// leading size×size part counts.
struct BlockSystem {
  SquareBlocks diagonal;
  std::vector<std::pair<int, int>> pairs;  ///< ascending
  SquareBlocks off_diagonal;               ///< rows of pair.first, columns of pair.second
  SquareBlocks mirrored;                   ///< rows of pair.second; only where not symmetric
  bool symmetric = true;
  std::vector<Frame> frames;  ///< by slot; empty: not known
};

/// Pairs of slots that contacts couple, and which pair each contact belongs to. `first`, `second`:
/// its slots; -1: none.
template <class Contact, class Slot>
void set_pairs(std::span<Contact> contacts, Slot first, Slot second,
               std::vector<std::pair<int, int>>& pairs) {
  const auto coupled = [&](const Contact& c) { return c.*first >= 0 && c.*second >= 0; };
  const auto pair = [&](const Contact& c) -> std::pair<int, int> {
    return std::minmax(c.*first, c.*second);
  };
  pairs.clear();
  for (const Contact& c : contacts)
    if (coupled(c)) pairs.push_back(pair(c));
  std::ranges::sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  for (Contact& c : contacts) {
    if (!coupled(c)) continue;
    c.pair = static_cast<int>(std::ranges::lower_bound(pairs, pair(c)) - pairs.begin());
  }
}

using BlockVector = std::vector<Vector12>;  ///< by slot; unused tail entries are zero

/// Of the blocks' points, m.
double largest_motion(const Slots& slots, const BlockVector& increment);

}  // namespace quoin::solver
