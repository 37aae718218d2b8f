#pragma once
/// In which order the blocks of a sparse matrix are eliminated, and in which groups.

#include <cstddef>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

namespace quoin::solver {

/// Lists, one after another.
template <class Item>
struct ListsOf {
  std::vector<int> start{0};  ///< of each list in `entries`, and the end of the last
  std::vector<Item> entries;

  std::size_t size() const { return start.size() - 1; }
  std::span<const Item> operator[](std::size_t list) const {
    return {entries.data() + start[list], entries.data() + start[list + 1]};
  }
};
using Lists = ListsOf<int>;

/// `entries` calls what it is given with (list, item) for each entry, twice the same.
template <class Item = int, class Entries>
ListsOf<Item> make_lists(std::size_t count, const Entries& entries) {
  const auto at = [](int list) { return static_cast<std::size_t>(list); };
  ListsOf<Item> lists;
  lists.start.assign(count + 1, 0);
  entries([&](int list, const Item&) { ++lists.start[at(list) + 1]; });
  std::partial_sum(lists.start.begin(), lists.start.end(), lists.start.begin());
  lists.entries.resize(at(lists.start.back()));
  std::vector<int> next(lists.start.begin(), lists.start.end() - 1);
  entries([&](int list, const Item& item) { lists.entries[at(next[at(list)]++)] = item; });
  return lists;
}

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
