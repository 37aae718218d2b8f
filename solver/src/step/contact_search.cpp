#include "step/contact_search.hpp"

#include <algorithm>
#include <cmath>

#include "contact/joint_law.hpp"
#include "index.hpp"

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

/// Not below it: where blocks are at rest it seldom changes, for then all pairs are searched again.
double power_of_two(double reach) {
  int exponent = 0;
  return std::frexp(reach, &exponent) == 0.5 ? reach : std::ldexp(1.0, exponent);
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

Reach::Reach(const CompiledScene& compiled, const StepOptions& options, const SearchedState& state,
             std::vector<double>& of_block)
    : compiled_(compiled), of_block_(of_block), opening_(state.opening) {
  of_block_.assign(state.blocks.size(), 0.0);
  const double dt = options.time_step;
  const double fall = compiled.scene.gravity.at(state.time + dt).norm() * dt * dt;
  for (std::size_t b = 0; b < of_block_.size(); ++b) {
    const BlockModel& model = compiled.models[b];
    if (options.reach > 0.0) {
      of_block_[b] = options.reach;
    } else if (options.analysis != Analysis::Dynamic) {
      of_block_[b] = compiled.idle[b] ? 0.0 : static_reach(model);
    } else {
      const double free_fall = compiled.idle[b] ? 0.0 : fall;
      of_block_[b] = kReachOfMotion * (vertex_speed(model, state.blocks[b]) * dt + free_fall);
    }
    if (options.reach <= 0.0) of_block_[b] = rounded_up(of_block_[b]);
  }
}

double Reach::of_pair(int a, int b) const {
  const double least =
      std::max(kLeastReach * pair_size(compiled_, a, b), compiled_.scene.coordinate_rounding);
  return std::max({of_block_[index(a)], of_block_[index(b)], least}) + opening_;
}

double Reach::largest() const {
  double largest = 0.0;
  for (std::size_t b = 0; b < of_block_.size(); ++b) {
    const double least = compiled_.idle[b] ? 0.0 : kLeastReach * compiled_.models[b].size;
    largest = std::max({largest, of_block_[b], least});
  }
  return std::max(largest, compiled_.scene.coordinate_rounding) + opening_;
}

std::vector<int> blocks_that_can_move(const CompiledScene& compiled) {
  std::vector<int> blocks = compiled.slots.block_of_slot;
  blocks.insert(blocks.end(), compiled.prescribed.begin(), compiled.prescribed.end());
  return blocks;
}

geometry::FindCounts find(const CompiledScene& compiled, const SearchedState& state,
                          const Reach& reach, std::span<const int> moved, Workspace& work,
                          std::vector<geometry::ContactPoint>& found) {
  const std::vector<BlockModel>& models = compiled.models;
  const bool rests = std::ranges::find(work.at_rest, 1) != work.at_rest.end();
  const double searched = rests ? power_of_two(reach.largest()) : reach.largest();
  if (searched != work.searched_reach) ++work.search_epoch;
  work.searched_reach = searched;
  work.finder.set_reach(searched);
  for (const int block : moved) {
    work.finder.move(block, placement(models[index(block)], pose(state.blocks[index(block)])));
  }
  const geometry::FindCounts counts = work.finder.find(found);
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
  std::ranges::fill(work.at_rest, 0);
  const SearchedState searched{state.blocks, largest_opening(compiled, state.contacts), state.time};
  find(compiled, searched, Reach(compiled, options, searched, work.reach_of_block),
       blocks_that_can_move(compiled), work, work.found);
}

}  // namespace quoin::solver
