#pragma once
/// A matrix of blocks by rows, as PETSc takes it.

#include <vector>

#include "block/block_system.hpp"

namespace quoin::solver {

template <int n>
struct BlockRows {
  int columns = 0;
  std::vector<int> start{0};  ///< first entry of each row, and the number of all
  std::vector<int> column;    ///< by entry
  std::vector<Eigen::Matrix<double, n, n>> value;  ///< by entry
};

/// Of the pairs of `system` those that are not zero; a row begins with its diagonal block. Unknowns
/// that a block lacks of n have 1 on the diagonal.
template <int n>
BlockRows<n> block_rows(const BlockSystem& system, const Slots& slots);

}  // namespace quoin::solver
