#include "block/block_system.hpp"

#include <algorithm>

namespace quoin::solver {

Slots make_slots(const std::vector<int>& unknowns_of_block,
                 const std::vector<double>& size_of_block) {
  Slots slots;
  slots.slot_of_block.assign(unknowns_of_block.size(), -1);
  slots.start.push_back(0);
  for (std::size_t b = 0; b < unknowns_of_block.size(); ++b) {
    if (unknowns_of_block[b] == 0) continue;
    slots.slot_of_block[b] = slots.count();
    slots.block_of_slot.push_back(static_cast<int>(b));
    slots.size.push_back(unknowns_of_block[b]);
    slots.start.push_back(slots.start.back() + unknowns_of_block[b]);
    slots.length.push_back(size_of_block[b]);
  }
  return slots;
}

namespace {

template <int n>
Vector12 times_of(const double* column, const Vector12& v, bool transposed) {
  double sum[n] = {};  // not in the result, which the matrix might be in for all that gcc knows
  for (int k = 0; k < n; ++k, column += n) {
    if (transposed)
      for (int row = 0; row < n; ++row) sum[k] += column[row] * v[row];
    else
      for (int row = 0; row < n; ++row) sum[row] += column[row] * v[k];
  }
  Vector12 result = Vector12::Zero();
  std::copy_n(sum, n, result.data());
  return result;
}

}  // namespace

Vector12 SquareBlocks::times(std::size_t i, const Vector12& v, bool transposed) const {
  return (width_ == 6 ? times_of<6> : times_of<12>)(values_.data() + i * area(), v, transposed);
}

double force_size(const Vector12& force, double length) {
  return std::max({force.head<3>().norm(), force.segment<3>(3).norm() / length,
                   force.tail<6>().norm() / length});
}

double motion_of(const Vector12& increment, double length) {
  return std::max(increment.head<3>().norm(), increment.tail<9>().norm() * length);
}

double largest_motion(const Slots& slots, const BlockVector& increment) {
  double largest = 0.0;
  for (std::size_t s = 0; s < increment.size(); ++s)
    largest = std::max(largest, motion_of(increment[s], slots.length[s]));
  return largest;
}

}  // namespace quoin::solver
