#include "finder/vertex_blocks.hpp"

#include <algorithm>

namespace quoin::geometry {
namespace {

bool same_box(const Box& x, const Box& y) { return x.min == y.min && x.max == y.max; }

Body block_of(const void* owner, int index) { return static_cast<const Shape*>(owner)[index]; }

}  // namespace

/// Vertices are compared only where the box is that of the last call: a block that moves costs
/// nothing more.
void VertexBlocks::note_standing(std::span<const Shape> blocks) {
  if (boxes_.size() != blocks.size()) {
    boxes_.assign(blocks.size(), Box{});
    standing_.assign(blocks.size(), Standing{});
    changes_.resize(blocks.size());
  }
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const bool same = same_box(boxes_[i], blocks[i].box());
    const bool stands = same && standing_[i].is(blocks[i]);
    changes_[i] = stands ? BodyChange::None : BodyChange::Moved;
    if (same && !stands) {
      standing_[i] = {blocks[i].shared_topology(), blocks[i].vertices()};
    }
    boxes_[i] = blocks[i].box();
  }
}

void VertexBlocks::set_reach(double reach) {
  options_.reach = reach;
  batch_.set_reach(reach);
}

FindCounts VertexBlocks::find(std::span<const Shape> blocks, std::span<const char> idle,
                              std::vector<ContactPoint>& contacts, Executor& executor) {
  note_standing(blocks);
  double reach = std::max(options_.reach, options_.tolerance);
  if (options_.tolerance == 0.0) {
    for (const Shape& block : blocks) {
      reach = std::max(reach, default_tolerance(block, block));
    }
  }
  BodySource source;
  source.owner = blocks.data();
  source.body = block_of;
  source.count = static_cast<int>(blocks.size());
  source.changes = changes_;
  return batch_.find(source, broad_phase_.find_candidates(boxes_, reach, idle), contacts,
                     &executor);
}

}  // namespace quoin::geometry
