#include "step/island_extremes.hpp"

#include <algorithm>

#include "base/index.hpp"
#include "step/contact_search.hpp"
#include "step/share_out.hpp"

namespace quoin::solver {
namespace {

bool is_known(const Workspace& work, const Island& island) {
  return island.known == work.search_epoch;
}

void note_blocks(const CompiledScene& compiled, const State& state, std::span<const int> blocks,
                 Extremes& extremes) {
  for (const int block : blocks) {
    const BlockState& now = state.blocks[index(block)];
    note_block(now, block, vertex_speed(compiled.models[index(block)], now), extremes);
  }
}

/// The points and contacts of islands that are at rest and not known, from those of the scene.
void share_out(const State& state, Workspace& work) {
  work.owners.assign(work.islands.size(), nullptr);
  for (std::size_t i = 0; i < work.islands.size(); ++i) {
    Island& island = *work.islands[i];
    if (island.at_rest && !is_known(work, island)) work.owners[i] = &island;
  }
  solver::share_out(work, work.found, Sharing::Referred, &Island::found);
  solver::share_out(work, state.contacts, Sharing::Referred, &Island::history);
}

}  // namespace

void note_islands(const CompiledScene& compiled, const State& state, Workspace& work) {
  if (work.islands_met) return;
  const auto stale = [&](const auto& island) {
    return island->at_rest && !is_known(work, *island);
  };
  if (std::ranges::any_of(work.islands, stale)) share_out(state, work);
  for (const auto& island : work.islands) {
    if (island->at_rest ? is_known(work, *island) : island->searched != work.search_epoch) continue;
    island->known = work.search_epoch;
    island->extremes = {};
    note_blocks(compiled, state, island->own(), island->extremes);
    note_contacts(compiled, island->history, island->found, island->extremes);
  }
}

bool all_known(const Workspace& work) {
  return !work.islands_met && std::ranges::all_of(work.islands, [&](const auto& island) {
    return is_known(work, *island);
  });
}

Extremes extremes(const CompiledScene& compiled, const State& state, const Workspace& work) {
  Extremes all;
  if (all_known(work)) {
    for (const auto& island : work.islands) add(island->extremes, all);
    note_blocks(compiled, state, compiled.prescribed, all);
    return all;
  }
  for (std::size_t b = 0; b < state.blocks.size(); ++b) {
    const BlockState& now = state.blocks[b];
    note_block(now, static_cast<int>(b), vertex_speed(compiled.models[b], now), all);
  }
  note_contacts(compiled, state.contacts, work.found, all);
  return all;
}

}  // namespace quoin::solver
