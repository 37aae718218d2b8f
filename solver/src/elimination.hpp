#pragma once
/// In which order the blocks of a sparse matrix are eliminated, and in which groups.

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace quoin::solver {

/// Lists of numbers, one after another.
struct Lists {
  std::vector<int> start{0};  ///< of each list in `entries`, and the end of the last
  std::vector<int> entries;

  std::size_t size() const { return start.size() - 1; }
  std::span<const int> operator[](std::size_t list) const {
    return {entries.data() + start[list], entries.data() + start[list + 1]};
  }
};

/// Neighbouring places of the order that are eliminated together, as one dense matrix.
struct Supernode {
  int first = 0, end = 0;  ///< its places
  int parent = -1;         ///< supernode that takes what is left of it; -1: none is left
};

struct Elimination {
  std::vector<int> node_at;   ///< by place
  std::vector<int> place_of;  ///< by node
  std::vector<Supernode>
      supernodes;  ///< children before parents, the last child right before its parent
  Lists below;     ///< by supernode: later places that it couples, ascending
};

/// For `count` nodes of which `pairs` (i < j) are coupled: minimum degree, then a postorder of the
/// elimination tree, then supernodes that may hold a few zeros.
/// Sources: [Amestoy, Davis & Duff 1996]; [Liu 1990] for tree and supernodes.
Elimination make_elimination(int count, std::span<const std::pair<int, int>> pairs);

}  // namespace quoin::solver
