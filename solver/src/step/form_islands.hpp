#pragma once
/// The islands of a step, and which of the scene's contacts are whose.

#include "base/index.hpp"
#include "step/sorted_by_key.hpp"
#include "step/workspace.hpp"

namespace quoin::solver {

/// The blocks of each island, and what acts on them.
std::vector<IslandBlocks> island_blocks(const CompiledScene& compiled,
                                        std::span<const int> island_of_block);

/// Makes the islands of blocks that the contacts found join. Those of the last step with the same
/// blocks stay, with what they remember. The source's methods know one island, the scene.
void form_islands(const StepRun& run);

/// All blocks as one island, which has not begun the step.
void form_whole_scene(const StepRun& run);

/// After the step: blocks of two islands that overlap make one island, which has not begun the
/// step. True when there are any.
bool join_islands_that_met(const StepRun& run);

/// Which islands have something to do, all but those that stood still in the last step and stand
/// under the same loads. All of them have then begun the step.
void wake_islands(const StepRun& run);

/// The islands that are not at rest.
void list_awake(const Workspace& work, Islands& islands);

/// These islands where the step begins; what a first try at it has left is taken back.
void start_islands(const StepRun& run, std::span<Island* const> islands);

/// Contacts of islands at rest stay, `added` come in for those of all others; both sorted by key.
void replace_awake(const StepRun& run, std::span<const Contact> added,
                   std::vector<Contact>& contacts);

/// The contacts of islands that are awake take the place of those that they had; sorted by key.
void take_contacts(const StepRun& run, std::vector<Contact>& contacts);

/// The points found at the end of the attempts take the place of those that their blocks had.
void take_found(const StepRun& run);

/// What is known of islands holds for the state and its contact points: of this one, of all.
inline bool is_known(const Workspace& work, const Island& island) {
  return island.known == work.search_epoch;
}
bool all_known(const Workspace& work);

/// Nothing that acts on the island changes.
bool constant_loads(const CompiledScene& compiled, const IslandBlocks& island);

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
