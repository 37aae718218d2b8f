#include "step/workspace.hpp"

#include <algorithm>

#include "base/index.hpp"

namespace quoin::solver {

namespace {

/// A scene has no work for more threads than blocks.
int useful_threads(const CompiledScene& compiled, int given) {
  return std::min(given, std::max(1, compiled.slots.count()));
}

/// Pairs of two blocks without unknowns are never tested.
geometry::BodyOptions body_options(const CompiledScene& compiled, int block) {
  const bool idle = compiled.idle[index(block)] != 0;
  geometry::BodyOptions options;
  options.motion = idle ? geometry::BodyMotion::Idle : geometry::BodyMotion::Moving;
  if (is_absent(compiled, block)) options.category = 0;
  return options;
}

/// What two vertices of a pair may be off by, for the rounding of their coordinates, m.
double vertex_rounding(const CompiledScene& compiled) {
  constexpr double kMost = 1e-3;  // of the smallest block, as of what a scene states
  double of_blocks = 0.0;
  for (const BlockModel& model : compiled.models)
    of_blocks = std::max(of_blocks, 2.0 * model.coordinate_rounding);
  return std::max(std::min(of_blocks, kMost * compiled.smallest_size),
                  compiled.scene.coordinate_rounding);
}

}  // namespace

Workspace::Workspace(const CompiledScene& compiled, const StepOptions& options)
    : threads_wanted(useful_threads(compiled, options.threads)),
      threads(threads_wanted),
      finder({.executor = &threads,
              .frame = geometry::PointFrame::Bodies,
              .coordinate_rounding = vertex_rounding(compiled)}),
      motion_end(compiled.prescribed.size()) {
  const std::size_t slots = compiled.slots.size.size();
  last = {std::vector<double>(slots, 0.0), BlockVector(slots, Vector12::Zero()),
          std::vector<char>(compiled.models.size(), 0),
          std::vector<char>(compiled.models.size(), 0)};
  stored.assign(slots, 0.0);
  energy_scale.resize(compiled.models.size());
  at_rest.assign(compiled.models.size(), 0);
  slot_of_block.assign(compiled.models.size(), -1);
  island_of_block.assign(compiled.models.size(), -1);
  laid.assign(compiled.models.size(), kLaid);
  motion.resize(compiled.prescribed.size());
  for (std::size_t p = 0; p < motion.size(); ++p) {
    const Motion& given = compiled.scene.blocks[index(compiled.prescribed[p])].motion;
    if (given.kind == MotionKind::Displacement) motion[p].displacement = given.value.at(0.0);
    motion[p].turn = turn_at(given, 0.0);
  }
  resize(compiled.models.size(), poses);
  for (std::size_t b = 0; b < compiled.models.size(); ++b) {
    const BlockModel& model = compiled.models[b];
    const geometry::Placement at = placement(model, pose(model.start));
    const geometry::BodyOptions use = body_options(compiled, static_cast<int>(b));
    std::vector<geometry::CompoundPart> parts;
    if (model.parts)
      for (const ReferencePart& part : *model.parts) parts.push_back({part.shape});
    const int handle =
        model.parts ? finder.add_compound(parts, at, use) : finder.add(model.shape, at, use);
    if (!compiled.has_parts) continue;
    handles.push_back(handle);
    owners_of_handles.resize(index(finder.size()), static_cast<int>(b));
  }
}

void place_bodies(const CompiledScene& compiled, const State& state, Workspace& work) {
  ++work.search_epoch;
  work.known_reaches = {};
  work.all_changed = true;
  for (std::size_t b = 0; b < compiled.models.size(); ++b) {
    work.finder.move(work.handle(static_cast<int>(b)),
                     placement(compiled.models[b], pose(state.blocks[b])));
  }
}

}  // namespace quoin::solver
