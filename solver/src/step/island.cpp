#include "step/island.hpp"

#include <algorithm>
#include <limits>

#include "base/index.hpp"

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

}  // namespace

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

void number_islands(const CompiledScene& compiled, JoinedGroups& blocks,
                    std::vector<int>& island_of_block) {
  island_of_block.assign(compiled.models.size(), -1);
  int count = 0;
  for (const int block : compiled.slots.block_of_slot) {
    const int first = blocks.least(block);
    island_of_block[index(block)] = first == block ? count++ : island_of_block[index(first)];
  }
}

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

}  // namespace quoin::solver
