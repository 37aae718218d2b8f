#include "step/restitution.hpp"

#include <algorithm>
#include <cmath>

#include "base/index.hpp"
#include "step/energy_bound.hpp"

namespace quoin::solver {
namespace {

constexpr double kEnergyRounding = 1e-9;  // of the energy before an impact
// Of the restitution, where that has made energy, between these, by what energy goes with it; and
// none after the last share: eight tries at most.
constexpr double kLessBounce = 0.5, kMostBounce = 0.8, kLeastBounce = 0.25;
// Of the energy of a group's motion against each other: so much is taken off that motion. Arms that
// turn between impact and end of step, and velocities of crowds that are good to 1e-6 of forces,
// make it, not the restitution.
constexpr double kSlight = 0.1;

double mechanical_energy(const SubStep& step, std::size_t block,
                         std::span<const BlockState> state) {
  return kinetic_energy(step.compiled.models[block], state[block]) +
         strain_energy(step.compiled.models[block], state[block]);
}

}  // namespace

void Restitution::begin(const SubStep& step, const VelocityProblem& problem,
                        const SquareBlocks& compliance, std::span<const BlockState> end) {
  const std::size_t slots = problem.force.size();
  joined_.part(slots);
  for (const LinearContact& c : problem.contacts)
    if (c.slot_a >= 0 && c.slot_b >= 0) joined_.join(c.slot_a, c.slot_b);
  for (const auto& [a, b] : problem.pushed_before) joined_.join(a, b);
  groups_.resize(slots);
  for (std::size_t s = 0; s < slots; ++s) groups_[s] = joined_.least(static_cast<int>(s));
  bouncing_.assign(slots, 0);
  grounded_.assign(slots, 0);
  driven_.assign(slots, 0);
  for (std::size_t i = 0; i < problem.starts.size(); ++i) {
    const LinearContact& c = problem.contacts[i];
    if (c.slot_a < 0 || c.slot_b < 0) grounded_[group_of(c)] = 1;
    if (!c.start.isZero(0.0)) driven_[group_of(c)] = 1;
    if (problem.starts[i].bounce != 0.0) bouncing_[group_of(c)] = 1;
  }
  shares_.assign(bouncing_.begin(), bouncing_.end());
  if (std::ranges::none_of(bouncing_, [](char bounces) { return bounces != 0; })) return;
  free_.assign(slots, 0.0);
  for (std::size_t s = 0; s < slots; ++s) {
    const std::size_t b = index(step.island.slots.block_of_slot[s]);
    const BlockModel& model = step.compiled.models[b];
    // Velocity times dt, without impulses.
    const Vector12 free = compliance.times(s, problem.force[s]);
    const BlockState moving = with_velocity(end[b], free / step.length);
    free_[index(groups_[s])] += kinetic_energy(model, moving) + strain_energy(model, moving);
  }
}

void Restitution::apply(const VelocityProblem& problem) const {
  for (std::size_t i = 0; i < problem.starts.size(); ++i) {
    const VelocityProblem::Start& start = problem.starts[i];
    LinearContact& c = problem.contacts[i];
    c.multiplier = start.multiplier;
    c.normal_stiffness = start.normal_stiffness;
    c.shear_stiffness = start.shear_stiffness;
    c.assumed = start.assumed;
    c.offset[0] = start.gap + shares_[group_of(c)] * start.bounce;
  }
}

bool Restitution::lessen(const SubStep& step, const WorkOnBlocks& work,
                         std::span<const BlockState> end) {
  if (std::ranges::none_of(shares_, [](double share) { return share > 0.0; })) return false;
  pushed_.assign(shares_.size(), 0.0);
  available_.assign(shares_.size(), 0.0);
  now_.assign(shares_.size(), 0.0);
  strained_.assign(shares_.size(), 0.0);
  for (std::size_t s = 0; s < groups_.size(); ++s) {
    const std::size_t b = index(step.island.slots.block_of_slot[s]), group = index(groups_[s]);
    available_[group] += mechanical_energy(step, b, step.state) + work.forces[s] + work.impulses[s];
    pushed_[group] += work.impulses[s];
    now_[group] += mechanical_energy(step, b, end);
    strained_[group] += strain_energy(step.compiled.models[b], end[b]);
  }
  BlockVector common;
  set_common_motion(step, groups_, grounded_, end, common);
  std::vector<double> least;  // J, left by bound_energy()
  set_group_energy(step, groups_, common, end, least);
  bool any = false;
  for (std::size_t group = 0; group < shares_.size(); ++group) {
    const double rounding = kEnergyRounding * std::abs(available_[group]);
    if (now_[group] <= available_[group] + rounding || !(shares_[group] > 0.0)) continue;
    const double relative = now_[group] - strained_[group] - least[group];
    const double gained = now_[group] - free_[group] - pushed_[group];  // by impulses
    const bool taken_off = now_[group] - relative <= available_[group];
    if (taken_off && gained <= kSlight * relative + rounding) continue;
    const double excess = std::max(gained, now_[group] - available_[group]);
    const double kept = std::sqrt(std::max(0.0, 1.0 - 2.0 * excess / relative));
    const double less = std::clamp(kept, kLessBounce, kMostBounce);
    shares_[group] = shares_[group] > kLeastBounce ? less * shares_[group] : 0.0;
    any = true;
  }
  return any;
}

std::size_t Restitution::group_of(const LinearContact& c) const {
  return index(groups_[index(c.slot_a >= 0 ? c.slot_a : c.slot_b)]);
}

}  // namespace quoin::solver
