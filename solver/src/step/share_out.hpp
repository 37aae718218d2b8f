#pragma once
/// Which of the scene's contacts and contact points are whose.

#include "base/index.hpp"
#include "step/sorted_by_key.hpp"
#include "step/workspace.hpp"

namespace quoin::solver {

/// Those that share_out() gives to, in work.owners.
inline void list_owners(std::span<Island* const> islands, Workspace& work) {
  work.owners.assign(work.islands.size(), nullptr);
  for (Island* island : islands)
    work.owners[index(work.island_of_block[index(island->own().front())])] = island;
}

/// What an island gets where it is the scene's only one and all of a list is its own.
enum class Sharing : char {
  Referred,  ///< that list: it stays as it is while the island reads it
  Copied
};

/// Gives each owner its items of a list of the scene. True where some of these are no island's, or
/// lie between two.
template <class Item>
bool share_out(const Workspace& work, const std::vector<Item>& scene, Sharing sharing,
               IslandList<Item> Island::*list) {
  const auto island = [&](const Item& item) {
    return island_of(point_of(item), work.island_of_block);
  };
  const bool some_are_none =
      std::ranges::any_of(scene, [&](auto& item) { return island(item) < 0; });
  if (sharing == Sharing::Referred && work.islands.size() == 1 && !some_are_none) {
    if (work.owners.front() != nullptr) (work.owners.front()->*list).refer_to(scene);
    return false;
  }
  for (Island* owner : work.owners)
    if (owner != nullptr) (owner->*list).clear();
  for (const Item& item : scene) {
    const int i = island(item);
    Island* owner = i < 0 ? nullptr : work.owners[index(i)];
    if (owner != nullptr) (owner->*list).push_back(item);
  }
  return some_are_none;
}

}  // namespace quoin::solver
