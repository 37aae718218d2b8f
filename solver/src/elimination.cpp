#include "elimination.hpp"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <numeric>

#include "index.hpp"

namespace quoin::solver {
namespace {

using Lists = std::vector<std::vector<int>>;

constexpr double kZeros = 0.05;  // share of a supernode that may be zeros; 0.1 and 0.25 were slower
constexpr int kWidest = 24;      // nodes in one: the most of the work is then in products of fronts

/// Node at each place.
std::vector<int> minimum_degree(int count, std::span<const std::pair<int, int>> pairs) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < count; ++i) entries.emplace_back(i, i, 1.0);
  for (const auto& [i, j] : pairs) {
    entries.emplace_back(i, j, 1.0);
    entries.emplace_back(j, i, 1.0);
  }
  Eigen::SparseMatrix<double> graph(count, count);
  graph.setFromTriplets(entries.begin(), entries.end());
  Eigen::AMDOrdering<int>::PermutationType order;
  Eigen::AMDOrdering<int>()(graph, order);
  return {order.indices().data(), order.indices().data() + count};
}

std::vector<int> inverse(const std::vector<int>& order) {
  std::vector<int> places(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) places[index(order[i])] = static_cast<int>(i);
  return places;
}

/// Of each place, the earlier places it is coupled with.
Lists earlier_neighbours(std::span<const std::pair<int, int>> pairs,
                         const std::vector<int>& place_of) {
  Lists earlier(place_of.size());
  for (const auto& [i, j] : pairs) {
    const auto [low, high] = std::minmax(place_of[index(i)], place_of[index(j)]);
    earlier[index(high)].push_back(low);
  }
  return earlier;
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

/// Places in the order of a walk that leaves each tree by its root, the deepest branch of it last.
std::vector<int> postorder(const std::vector<int>& parent) {
  const std::size_t n = parent.size();
  std::vector<int> weight(n, 1);
  for (std::size_t i = 0; i < n; ++i) {
    if (parent[i] >= 0)
      weight[index(parent[i])] = std::max(weight[index(parent[i])], weight[i] + 1);
  }
  Lists children(n);
  std::vector<int> open, order;
  for (std::size_t i = 0; i < n; ++i) {
    (parent[i] < 0 ? open : children[index(parent[i])]).push_back(static_cast<int>(i));
  }
  for (std::vector<int>& list : children) {
    std::stable_sort(list.begin(), list.end(),
                     [&](int a, int b) { return weight[index(a)] < weight[index(b)]; });
  }
  while (!open.empty()) {  // a walk from the roots, the last child first, read backwards
    const int place = open.back();
    open.pop_back();
    order.push_back(place);
    for (const int child : children[index(place)]) open.push_back(child);
  }
  std::reverse(order.begin(), order.end());
  return order;
}

/// Of each place, the later ones that are coupled with it once all before it are eliminated.
Lists filled_columns(const Lists& earlier, const std::vector<int>& parent) {
  Lists below(earlier.size());
  for (std::size_t j = 0; j < earlier.size(); ++j) {
    for (const int i : earlier[j]) below[index(i)].push_back(static_cast<int>(j));
  }
  for (std::size_t j = 0; j < below.size(); ++j) {
    std::sort(below[j].begin(), below[j].end());
    below[j].erase(std::unique(below[j].begin(), below[j].end()), below[j].end());
    if (parent[j] < 0) continue;
    std::vector<int>& above = below[index(parent[j])];
    for (const int i : below[j]) {
      if (i != parent[j]) above.push_back(i);
    }
  }
  return below;
}

/// Joins each place with the one before it where that adds few zeros.
std::vector<Supernode> join(const Lists& below, const std::vector<int>& parent) {
  std::vector<Supernode> supernodes;
  std::vector<double> zeros;  // of each, in its columns
  for (std::size_t j = 0; j < below.size(); ++j) {
    Supernode next{static_cast<int>(j), static_cast<int>(j) + 1, below[j]};
    double next_zeros = 0.0;
    while (!supernodes.empty()) {
      const Supernode& child = supernodes.back();
      const int above = parent[index(child.end - 1)];
      if (above < next.first || above >= next.end) break;
      const double width = child.end - child.first;
      const double columns = next.end - child.first;
      const double below_rows = static_cast<double>(next.below.size());
      const double added =
          zeros.back() + next_zeros +
          width * (columns - width + below_rows - static_cast<double>(child.below.size()));
      if (columns > kWidest || added > kZeros * columns * (0.5 * columns + below_rows)) break;
      next.first = child.first;
      next_zeros = added;
      supernodes.pop_back();
      zeros.pop_back();
    }
    supernodes.push_back(std::move(next));
    zeros.push_back(next_zeros);
  }
  return supernodes;
}

void set_parents(std::vector<Supernode>& supernodes, std::size_t count) {
  std::vector<int> supernode_of(count);
  for (std::size_t s = 0; s < supernodes.size(); ++s) {
    for (int place = supernodes[s].first; place < supernodes[s].end; ++place) {
      supernode_of[index(place)] = static_cast<int>(s);
    }
  }
  for (Supernode& node : supernodes) {
    if (!node.below.empty()) node.parent = supernode_of[index(node.below.front())];
  }
}

}  // namespace

Elimination make_elimination(int count, std::span<const std::pair<int, int>> pairs) {
  Elimination result;
  const std::vector<int> order = minimum_degree(count, pairs);
  for (const int place : postorder(elimination_tree(earlier_neighbours(pairs, inverse(order))))) {
    result.node_at.push_back(order[index(place)]);
  }
  result.place_of = inverse(result.node_at);
  const Lists earlier = earlier_neighbours(pairs, result.place_of);
  const std::vector<int> parent = elimination_tree(earlier);
  result.supernodes = join(filled_columns(earlier, parent), parent);
  set_parents(result.supernodes, index(count));
  return result;
}

}  // namespace quoin::solver
