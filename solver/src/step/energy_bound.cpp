#include "step/energy_bound.hpp"

#include <algorithm>
#include <cmath>

#include "index.hpp"

namespace quoin::solver {
namespace {

BlockState with_velocity(const BlockState& block, const Vector12& v) {
  BlockState moving = block;
  moving.velocity = v.head<3>();
  moving.angular_velocity = v.segment<3>(3);
  moving.strain_rate = v.tail<6>();
  return moving;
}

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

}  // namespace

void bound_energy(const SubStep& step, const VelocityBalance& balance, std::span<BlockState> end,
                  StepEnergy& energy, std::vector<GroupEnergy>& of_group) {
  const auto& [positions, groups, pushed, allowed] = balance;
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
    energy.load_work += share * pushed[s];
    energy.impact_loss += share * pushed[s];
    if (share == 1.0) continue;
    BlockState& block = end[index(blocks[s])];
    const Vector12 held = positions[s] / step.length;
    block = with_velocity(block, held + share * (velocity_vector(block) - held));
  }
}

}  // namespace quoin::solver
