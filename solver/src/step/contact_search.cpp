#include "step/contact_search.hpp"

#include <algorithm>
#include <cmath>

#include "base/index.hpp"
#include "contact/joint_law.hpp"

namespace quoin::solver {
namespace {

constexpr double kLargestHop = 0.1;   // of the smaller block of a pair
constexpr double kLeastReach = 1e-4;  // of the smaller block
constexpr double kReachOfMotion =
    2.0;                              // of what a vertex can move in a step   [Beyabanaki 2009], 3
constexpr double kReachGrain = 16.0;  // parts of a power of two

/// By at most an eighth: a speed that changes by a hair changes no reach, and what was found for
/// pairs that stand still stays good.
double rounded_up(double reach) {
  int exponent = 0;
  const double mantissa = std::frexp(reach, &exponent);  // 0.5 .. 1
  return std::ldexp(std::ceil(kReachGrain * mantissa) / kReachGrain, exponent);
}

}  // namespace

double vertex_speed(const BlockModel& model, const BlockState& block) {
  return block.velocity.norm() + 0.5 * model.size * block.angular_velocity.norm();
}

double pair_size(const CompiledScene& compiled, int a, int b) {
  return std::min(compiled.models[index(a)].size, compiled.models[index(b)].size);
}

double largest_opening(const CompiledScene& compiled, std::span<const Contact> contacts) {
  double largest = 0.0;
  for (const Contact& c : contacts) {
    if (c.bonded)
      largest = std::max(largest, c.point.gap);  // of a spring, as far as it is stretched
    const bool opens = compiled.dilates ? c.slip > 0.0 : c.closed_gap > 0.0 && !c.bonded;
    if (!opens) continue;
    const Joint& joint = joint_between(compiled.scene, c.point.key.a, c.point.key.b);
    const double hop = kLargestHop * pair_size(compiled, c.point.key.a, c.point.key.b);
    largest = std::max({largest, opening(joint, c), std::min(c.point.gap, hop)});
  }
  return rounded_up(largest);
}

Reach::Reach(const CompiledScene& compiled, const StepOptions& options, const SearchedState& state,
             std::span<const int> moved, KnownReaches& known)
    : compiled_(compiled), known_(known) {
  const double dt = options.time_step;
  double fall = compiled.scene.gravity.at(state.time + dt).norm() * dt * dt;
  if (!std::isfinite(fall)) fall = 0.0;  // the step will diverge
  new_ = fall != known.fall || state.opening != known.opening;
  known.fall = fall;
  known.opening = state.opening;
  if (!new_) {
    for (const int block : moved) look_at(options, state, block);
  } else {
    known.of_block.assign(state.blocks.size(), 0.0);
    for (std::size_t b = 0; b < state.blocks.size(); ++b)
      look_at(options, state, static_cast<int>(b));
  }
}

void Reach::look_at(const StepOptions& options, const SearchedState& state, int block) {
  const std::size_t b = index(block);
  const BlockModel& model = compiled_.models[b];
  double& reach = known_.of_block[b];
  if (options.analysis != Analysis::Dynamic) {
    reach = rounded_up(compiled_.idle[b] ? 0.0 : static_reach(model));
  } else {
    const double free_fall = compiled_.idle[b] ? 0.0 : known_.fall;
    const double move = vertex_speed(model, state.blocks[b]) * options.time_step + free_fall;
    reach = rounded_up(kReachOfMotion * move);
  }
  reach = std::max(reach, options.reach);  // less would let blocks pass through each other
}

double Reach::of_pair(int a, int b) const {
  const double least =
      std::max(kLeastReach * pair_size(compiled_, a, b), compiled_.scene.coordinate_rounding);
  return std::max({known_.of_block[index(a)], known_.of_block[index(b)], least}) + known_.opening;
}

double Reach::of_all() const { return compiled_.scene.coordinate_rounding + known_.opening; }

double Reach::of_block(int block) const {
  const std::size_t b = index(block);
  const double least = compiled_.idle[b] ? 0.0 : kLeastReach * compiled_.models[b].size;
  return std::max(known_.of_block[b], least) + known_.opening;
}

double Reach::largest() const {
  double largest = of_all();
  for (std::size_t b = 0; b < known_.of_block.size(); ++b)
    largest = std::max(largest, of_block(static_cast<int>(b)));
  return largest;
}

double largest_reach(const Reach& reach, std::span<const geometry::ContactPoint> points) {
  double largest = 0.0;
  for (const geometry::ContactPoint& point : points)
    largest = std::max(largest, reach.of_pair(point.key.a, point.key.b));
  return largest;
}

std::vector<int> blocks_that_can_move(const CompiledScene& compiled) {
  std::vector<int> blocks = compiled.slots.block_of_slot;
  blocks.insert(blocks.end(), compiled.prescribed.begin(), compiled.prescribed.end());
  return blocks;
}

namespace {

/// Of all blocks.
void set_reaches(const CompiledScene& compiled, const Reach& reach, Workspace& work) {
  ++work.search_epoch;
  work.finder.set_reach(reach.of_all());
  for (int b = 0; b < static_cast<int>(compiled.models.size()); ++b)
    work.finder.set_reach(work.handle(b), reach.of_block(b));
}

geometry::FindCounts contacts_of(std::span<const int> blocks, Workspace& work,
                                 std::vector<geometry::ContactPoint>& found) {
  if (work.handles.empty()) return work.finder.contacts_of(blocks, found);
  std::vector<int> handles;
  for (const int block : blocks) handles.push_back(work.handle(block));
  return work.finder.contacts_of(handles, found);
}

/// Keys of parts become those of blocks and of the features of their shapes.
void name_by_block(const CompiledScene& compiled, const Workspace& work,
                   std::vector<geometry::ContactPoint>& found) {
  const auto rename = [&](int& name, geometry::Feature& feature) {
    const int block = work.owners_of_handles[index(name)];
    if (const auto& parts = compiled.models[index(block)].parts) {
      const ReferencePart& part = (*parts)[index(name - work.handle(block))];
      feature.index += part.first[static_cast<std::size_t>(feature.kind)];
    }
    name = block;
  };
  for (geometry::ContactPoint& point : found) {
    rename(point.key.a, point.key.feature_a);
    rename(point.key.b, point.key.feature_b);
  }
  std::ranges::sort(found, {}, &geometry::ContactPoint::key);
}

}  // namespace

geometry::FindCounts find(const CompiledScene& compiled, const SearchedState& state,
                          const Reach& reach, std::span<const int> moved, Searched searched,
                          Workspace& work, std::vector<geometry::ContactPoint>& found) {
  const std::vector<BlockModel>& models = compiled.models;
  if (reach.is_new()) set_reaches(compiled, reach, work);
  for (const int block : moved) {
    const int handle = work.handle(block);
    work.finder.set_reach(handle, reach.of_block(block));
    work.finder.move(handle, placement(models[index(block)], pose(state.blocks[index(block)])));
  }
  const geometry::FindCounts counts =
      searched == Searched::AllBlocks ? work.finder.find(found) : contacts_of(moved, work, found);
  if (compiled.has_parts) name_by_block(compiled, work, found);
  // A placement holds what the rest of a centroid is not.
  for (geometry::ContactPoint& point : found) {
    const BlockState &a = state.blocks[index(point.key.a)], &b = state.blocks[index(point.key.b)];
    point.gap += point.normal.dot(b.centroid_rest - a.centroid_rest);
  }
  if (!work.initial_depths.empty()) work.initial_depths.take_off(compiled, state.blocks, found);
  std::erase_if(found, [&](const geometry::ContactPoint& point) {
    return point.gap > reach.of_pair(point.key.a, point.key.b);
  });
  return counts;
}

void detect(const CompiledScene& compiled, const StepOptions& options, const State& state,
            Workspace& work) {
  work.still = false;
  ++work.search_epoch;
  work.known_reaches = {};
  work.all_changed = true;
  std::ranges::fill(work.at_rest, 0);
  const double opening = largest_opening(compiled, state.contacts);
  const SearchedState searched{state.blocks, opening, state.time};
  const std::vector<int> moved = blocks_that_can_move(compiled);
  find(compiled, searched, Reach(compiled, options, searched, moved, work.known_reaches), moved,
       Searched::AllBlocks, work, work.found);
  work.found.shrink_to_fit();
}

}  // namespace quoin::solver
