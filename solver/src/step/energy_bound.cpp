#include "step/energy_bound.hpp"

#include <algorithm>
#include <cmath>
#include <ranges>

#include "base/index.hpp"
#include "step/common_motion.hpp"

namespace quoin::solver {
namespace {

constexpr double kBounceRounding = 1e-9;  // of the energy that goes in, as for Restitution

/// Share of the way from the positions' velocities, along which kinetic energy is a square: as far
/// as there is energy for, and where that is not even so for these, where it is least.
double allowed_share(const GroupEnergy& e, double allowed) {
  const double available = e.available + allowed * e.magnitude;
  if (!(e.law - e.pushed > available)) return 1.0;
  const double bend = 2.0 * (e.positions + e.law - 2.0 * e.middle);
  const double slope = e.law - e.pushed - e.positions - bend;
  if (!(e.positions < available)) {
    return bend > 0.0 ? std::clamp(-0.5 * slope / bend, 0.0, 1.0) : 0.0;
  }
  const double left = available - e.positions;  // bend s2 + slope s = left
  const double root = std::sqrt(std::max(0.0, slope * slope + 4.0 * bend * left));
  return std::min(1.0, 2.0 * left / (slope + root));
}

bool has_more(const GroupEnergy& e, double allowed) {
  return e.law - e.pushed > e.available + allowed * e.magnitude;
}

/// Of groups that bounce. The positions of an impact include its rebound's flight, so that their
/// velocities keep no balance; and velocities are those of blocks that have turned since. What is
/// too much is taken from the motion of the blocks against each other.
void take_from_relative_motion(const SubStep& step, const VelocityBalance& balance,
                               std::span<BlockState> end, std::span<GroupEnergy> of_group) {
  const std::vector<int>& blocks = step.island.slots.block_of_slot;
  const auto& groups = balance.groups;
  const auto rebounds = [&](std::size_t group) {
    return balance.bouncing[group] && has_more(of_group[group], kBounceRounding);
  };
  const auto all = std::views::iota(std::size_t{0}, balance.bouncing.size());
  if (std::ranges::none_of(all, rebounds)) return;
  BlockVector common;
  set_common_motion(step, groups, balance.grounded, end, common);
  std::vector<double> least;  // J
  set_group_energy(step, groups, common, end, least);
  for (std::size_t s = 0; s < groups.size(); ++s) {
    const std::size_t group = index(groups[s]);
    const GroupEnergy& e = of_group[group];
    const double left = e.available + e.pushed - least[group];
    if (!rebounds(group) || !(left >= 0.0)) continue;
    BlockState& block = end[index(blocks[s])];
    const double share = std::sqrt(left / (e.law - least[group]));
    block = with_velocity(block, common[s] + share * (velocity_vector(block) - common[s]));
  }
  for (std::size_t group = 0; group < least.size(); ++group) {
    GroupEnergy& e = of_group[group];
    if (rebounds(group) && e.available + e.pushed >= least[group]) e.law = e.available + e.pushed;
  }
}

}  // namespace

void bound_energy(const SubStep& step, const VelocityBalance& balance, std::span<BlockState> end,
                  StepEnergy& energy, std::vector<GroupEnergy>& of_group) {
  const auto& [positions, groups, pushed, allowed, bouncing, grounded] = balance;
  const std::vector<int>& blocks = step.island.slots.block_of_slot;
  of_group.assign(groups.size(), {});
  for (std::size_t s = 0; s < groups.size(); ++s) {
    const std::size_t b = index(blocks[s]);
    const BlockModel& model = step.compiled.models[b];
    const BlockState &first = step.state[b], &last = end[b];
    const double before = kinetic_energy(model, first) + strain_energy(model, first);
    const double strained = strain_energy(model, last);
    GroupEnergy& e = of_group[index(groups[s])];
    e.available += before + energy.work_on[s] - strained;
    e.magnitude += before + std::abs(energy.work_on[s]) + strained;
    e.pushed += pushed[s];
    e.law += kinetic_energy(model, last);
  }
  take_from_relative_motion(step, balance, end, of_group);
  for (std::size_t s = 0; s < groups.size(); ++s) {
    GroupEnergy& e = of_group[index(groups[s])];
    if (!has_more(e, allowed)) continue;
    const BlockModel& model = step.compiled.models[index(blocks[s])];
    const BlockState& last = end[index(blocks[s])];
    const Vector12 held = positions[s] / step.length, free = velocity_vector(last);
    e.positions += kinetic_energy(model, with_velocity(last, held));
    e.middle += kinetic_energy(model, with_velocity(last, 0.5 * (held + free)));
  }
  for (std::size_t s = 0; s < groups.size(); ++s) {
    const double share = allowed_share(of_group[index(groups[s])], allowed);
    of_group[index(groups[s])].share = share;
    energy.load_work += share * pushed[s];
    energy.impact_loss += share * pushed[s];
    if (share == 1.0) continue;
    BlockState& block = end[index(blocks[s])];
    const Vector12 held = positions[s] / step.length;
    block = with_velocity(block, held + share * (velocity_vector(block) - held));
  }
}

}  // namespace quoin::solver
