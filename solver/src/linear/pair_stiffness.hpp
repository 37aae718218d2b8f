#pragma once
/// What contacts add to the matrix of the blocks.

#include <algorithm>
#include <array>

#include "base/index.hpp"
#include "block/block_system.hpp"
#include "contact/linear_contact.hpp"
#include "linear/front_kernels.hpp"

namespace quoin::solver {

/// [J_a J_b] of a contact, by rows.
template <int n>
using ContactRows = Eigen::Matrix<double, 3, 2 * n, Eigen::RowMajor>;

/// Adds Jᵀ T J to a matrix of which it owns the rows of a range of slots; a pair is its earlier
/// slot's. Neighbouring contacts of the same two blocks are one product. The last ones are added by
/// flush().
template <int n>
class PairStiffness {
  using Square = Eigen::Matrix<double, 2 * n, 2 * n>;

 public:
  PairStiffness(BlockSystem& system, std::size_t first, std::size_t end)
      : system_(&system), first_(static_cast<int>(first)), end_(static_cast<int>(end)) {}

  /// To be asked of each contact that adds anything, in their order, whatever the range: so that
  /// the same ones are added together. False: none of its slots is owned.
  bool next(const LinearContact& c) {
    if (c.slot_a != of_.a || c.slot_b != of_.b || c.pair != of_.pair) flush();
    of_ = {c.slot_a, c.slot_b, c.pair};
    return owns(of_.a) || owns(of_.b);
  }

  /// The contact that next() was asked of. `tangent`: T.
  template <class Rows>
  void add(const Rows& rows, const Matrix3& tangent) {
    if (count_ == kMost) flush();
    Eigen::Map<ContactRows<n>> own(rows_.data() + count_ * kNumbers),
        pushed(pushed_.data() + count_ * kNumbers);
    own = rows;
    for (int k = 0; k < 3; ++k) {
      const double t0 = tangent(k, 0), t1 = tangent(k, 1), t2 = tangent(k, 2);
      for (int j = 0; j < 2 * n; ++j)
        pushed(k, j) = -(t0 * own(0, j) + t1 * own(1, j) + t2 * own(2, j));
    }
    ++count_;
  }

  void flush() {
    if (count_ == 0) return;
    Square sum = Square::Zero();
    const Eigen::Index depth = 3 * count_;
    const Eigen::Map<const Eigen::MatrixXd> left(rows_.data(), 2 * n, depth);
    subtract_product(left, {pushed_.data(), 2 * n, 1}, sum);
    const auto part = [&](int row, int column) {
      return sum.template block<n, n>(row * n, column * n);
    };
    count_ = 0;
    if (owns(of_.a)) system_->diagonal.template part<n>(index(of_.a)) += part(0, 0);
    if (owns(of_.b)) system_->diagonal.template part<n>(index(of_.b)) += part(1, 1);
    if (of_.pair < 0 || !owns(std::min(of_.a, of_.b))) return;
    const int earlier = of_.a < of_.b ? 0 : 1, later = 1 - earlier;
    system_->off_diagonal.template part<n>(index(of_.pair)) += part(earlier, later);
    if (system_->symmetric) return;
    system_->mirrored.template part<n>(index(of_.pair)) += part(later, earlier);
  }

 private:
  static constexpr int kMost = 8;  // contacts of a product: those of two faces with eight corners
  static constexpr int kNumbers = 6 * n;

  bool owns(int slot) const { return slot >= first_ && slot < end_; }

  struct Blocks {
    int a = -1, b = -1, pair = -1;
  };

  BlockSystem* system_;
  int first_, end_;
  Blocks of_;  // of the contacts that wait
  int count_ = 0;
  std::array<double, kMost * kNumbers> rows_, pushed_;  // of these, J and - T J
};

}  // namespace quoin::solver
