#pragma once
/// Sparse matrix of 6×6 and 12×12 blocks, and the vectors that go with it.

#include <utility>

#include "displacement.hpp"

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
};

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

/// Diagonal blocks by slot, off-diagonal blocks (i < j) by pair. Only the leading size×size part
/// counts.
struct BlockSystem {
  std::vector<Matrix12> diagonal;
  std::vector<std::pair<int, int>> pairs;  ///< ascending
  std::vector<Matrix12> off_diagonal;      ///< rows of pair.first, columns of pair.second
  std::vector<Matrix12> mirrored;          ///< rows of pair.second; only where not symmetric
  bool symmetric = true;
  std::vector<Frame> frames;  ///< by slot; empty: not known
};

using BlockVector = std::vector<Vector12>;  ///< by slot; unused tail entries are zero

}  // namespace quoin::solver
