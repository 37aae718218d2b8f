#include "step/contact_search.hpp"

#include <algorithm>
#include <cmath>

#include "contact/joint_law.hpp"

namespace quoin::solver {
namespace {

constexpr double kLargestHop = 0.1;   // of the smaller block of a pair
constexpr double kLeastReach = 1e-4;  // of the smallest block
constexpr double kReachOfMotion =
    2.0;                              // of what a vertex can move in a step   [Beyabanaki 2009], 3
constexpr double kReachGrain = 16.0;  // parts of a power of two

std::size_t index(int i) { return static_cast<std::size_t>(i); }

/// Twice what a vertex can move in a step (paper, section 3), and never less than a hair of a
/// block.
double wanted_reach(const CompiledScene& compiled, const StepOptions& options,
                    const SearchedState& state) {
  if (options.analysis != Analysis::Dynamic) return static_reach(compiled);
  const double dt = options.time_step;
  const double fall = compiled.scene.gravity.at(state.time + dt).norm() * dt * dt;
  const double least = kLeastReach * compiled.smallest_size;
  double speed = 0.0;
  for (std::size_t b = 0; b < state.blocks.size(); ++b) {
    speed = std::max(speed, vertex_speed(compiled.models[b], state.blocks[b]));
  }
  return std::max(kReachOfMotion * (speed * dt + fall), least);
}

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
  if (!compiled.dilates) return 0.0;
  double largest = 0.0;
  for (const Contact& c : contacts) {
    if (!(c.slip > 0.0)) continue;
    const Joint& joint = joint_between(compiled.scene, c.point.key.a, c.point.key.b);
    const double hop = kLargestHop * pair_size(compiled, c.point.key.a, c.point.key.b);
    largest = std::max({largest, opening(joint, c), std::min(c.point.gap, hop)});
  }
  return rounded_up(largest);
}

std::vector<int> blocks_that_can_move(const CompiledScene& compiled) {
  std::vector<int> blocks = compiled.slots.block_of_slot;
  blocks.insert(blocks.end(), compiled.prescribed.begin(), compiled.prescribed.end());
  return blocks;
}

geometry::FindCounts find(const CompiledScene& compiled, const StepOptions& options,
                          const SearchedState& state, Workspace& work,
                          std::vector<geometry::ContactPoint>& found) {
  work.reach =
      options.reach > 0.0 ? options.reach : rounded_up(wanted_reach(compiled, options, state));
  work.reach += state.opening;
  work.finder.set_reach(work.reach);
  const auto move = [&](int block) {
    const std::size_t b = index(block);
    work.finder.move(block, placement(compiled.models[b], pose(state.blocks[b])));
  };
  std::ranges::for_each(state.moved, move);
  const geometry::FindCounts counts = work.finder.find(found);
  // A placement holds what the rest of a centroid is not.
  for (geometry::ContactPoint& point : found) {
    const BlockState &a = state.blocks[index(point.key.a)], &b = state.blocks[index(point.key.b)];
    point.gap += point.normal.dot(b.centroid_rest - a.centroid_rest);
  }
  if (!work.initial_depths.empty()) {
    work.initial_depths.take_off(compiled.models, state.blocks, found);
  }
  return counts;
}

void detect(const CompiledScene& compiled, const StepOptions& options, const State& state,
            Workspace& work) {
  work.still = false;
  const std::vector<int> moved = blocks_that_can_move(compiled);
  find(compiled, options,
       {state.blocks, moved, largest_opening(compiled, state.contacts), state.time}, work,
       work.found);
}

}  // namespace quoin::solver
