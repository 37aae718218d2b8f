#include "step/energy_bound.hpp"

#include <algorithm>
#include <cmath>
#include <ranges>

#include "base/index.hpp"
#include "base/rounding.hpp"
#include "linear/small_matrices.hpp"

namespace quoin::solver {
namespace {

/// Share of the way from the positions' velocities, along which kinetic energy is a square: as far
/// as there is energy for, and where that is not even so for these, where it is least.
double allowed_share(const GroupEnergy& e, double allowed) {
  const double available = e.available + allowed * e.magnitude;
  if (!(e.law - e.pushed > available)) return 1.0;
  const double bend = 2.0 * (e.positions + e.law - 2.0 * e.middle);
  const double slope = e.law - e.pushed - e.positions - bend;
  if (!(e.positions < available))
    return bend > 0.0 ? std::clamp(-0.5 * slope / bend, 0.0, 1.0) : 0.0;
  const double left = available - e.positions;  // bend s2 + slope s = left
  const double root = std::sqrt(std::max(0.0, slope * slope + 4.0 * bend * left));
  return std::min(1.0, 2.0 * left / (slope + root));
}

/// Of a group of blocks, about its centroid.
struct Momentum {
  double mass = 0.0;                  ///< kg
  Vector3 moment = Vector3::Zero();   ///< mass times centroid, kg m
  Vector3 linear = Vector3::Zero();   ///< kg m/s
  Vector3 angular = Vector3::Zero();  ///< kg m2/s
  Matrix3 inertia = Matrix3::Zero();  ///< kg m2
  Vector3 centroid() const { return moment / mass; }
  Vector3 velocity() const { return linear / mass; }
};

void add_turning(const BlockModel& model, const BlockState& block, Momentum& of) {
  const Vector3 arm = block.centroid - of.centroid();
  const Matrix3 turn = block.rotation.toRotationMatrix();
  const Vector3 spin =
      model.inertia * block.angular_velocity + model.inertia_coupling * block.strain_rate;
  of.angular += turn * spin + model.mass * arm.cross(block.velocity);
  of.inertia += turn * model.inertia * turn.transpose();
  of.inertia += model.mass * (arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose());
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
    return balance.bouncing[group] && has_more(of_group[group], kRelativeRounding);
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

/// Of islands with held points, where also that leaves more than there is, as where positions that
/// close a gap across a jam are far from any motion: velocities that contacts and supports at rest
/// allow, they allow likewise when all are less. So are those of a group, or, where nothing
/// supports it, what they have beyond its common motion.
void scale_down(const SubStep& step, const VelocityBalance& balance, std::span<BlockState> end,
                std::span<const GroupEnergy> of_group) {
  if (step.island.held.empty()) return;
  const std::vector<int>& blocks = step.island.slots.block_of_slot;
  const auto& groups = balance.groups;
  std::vector<double> now(groups.size(), 0.0), least(groups.size(), 0.0);  // J
  for (std::size_t s = 0; s < groups.size(); ++s) {
    const std::size_t b = index(blocks[s]);
    now[index(groups[s])] += kinetic_energy(step.compiled.models[b], end[b]);
  }
  const auto has_more = [&](int group) {
    const GroupEnergy& e = of_group[index(group)];
    return !balance.driven[index(group)] &&
           now[index(group)] > e.available + balance.allowed * e.magnitude;
  };
  if (std::ranges::none_of(groups, has_more)) return;
  BlockVector common;
  set_common_motion(step, groups, balance.grounded, end, common);
  for (std::size_t s = 0; s < groups.size(); ++s)
    if (balance.grounded[index(groups[s])]) common[s].setZero();
  set_group_energy(step, groups, common, end, least);
  for (std::size_t s = 0; s < groups.size(); ++s) {
    const std::size_t group = index(groups[s]);
    if (!has_more(groups[s]) || !(now[group] > least[group])) continue;
    const double left = std::max(0.0, of_group[group].available - least[group]);
    const double share = std::sqrt(left / (now[group] - least[group]));
    BlockState& block = end[index(blocks[s])];
    block = with_velocity(block, common[s] + share * (velocity_vector(block) - common[s]));
  }
}

}  // namespace

void set_common_motion(const SubStep& step, std::span<const int> groups,
                       std::span<const char> grounded, std::span<const BlockState> end,
                       BlockVector& common) {
  const std::vector<int>& blocks = step.island.slots.block_of_slot;
  std::vector<Momentum> momenta(groups.size());
  const auto of = [&](std::size_t s) -> Momentum& { return momenta[index(groups[s])]; };
  for (std::size_t s = 0; s < groups.size(); ++s) {
    const BlockState& block = end[index(blocks[s])];
    const double mass = step.compiled.models[index(blocks[s])].mass;
    of(s).mass += mass;
    of(s).moment += mass * block.centroid;
    of(s).linear += mass * block.velocity;
  }
  for (std::size_t s = 0; s < groups.size(); ++s)
    add_turning(step.compiled.models[index(blocks[s])], end[index(blocks[s])], of(s));
  common.assign(groups.size(), Vector12::Zero());
  for (std::size_t s = 0; s < groups.size(); ++s) {
    common[s].head<3>() = of(s).velocity();
    if (grounded[index(groups[s])]) continue;
    const BlockState& block = end[index(blocks[s])];
    Matrix3 inverse;
    invert_symmetric(of(s).inertia, inverse);
    const Vector3 spin = inverse * of(s).angular;
    common[s].head<3>() += spin.cross(block.centroid - of(s).centroid());
    common[s].segment<3>(3) = block.rotation.conjugate() * spin;
  }
}

void set_group_energy(const SubStep& step, std::span<const int> groups, const BlockVector& velocity,
                      std::span<const BlockState> end, std::vector<double>& energy) {
  energy.assign(groups.size(), 0.0);
  for (std::size_t s = 0; s < groups.size(); ++s) {
    const std::size_t b = index(step.island.slots.block_of_slot[s]);
    energy[index(groups[s])] +=
        kinetic_energy(step.compiled.models[b], with_velocity(end[b], velocity[s]));
  }
}

void bound_energy(const SubStep& step, const VelocityBalance& balance, std::span<BlockState> end,
                  StepEnergy& energy, std::vector<GroupEnergy>& of_group) {
  const auto& [positions, groups, pushed, allowed, bouncing, grounded, driven] = balance;
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
  scale_down(step, balance, end, of_group);
}

}  // namespace quoin::solver
