#include "linear/elimination.hpp"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <utility>

#include "base/index.hpp"

namespace quoin::solver {
namespace {

constexpr double kZeros = 0.05;  // share of a supernode that may be zeros; 0.1 and 0.25 were slower
constexpr int kWidest = 24;      // nodes in one: the most of the work is then in products of fronts

/// Node at each place.
std::vector<int> minimum_degree(int count, std::span<const std::pair<int, int>> pairs) {
  Lists upper = make_lists(index(count), [&](const auto& add) {  // by column
    for (const auto& [i, j] : pairs) add(std::max(i, j), std::min(i, j));
    for (int i = 0; i < count; ++i) add(i, i);
  });
  for (std::size_t j = 0; j < upper.size(); ++j)
    std::sort(upper.entries.begin() + upper.start[j], upper.entries.begin() + upper.start[j + 1]);
  const std::vector<double> ones(upper.entries.size(), 1.0);
  const Eigen::Map<const Eigen::SparseMatrix<double>> graph(
      count, count, static_cast<long>(ones.size()), upper.start.data(), upper.entries.data(),
      ones.data());
  Eigen::AMDOrdering<int>::PermutationType order;
  Eigen::AMDOrdering<int>()(graph.selfadjointView<Eigen::Upper>(), order);
  return {order.indices().data(), order.indices().data() + count};
}

std::vector<int> inverse(const std::vector<int>& order) {
  std::vector<int> places(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) places[index(order[i])] = static_cast<int>(i);
  return places;
}

/// Of each place, the places it is coupled with: the earlier ones, or the later ones.
enum class Side : char { Earlier, Later };
Lists neighbours(std::span<const std::pair<int, int>> pairs, const std::vector<int>& place_of,
                 Side side) {
  return make_lists(place_of.size(), [&](const auto& add) {
    for (const auto& [i, j] : pairs) {
      const auto [low, high] = std::minmax(place_of[index(i)], place_of[index(j)]);
      side == Side::Earlier ? add(high, low) : add(low, high);
    }
  });
}

/// Parent of each place: the first later one that its elimination changes, -1: none.   [Liu 1990]
std::vector<int> elimination_tree(const Lists& earlier) {
  std::vector<int> parent(earlier.size(), -1), root(earlier.size(), -1);
  for (std::size_t j = 0; j < earlier.size(); ++j) {
    for (int i : earlier[j]) {
      while (i != -1 && i < static_cast<int>(j)) {  // up to the root, which j becomes
        const int next = std::exchange(root[index(i)], static_cast<int>(j));
        if (next == -1) parent[index(i)] = static_cast<int>(j);
        i = next;
      }
    }
  }
  return parent;
}

/// Of each place, those that it is the parent of, ascending.
Lists children_of(const std::vector<int>& parent) {
  return make_lists(parent.size(), [&](const auto& add) {
    for (std::size_t i = 0; i < parent.size(); ++i)
      if (parent[i] >= 0) add(parent[i], static_cast<int>(i));
  });
}

/// Places in the order of a walk that leaves each tree by its root, the deepest branch of it last.
std::vector<int> postorder(const std::vector<int>& parent) {
  const std::size_t n = parent.size();
  std::vector<int> weight(n, 1);
  for (std::size_t i = 0; i < n; ++i)
    if (parent[i] >= 0)
      weight[index(parent[i])] = std::max(weight[index(parent[i])], weight[i] + 1);
  Lists children = children_of(parent);
  const auto lighter = [&](int a, int b) {
    return std::pair(weight[index(a)], a) < std::pair(weight[index(b)], b);
  };
  std::vector<int> open, order;
  for (std::size_t i = 0; i < n; ++i) {
    if (parent[i] < 0) open.push_back(static_cast<int>(i));
    std::sort(children.entries.begin() + children.start[i],
              children.entries.begin() + children.start[i + 1], lighter);
  }
  order.reserve(n);
  while (!open.empty()) {  // a walk from the roots, the last child first, read backwards
    const int place = open.back();
    open.pop_back();
    order.push_back(place);
    for (const int child : children[index(place)]) open.push_back(child);
  }
  std::reverse(order.begin(), order.end());
  return order;
}

/// Of each place, the later ones that are coupled with it once all before it are eliminated,
/// ascending: its own, and its children's.
Lists filled_columns(const Lists& later, const std::vector<int>& parent) {
  const Lists children = children_of(parent);
  Lists below;
  below.start.reserve(later.start.size());
  below.entries.reserve(2 * later.entries.size());
  std::vector<std::size_t> seen_by(later.size(), later.size());
  for (std::size_t j = 0; j < later.size(); ++j) {
    const auto add = [&](int place) {
      if (place == static_cast<int>(j) || std::exchange(seen_by[index(place)], j) == j) return;
      below.entries.push_back(place);
    };
    for (const int place : later[j]) add(place);
    for (const int child : children[j]) {
      const auto end = index(below.start[index(child) + 1]);  // entries move as they grow
      for (auto i = index(below.start[index(child)]); i < end; ++i) add(below.entries[i]);
    }
    std::sort(below.entries.begin() + below.start[j], below.entries.end());
    below.start.push_back(static_cast<int>(below.entries.size()));
  }
  return below;
}

/// Joins each place with the one before it where that adds few zeros. `below`: by place.
std::vector<Supernode> join(const Lists& below, const std::vector<int>& parent) {
  std::vector<Supernode> supernodes;
  std::vector<double> zeros;                      // of each, in its columns
  const auto rows = [&](const Supernode& node) {  // below it: those of its last place
    return static_cast<double>(below[index(node.end) - 1].size());
  };
  for (std::size_t j = 0; j < below.size(); ++j) {
    Supernode next{static_cast<int>(j), static_cast<int>(j) + 1};
    const double below_rows = rows(next);
    double next_zeros = 0.0;
    while (!supernodes.empty()) {
      const Supernode& child = supernodes.back();
      const int above = parent[index(child.end - 1)];
      if (above < next.first || above >= next.end) break;
      const double width = child.end - child.first;
      const double columns = next.end - child.first;
      const double added =
          zeros.back() + next_zeros + width * (columns - width + below_rows - rows(child));
      if (columns > kWidest || added > kZeros * columns * (0.5 * columns + below_rows)) break;
      next.first = child.first;
      next_zeros = added;
      supernodes.pop_back();
      zeros.pop_back();
    }
    supernodes.push_back(next);
    zeros.push_back(next_zeros);
  }
  return supernodes;
}

/// `below`: by place.
void set_below(const Lists& below, Elimination& result) {
  std::vector<int> supernode_of(below.size());
  for (std::size_t s = 0; s < result.supernodes.size(); ++s) {
    const Supernode& node = result.supernodes[s];
    std::fill(supernode_of.begin() + node.first, supernode_of.begin() + node.end,
              static_cast<int>(s));
    const std::span<const int> rows = below[index(node.end) - 1];
    result.below.entries.insert(result.below.entries.end(), rows.begin(), rows.end());
    result.below.start.push_back(static_cast<int>(result.below.entries.size()));
  }
  for (std::size_t s = 0; s < result.supernodes.size(); ++s) {
    const std::span<const int> rows = result.below[s];
    if (!rows.empty()) result.supernodes[s].parent = supernode_of[index(rows.front())];
  }
}

}  // namespace

Elimination make_elimination(int count, std::span<const std::pair<int, int>> pairs) {
  Elimination result;
  const std::vector<int> order = minimum_degree(count, pairs);
  const Lists first = neighbours(pairs, inverse(order), Side::Earlier);
  result.node_at.reserve(index(count));
  for (const int place : postorder(elimination_tree(first)))
    result.node_at.push_back(order[index(place)]);
  result.place_of = inverse(result.node_at);
  const std::vector<int> parent =
      elimination_tree(neighbours(pairs, result.place_of, Side::Earlier));
  const Lists below = filled_columns(neighbours(pairs, result.place_of, Side::Later), parent);
  result.supernodes = join(below, parent);
  set_below(below, result);
  return result;
}

}  // namespace quoin::solver
