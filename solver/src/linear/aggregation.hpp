#pragma once
/// Groups of blocks that are joined as good as rigidly.

#include "linear/block_rows.hpp"

namespace quoin::solver {

struct Aggregates {
  int count = 0;
  std::vector<int> of;  ///< by row; -1: a row that is coupled with none
};

/// How stiffly the entries of a matrix couple their rows, by entry: with D = L L^T the symmetric
/// part of a diagonal block, 1 / |(L_i^-1 A_ij L_j^-T)^-1|, no more than the least singular value
/// of it. Joints that hinge, slide or stand on a point are soft in one of the six directions: 0.
std::vector<double> couplings(const BlockRows<6, 6>& matrix);

/// Each group is a row with all rows it is stiffly coupled with, or what is left between such
/// groups; a row coupled softly alone is a group of its own.   [Vanek, Mandel & Brezina 1996]
Aggregates aggregate(const BlockRows<6, 6>& matrix);

}  // namespace quoin::solver
