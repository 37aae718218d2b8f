#pragma once
/// Lists of contacts or contact points, sorted by key.

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "contact/contact_history.hpp"

namespace quoin::solver {

inline const geometry::ContactPoint& point_of(const Contact& contact) { return contact.point; }
inline const geometry::ContactPoint& point_of(const geometry::ContactPoint& point) { return point; }
template <class Item>
const geometry::ContactKey& key_of(const Item& item) {
  return point_of(item).key;
}

inline std::span<const geometry::ContactPoint> points_of_pair(
    std::span<const geometry::ContactPoint> points, int a, int b) {
  const auto pair = [](const geometry::ContactPoint& p) { return std::pair(p.key.a, p.key.b); };
  const auto range = std::ranges::equal_range(points, std::pair(a, b), {}, pair);
  return {range.begin(), range.end()};
}

/// Puts `added` into `list`. From the end on: what stands before the first of them is not touched.
template <class Item>
void merge(std::span<const Item> added, std::vector<Item>& list) {
  std::size_t left = list.size(), end = left + added.size();
  list.resize(end);
  while (!added.empty()) {
    if (left > 0 && key_of(added.back()) < key_of(list[left - 1])) {
      list[--end] = list[--left];
    } else {
      list[--end] = added.back();
      added = added.first(added.size() - 1);
    }
  }
}

/// Each of `now` takes the place of the one with its key. False, and some may not have done so,
/// where one has none, or where it would take as long to look for them as to go through `list`.
template <class Item>
bool renew(std::span<const Item> now, std::vector<Item>& list) {
  constexpr std::size_t kComparisons = 16;  // of a binary search among 65 536
  if (now.size() * kComparisons > list.size()) return now.empty();
  for (const Item& item : now) {
    const auto at =
        std::ranges::lower_bound(list, key_of(item), {}, [](const Item& x) { return key_of(x); });
    if (at == list.end() || key_of(*at) != key_of(item)) return false;
    *at = item;
  }
  return true;
}

}  // namespace quoin::solver
