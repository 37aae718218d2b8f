#pragma once
/// Groups of things that are joined in pairs.

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace quoin::solver {

/// Union–find: a group is named by its least member. Keeps the memory between calls of part().
class JoinedGroups {
 public:
  /// So many members, each a group of its own.
  void part(std::size_t count) {
    toward_.resize(count);
    std::iota(toward_.begin(), toward_.end(), 0);
  }

  void join(int a, int b) {
    const auto [low, high] = std::minmax({least(a), least(b)});
    toward(high) = low;
  }

  /// The least member of i's group.
  int least(int i) {
    while (toward(i) != i) i = toward(i) = toward(toward(i));
    return i;
  }

 private:
  int& toward(int i) { return toward_[static_cast<std::size_t>(i)]; }

  std::vector<int> toward_;  ///< a lesser member, or itself
};

}  // namespace quoin::solver
