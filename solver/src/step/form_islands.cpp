#include "step/form_islands.hpp"

#include <algorithm>
#include <limits>

#include "base/index.hpp"
#include "step/contact_search.hpp"
#include "step/sorted_by_key.hpp"

namespace quoin::solver {
namespace {

void append_block(const CompiledScene& compiled, int block, IslandBlocks& island) {
  const BlockModel& model = compiled.models[index(block)];
  Slots& slots = island.slots;
  if (slots.start.empty()) slots.start.push_back(0);
  slots.block_of_slot.push_back(block);
  slots.size.push_back(model.unknowns);
  slots.start.push_back(slots.start.back() + model.unknowns);
  slots.length.push_back(model.size);
  island.smallest_size = std::min(island.smallest_size, model.size);
}

/// Joins the blocks with unknowns that these contacts, or ties, lie between.
void join_blocks(const CompiledScene& compiled, std::span<const geometry::ContactPoint> found,
                 JoinedGroups& blocks) {
  for (const geometry::ContactPoint& point : found) {
    if (compiled.idle[index(point.key.a)] || compiled.idle[index(point.key.b)]) continue;
    blocks.join(point.key.a, point.key.b);
  }
  for (const TieModel& of : compiled.ties) {
    const auto moves = [&](int block) { return block >= 0 && !compiled.idle[index(block)]; };
    if (moves(of.tie.a) && moves(of.tie.b)) blocks.join(of.tie.a, of.tie.b);
  }
}

/// By block: which island; -1: no unknowns. Islands are numbered by their least block.
void number_islands(const CompiledScene& compiled, JoinedGroups& blocks,
                    std::vector<int>& island_of_block) {
  island_of_block.assign(compiled.models.size(), -1);
  int count = 0;
  for (const int block : compiled.slots.block_of_slot) {
    const int first = blocks.least(block);
    island_of_block[index(block)] = first == block ? count++ : island_of_block[index(first)];
  }
}

}  // namespace

std::vector<IslandBlocks> island_blocks(const CompiledScene& compiled,
                                        std::span<const int> island_of_block) {
  std::vector<IslandBlocks> islands;
  for (const int block : compiled.slots.block_of_slot) {
    const std::size_t i = index(island_of_block[index(block)]);
    if (i >= islands.size())
      islands.resize(i + 1, {.smallest_size = std::numeric_limits<double>::infinity()});
    append_block(compiled, block, islands[i]);
  }
  for (std::size_t l = 0; l < compiled.loads.size(); ++l) {
    const int i = island_of_block[index(compiled.loads[l].block)];
    if (i >= 0) islands[index(i)].loads.push_back(static_cast<int>(l));
  }
  for (std::size_t h = 0; h < compiled.held.size(); ++h) {
    const int i = island_of_block[index(compiled.held[h].block)];
    if (i >= 0) islands[index(i)].held.push_back(static_cast<int>(h));
  }
  for (std::size_t q = 0; q < compiled.quiet.size(); ++q) {
    const int i = island_of_block[index(compiled.quiet[q].block)];
    islands[index(i)].quiet.push_back(static_cast<int>(q));
  }
  for (std::size_t t = 0; t < compiled.ties.size(); ++t) {
    const Tie& tie = compiled.ties[t].tie;
    const int a = tie.a < 0 ? -1 : island_of_block[index(tie.a)];
    const int i = a >= 0 ? a : island_of_block[index(tie.b)];
    islands[index(i)].ties.push_back(static_cast<int>(t));
  }
  return islands;
}

namespace {

/// Islands of the blocks that work.joined has together.
void form(const StepRun& run) {
  Workspace& work = run.work;
  number_islands(run.compiled, work.joined, work.next_island_of_block);
  if (work.next_island_of_block == work.island_of_block) return;
  std::vector<std::unique_ptr<Island>> islands;
  for (IslandBlocks& blocks : island_blocks(run.compiled, work.next_island_of_block)) {
    const std::vector<int>& own = blocks.slots.block_of_slot;
    const int before = work.island_of_block[index(own.front())];
    std::unique_ptr<Island>* same = before < 0 ? nullptr : &work.islands[index(before)];
    if (same != nullptr && *same != nullptr && (*same)->own() == own)
      islands.push_back(std::move(*same));
    else
      islands.push_back(std::make_unique<Island>(std::move(blocks), &work.watch));
    const std::vector<int>& slots = islands.back()->own();
    for (std::size_t s = 0; s < slots.size(); ++s)
      work.slot_of_block[index(slots[s])] = static_cast<int>(s);
  }
  work.islands = std::move(islands);
  std::swap(work.island_of_block, work.next_island_of_block);
}

void start(const StepRun& run, Island& island) {
  Workspace& work = run.work;
  for (const int block : island.own()) {
    const std::size_t b = index(block), slot = index(run.compiled.slots.slot_of_block[b]);
    work.now.blocks[b] = work.end[b] = run.state.blocks[b];
    work.stored[slot] = run.before.stored[slot];
    work.last.length[slot] = run.before.last.length[slot];
    work.last.velocity[slot] = run.before.last.velocity[slot];
    work.last.hit[b] = run.before.last.hit[b];
    work.last.crowded[b] = run.before.last.crowded[b];
  }
  island.memory.solver.choose(run.options);
  island.memory.solver.begin();
  island.begun = true;
  island.time = run.state.time;
  island.done = 0.0;
  island.length = run.options.time_step;
  island.parted = false;
  island.length_after = 0.0;
  island.attempt.contacts.clear();
  island.missing.reset();
  island.known = -1;
  island.still = false;
  island.count = {};
  island.energy = {};
}

/// One group, by the contacts found for it.
bool is_joined(const StepRun& run, const Island& island) {
  JoinedGroups& slots = run.work.joined_slots;
  const std::span<const int> slot_of_block = run.work.slot_of_block;
  slots.part(island.own().size());
  for (const geometry::ContactPoint& point : island.found) {
    const int a = slot_of_block[index(point.key.a)], b = slot_of_block[index(point.key.b)];
    if (a >= 0 && b >= 0) slots.join(a, b);
  }
  for (const int t : island.blocks.ties) {
    const Tie& tie = run.compiled.ties[index(t)].tie;
    const int a = tie.a < 0 ? -1 : slot_of_block[index(tie.a)];
    const int b = tie.b < 0 ? -1 : slot_of_block[index(tie.b)];
    if (a >= 0 && b >= 0) slots.join(a, b);
  }
  for (std::size_t s = 0; s < island.own().size(); ++s)
    if (slots.least(static_cast<int>(s)) != 0) return false;
  return true;
}

/// Nothing was found between islands, and those that were awake hold together.
bool islands_stay(const StepRun& run) {
  const auto stays = [&](const auto& island) { return island->at_rest || is_joined(run, *island); };
  return all_known(run.work) && std::ranges::all_of(run.work.islands, stays);
}

}  // namespace

bool all_known(const Workspace& work) {
  return !work.islands_met && std::ranges::all_of(work.islands, [&](const auto& island) {
    return is_known(work, *island);
  });
}

void form_islands(const StepRun& run) {
  if (is_paper_method(run.options.method)) return form_whole_scene(run);
  if (!run.work.islands.empty() && islands_stay(run)) return;
  run.work.joined.part(run.compiled.models.size());
  join_blocks(run.compiled, run.work.found, run.work.joined);
  form(run);
}

void form_whole_scene(const StepRun& run) {
  const std::vector<int>& blocks = run.compiled.slots.block_of_slot;
  run.work.joined.part(run.compiled.models.size());
  for (const int block : blocks) run.work.joined.join(blocks.front(), block);
  form(run);
}

bool join_islands_that_met(const StepRun& run) {
  Workspace& work = run.work;
  if (!work.islands_met) return false;
  bool met = false;
  for (const geometry::ContactPoint& point : work.found_end) {
    const int a = work.island_of_block[index(point.key.a)];
    const int b = work.island_of_block[index(point.key.b)];
    if (a < 0 || b < 0 || a == b) continue;
    if (!(point.gap < -overlap_limit(pair_size(run.compiled, point.key.a, point.key.b)))) continue;
    work.joined.join(point.key.a, point.key.b);
    met = true;
  }
  if (met) form(run);
  return met;
}

bool constant_loads(const CompiledScene& compiled, const IslandBlocks& island) {
  const auto constant = [&](int l) { return compiled.loads[index(l)].is_constant(); };
  const auto at_rest = [&](int h) { return compiled.held[index(h)].displacement.is_constant(); };
  const auto still = [&](int q) { return compiled.quiet[index(q)].velocity.is_constant(); };
  return compiled.scene.gravity.is_constant() && compiled.prescribed.empty() &&
         std::ranges::all_of(island.quiet, still) && std::ranges::all_of(island.loads, constant) &&
         std::ranges::all_of(island.held, at_rest);
}

void wake_islands(const StepRun& run) {
  for (const auto& island : run.work.islands) {
    const auto rests = [&](int block) { return run.before.at_rest[index(block)] != 0; };
    const bool goes_on_resting = island->at_rest && is_known(run.work, *island);
    island->at_rest = goes_on_resting || (std::ranges::all_of(island->own(), rests) &&
                                          constant_loads(run.compiled, island->blocks));
    island->begun = true;
    island->count = {.rounding = island->count.rounding};
  }
}

void list_awake(const Workspace& work, Islands& islands) {
  islands.clear();
  for (const auto& island : work.islands)
    if (!island->at_rest) islands.push_back(island.get());
}

namespace {

/// What the island's last step left is what it starts with. Where a joint dilates or gravity is a
/// function of time, reaches may be others.
bool goes_on(const StepRun& run, const Island& island) {
  return is_known(run.work, island) && !run.before.at_rest[index(island.own().front())] &&
         !run.compiled.dilates && run.compiled.scene.gravity.is_constant();
}

constexpr std::size_t kNotKnown = std::numeric_limits<std::size_t>::max();

}  // namespace

void start_islands(const StepRun& run, std::span<Island* const> islands) {
  Workspace& work = run.work;
  const bool all_go_on =
      std::ranges::all_of(islands, [&](const Island* island) { return goes_on(run, *island); });
  for (Island* island : islands) {
    start(run, *island);
    island->contacts_before = island->history.size();
    island->found_before = island->found.size();
  }
  if (all_go_on) return;
  const double opening = largest_opening(run.compiled, run.state.contacts);
  KnownReaches& reaches = work.start_reaches;
  reaches.fall = -1.0;  // of all blocks, anew
  const Reach reach(run.compiled, run.options, {run.state.blocks, opening, run.state.time}, {},
                    reaches);
  list_owners(islands, work);
  const bool between = share_out(work, work.found, Sharing::Referred, &Island::found);
  // Contacts of two islands now.
  const bool parted = share_out(work, run.state.contacts, Sharing::Referred, &Island::history);
  for (Island* island : islands) {
    island->reach = largest_reach(reach, island->found);
    island->contacts_before = parted ? kNotKnown : island->history.size();
    island->found_before = between ? kNotKnown : island->found.size();
  }
}

void replace_awake(const StepRun& run, std::span<const Contact> added,
                   std::vector<Contact>& contacts) {
  const Workspace& work = run.work;
  std::erase_if(contacts, [&](const Contact& contact) {
    const int i = island_of(contact.point, work.island_of_block);
    return i < 0 || !work.islands[index(i)]->at_rest;
  });
  merge(added, contacts);
}

namespace {

/// What the scene's only island has become is the scene's: nothing is copied, and the memory of
/// what was is the next attempt's.
void exchange_contacts(Island& island, std::vector<Contact>& contacts) {
  if (island.history.refers_to(contacts)) return;  // no sub-step was taken
  island.history.exchange(contacts);
  island.history.exchange(island.attempt.contacts);
  island.attempt.contacts.clear();
  island.history.refer_to(contacts);
}

}  // namespace

void take_contacts(const StepRun& run, std::vector<Contact>& contacts) {
  Workspace& work = run.work;
  const auto stay = [&](const Island* island) {
    return island->history.size() == island->contacts_before &&
           renew(std::span<const Contact>(island->history), contacts);
  };
  if (work.islands.size() == 1 && work.awake.size() == 1)
    return exchange_contacts(*work.awake.front(), contacts);
  if (std::ranges::all_of(work.awake, stay)) return;
  if (work.awake.size() == 1) return replace_awake(run, work.awake.front()->history, contacts);
  std::vector<Contact>& taken = work.taken;
  taken.clear();
  for (const Island* island : work.awake)
    taken.insert(taken.end(), island->history.begin(), island->history.end());
  const auto key = [](const Contact& contact) { return contact.point.key; };
  if (!std::ranges::is_sorted(taken, {}, key)) std::ranges::sort(taken, {}, key);
  replace_awake(run, taken, contacts);
}

void take_found(const StepRun& run) {
  Workspace& work = run.work;
  const std::span<const geometry::ContactPoint> now = work.found_end;
  if (work.searched == Searched::AllBlocks) return std::swap(work.found, work.found_end);
  std::size_t before = 0;
  bool known = true;
  for (const Island* island : work.awake) {
    known = known && island->found_before != kNotKnown;
    before += island->found_before;
  }
  if (known && before == now.size() && renew(now, work.found)) return;
  std::erase_if(work.found, [&](const geometry::ContactPoint& point) {
    const int i = island_of(point, work.island_of_block);
    return i < 0 || !work.islands[index(i)]->at_rest;
  });
  merge(now, work.found);
}

}  // namespace quoin::solver
