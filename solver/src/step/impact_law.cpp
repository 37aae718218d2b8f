#include "step/impact_law.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "contact/joint_law.hpp"
#include "step/energy_bound.hpp"
#include "step/joined_groups.hpp"

namespace quoin::solver {
namespace {

constexpr double kEnergyRounding = 1e-9;  // of the energy before an impact
constexpr double kLessBounce = 0.5;       // of the restitution, where that has made energy, and
constexpr double kLeastBounce = 0.25;     // none after this share of it: two tries
// Of what friction can stop within a step. Measured: from 1e-4 to 1e-2 walls at 0.98 of their limit
// load keep still and no row of validate changes; from 0 they gain energy.
constexpr double kCreep = 1e-3;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

/// What the velocity problem is made from.
struct ImpactStep {
  const SubStep& step;
  const BlockTerms& terms;
  const StepPoses& poses;
  std::span<const BlockState> end;  ///< as the positions have it
  BlockVector free_gain;  ///< by slot: of velocity over the step by what acts but new contacts
  double slowest = 0.0;   ///< m/s: no slower impact bounces
};

/// A contact of velocities: d is the relative velocity times dt, the force 2/dt of the impulse.
struct VelocityContact {
  LinearContact contact;
  double bounce = 0.0;  ///< of d, with full restitution, m
};

/// All of them, and the blocks' equations.
struct VelocityProblem {
  std::vector<LinearContact> contacts;
  std::vector<double> bounces;  ///< by contact
  BlockVector velocity, force;  ///< by slot: velocity times dt as the positions have it, F
};

void set_velocity(const Vector12& v, BlockState& block) {
  block.velocity = v.head<3>();
  block.angular_velocity = v.segment<3>(3);
  block.strain_rate = v.tail<6>();
}

/// Relative velocity of a contact from the velocities of both blocks, wherever they come from.
Vector3 relative_velocity(const BodyContact& contact, const LinearContact& c,
                          std::span<const BlockState> blocks) {
  return c.jacobian_a * velocity_vector(blocks[index(contact.a)]) +
         c.jacobian_b * velocity_vector(blocks[index(contact.b)]);
}

/// Gain of relative normal velocity over the step by what acts but new contacts, m/s.
double relative_free_gain(const LinearContact& c, const BlockVector& free_gain) {
  double gain = 0.0;
  if (c.slot_a >= 0) gain += c.jacobian_a.row(0).dot(free_gain[index(c.slot_a)]);
  if (c.slot_b >= 0) gain += c.jacobian_b.row(0).dot(free_gain[index(c.slot_b)]);
  return gain;
}

/// 2 (D_free/dt - v) of each block.
BlockVector free_velocity_gain(const SubStep& step, const BlockTerms& terms,
                               const StepPoses& poses) {
  BlockVector gain(terms.force.size());
  for (std::size_t s = 0; s < gain.size(); ++s) {
    const std::size_t b = index(step.island.slots.block_of_slot[s]);
    gain[s] = 2.0 * (terms.free_increment[s] / step.length - velocity_vector(step.state[b]));
    if (!poses.deforms[b]) gain[s].tail<6>().setZero();
  }
  return gain;
}

/// Sliding that is more than creep against what friction can stop within a step: it goes on with
/// the friction that the positions gave it, along the mean direction of the step (second order). Of
/// a creeping contact the sign of the slip says nothing, and its friction follows the normal
/// impulse; so does that of a new contact that friction can stop.
bool slides_on(const ImpactStep& at, const BodyContact& contact, const LinearContact& c) {
  const Vector3 now = relative_velocity(contact, c, at.end);
  const double friction = c.multiplier.tail<2>().norm();
  const std::vector<Matrix12>& compliance = at.terms.compliance;
  const double stopped = friction * shear_compliance(c, compliance);
  return now.tail<2>().dot(c.multiplier.tail<2>()) <= 0.0 &&
         now.tail<2>().norm() * at.step.length > (contact.was_closed ? kCreep : 1.0) * stopped;
}

/// Between the impact and the end of the step the rebound goes on like free flight.
double full_bounce(const ImpactStep& at, const BodyContact& contact, const LinearContact& position,
                   const LinearContact& c) {
  const double approach = relative_velocity(contact, c, at.step.state)[0];
  const double gain = relative_free_gain(c, at.free_gain);
  const double impact = approach + position.closing_share * gain;
  if (!(impact < -at.slowest) || !(contact.joint.restitution > 0.0)) return 0.0;
  const double flight = position.closing_share > 0.0 ? (1.0 - position.closing_share) * gain : 0.0;
  return at.step.length * (contact.joint.restitution * impact - flight);
}

/// What a contact bore, in its frame with this normal, N.
Vector3 force_in_frame(const Contact& force, const BodyContact& contact, const Vector3& normal) {
  Vector3 t1, t2;
  tangent_frame(contact, normal, t1, t2);
  const Vector3& shear = force.shear_force;  // on A
  return Vector3(force.normal_force, -t1.dot(shear), -t2.dot(shear));
}

/// `contact`: as it ended, `position`: as it was solved. None where nothing is to be set.
std::optional<VelocityContact> velocity_contact(const ImpactStep& at, const BodyContact& contact,
                                                const LinearContact& position) {
  if (position.mode == ContactMode::Open || position.compliant) return {};
  VelocityContact result{.contact = position};
  LinearContact& c = result.contact;
  const double dt = at.step.length;
  c.normal_spring = c.shear_spring = 0.0;
  c.cohesion = 2.0 * position.cohesion;
  linearise_velocity(contact, at.poses, c);
  if (c.slot_a < 0) c.offset += dt * (c.jacobian_a * velocity_vector(at.end[index(contact.a)]));
  if (c.slot_b < 0) c.offset += dt * (c.jacobian_b * velocity_vector(at.end[index(contact.b)]));
  c.start = c.offset;
  result.bounce = full_bounce(at, contact, position, c);
  c.multiplier = 2.0 * force_in_frame(contact.state, contact, contact.state.point.normal);
  const bool resting = !contact.state.impact;
  if (c.law == ContactLaw::Coulomb && position.mode == ContactMode::Slip && resting) {
    if (slides_on(at, contact, c)) c.law = ContactLaw::Frictionless;
  }
  if (c.law == ContactLaw::Frictionless) c.multiplier.tail<2>().setZero();
  c.assumed = position.mode;
  if (position.mode == ContactMode::Slip) {  // a joint that dilates opens
    const double sliding = relative_velocity(contact, c, at.end).tail<2>().norm();
    c.offset[0] -= dt * dilation_slope(contact.joint, contact.state) * sliding;
  }
  return result;
}

LinearContact velocity_held_point(const ImpactStep& at, const HeldPoint& held,
                                  const LinearContact& position) {
  const std::size_t b = index(held.block);
  LinearContact c = position;
  c.jacobian_b = motion(at.poses.end[b], held.arm, at.poses.deforms[b] != 0);
  const double time = at.step.end_time(), eps = 0.5 * at.step.length;
  c.offset.setZero();
  if (!held.displacement.is_constant()) {
    c.offset = -(held.displacement.at(time + eps) - held.displacement.at(time - eps));
  }
  c.start = c.offset;
  c.multiplier = 2.0 * position.force;
  return c;
}

/// Until the first impact contacts that were closed before pushed as in the last step,
/// unless that was an impulse.
void add_earlier_impulses(std::span<const BodyContact> contacts, const Attempt& attempt,
                          BlockVector& force) {
  const double share = attempt.first_impact;
  if (!(share > 0.0)) return;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& before = contacts[i].state;
    const LinearContact& c = attempt.linear[i];
    if (!contacts[i].was_closed || before.impact || c.compliant) continue;
    const Vector3 push =
        2.0 * share * force_in_frame(before, contacts[i], attempt.contacts[i].state.point.normal);
    if (c.slot_a >= 0) force[index(c.slot_a)] += c.jacobian_a.transpose() * push;
    if (c.slot_b >= 0) force[index(c.slot_b)] += c.jacobian_b.transpose() * push;
  }
}

void add_contacts(const ImpactStep& at, const Attempt& attempt, VelocityProblem& problem) {
  const auto add = [&](const VelocityContact& made) {
    problem.contacts.push_back(made.contact);
    set_augmentation(at.terms.compliance, problem.contacts.back());
    problem.bounces.push_back(made.bounce);
  };
  for (std::size_t i = 0; i < attempt.contacts.size(); ++i) {
    const auto made = velocity_contact(at, attempt.contacts[i], attempt.linear[i]);
    if (made) add(*made);
  }
  for (std::size_t h = 0; h < at.step.island.held.size(); ++h) {
    const HeldPoint& held = at.step.compiled.held[index(at.step.island.held[h])];
    add({velocity_held_point(at, held, attempt.linear[attempt.contacts.size() + h])});
  }
}

void add_blocks(const ImpactStep& at, std::span<const BodyContact> contacts, const Attempt& attempt,
                VelocityProblem& problem) {
  const std::vector<int>& blocks = at.step.island.slots.block_of_slot;
  problem.velocity.resize(blocks.size());
  problem.force.resize(blocks.size());
  for (std::size_t s = 0; s < blocks.size(); ++s) {
    Vector12& velocity = problem.velocity[s];
    velocity = at.step.length * velocity_vector(at.end[index(blocks[s])]);
    if (!at.poses.deforms[index(blocks[s])]) velocity.tail<6>().setZero();
    problem.force[s] = at.terms.base.diagonal[s] * velocity;
  }
  add_earlier_impulses(contacts, attempt, problem.force);
  for (const LinearContact& c : problem.contacts) {
    if (c.slot_a >= 0) {
      problem.force[index(c.slot_a)] -= c.jacobian_a.transpose() * c.multiplier;
    }
    if (c.slot_b >= 0) {
      problem.force[index(c.slot_b)] -= c.jacobian_b.transpose() * c.multiplier;
    }
  }
}

/// By slot: the least slot of the group of blocks that closed contacts join.
std::vector<int> joined_groups(std::size_t slots, std::span<const LinearContact> contacts) {
  JoinedGroups groups(slots);
  for (const LinearContact& c : contacts) {
    if (c.slot_a >= 0 && c.slot_b >= 0) groups.join(c.slot_a, c.slot_b);
  }
  std::vector<int> least(slots);
  for (std::size_t s = 0; s < slots; ++s) least[s] = groups.least(static_cast<int>(s));
  return least;
}

/// Restitution of each group of blocks that closed contacts join.
class Restitution {
 public:
  Restitution(std::size_t slots, const VelocityProblem& problem)
      : groups_(joined_groups(slots, problem.contacts)), shares_(slots, 0.0) {
    for (std::size_t i = 0; i < problem.bounces.size(); ++i) {
      if (problem.bounces[i] != 0.0) shares_[group_of(problem.contacts[i])] = 1.0;
    }
  }

  /// The contacts with their bounce, or what is left of it.
  std::vector<LinearContact> apply(const VelocityProblem& problem) const {
    std::vector<LinearContact> contacts = problem.contacts;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      contacts[i].offset[0] += shares_[group_of(contacts[i])] * problem.bounces[i];
    }
    return contacts;
  }

  /// Less of it for groups that have more energy than they had, with the work done on them; true
  /// when there are any.
  bool lessen(const SubStep& step, std::span<const double> work_on,
              std::span<const BlockState> end) {
    if (std::ranges::none_of(shares_, [](double share) { return share > 0.0; })) return false;
    std::vector<double> available(shares_.size(), 0.0), now(shares_.size(), 0.0);
    for (std::size_t s = 0; s < groups_.size(); ++s) {
      const std::size_t b = index(step.island.slots.block_of_slot[s]), group = index(groups_[s]);
      available[group] += mechanical_energy(step, b, step.state) + work_on[s];
      now[group] += mechanical_energy(step, b, end);
    }
    bool any = false;
    for (std::size_t group = 0; group < shares_.size(); ++group) {
      const double rounding = kEnergyRounding * std::abs(available[group]);
      if (now[group] <= available[group] + rounding || !(shares_[group] > 0.0)) continue;
      shares_[group] = shares_[group] > kLeastBounce ? kLessBounce * shares_[group] : 0.0;
      any = true;
    }
    return any;
  }

  /// By slot: the least slot of its group.
  std::span<const int> groups() const { return groups_; }

 private:
  static double mechanical_energy(const SubStep& step, std::size_t block,
                                  std::span<const BlockState> state) {
    return kinetic_energy(step.compiled.models[block], state[block]) +
           strain_energy(step.compiled.models[block], state[block]);
  }
  std::size_t group_of(const LinearContact& c) const {
    return index(groups_[index(c.slot_a >= 0 ? c.slot_a : c.slot_b)]);
  }

  std::vector<int> groups_;
  std::vector<double> shares_;  ///< by group; 0 where nothing bounces
};

/// Work of moving supports by the impulses beyond the positions' forces, by slot, J.
std::vector<double> pushed_work(std::size_t slots, const VelocityProblem& problem,
                                std::span<const LinearContact> solved) {
  std::vector<double> pushed(slots, 0.0);
  for (std::size_t i = 0; i < solved.size(); ++i) {
    const LinearContact& c = solved[i];
    pushed[index(c.slot_a >= 0 ? c.slot_a : c.slot_b)] -=
        0.5 * (c.force - problem.contacts[i].multiplier).dot(c.start);
  }
  return pushed;
}

}  // namespace

void attempt_velocities(const SubStep& step, std::span<const BodyContact> contacts,
                        AttemptMemory& memory, BlocksAtEnd& blocks, Attempt& attempt) {
  const std::vector<int>& own = step.island.slots.block_of_slot;
  if (own.empty()) return;
  const ImpactStep at{step,
                      memory.terms,
                      blocks.poses,
                      blocks.end,
                      free_velocity_gain(step, memory.terms, blocks.poses),
                      step.bounce_speed()};
  VelocityProblem problem;
  add_contacts(at, attempt, problem);
  if (problem.contacts.empty()) return;
  add_blocks(at, contacts, attempt, problem);
  OpenCloseOptions tuning{.force_tolerance = step.options.tolerance,
                          .gap_tolerance = step.gap_tolerance()};
  tuning.gap_rounding = gap_rounding(attempt.linear);
  tuning.raise = tuning.predicted = true;
  const double before = kinetic_energy(step, blocks.end);
  Restitution restitution(own.size(), problem);
  OpenCloseResult total = attempt.solved;
  // With friction and several contacts Newton's restitution can create energy: less of it then.
  std::vector<LinearContact> tried;
  for (bool again = true; again;) {
    tried = restitution.apply(problem);
    BlockVector solution = problem.velocity;
    memory.clock.charge(&PhaseSeconds::assemble);
    const OpenCloseResult solved = memory.solver.solve(
        step.options, {memory.terms.base, problem.force}, tried, tuning, solution);
    memory.clock.charge(&PhaseSeconds::solve);
    for (std::size_t s = 0; s < own.size(); ++s) {
      set_velocity(solution[s] / step.length, blocks.end[index(own[s])]);
    }
    add(solved, total);
    again = restitution.lessen(step, attempt.energy.work_on, blocks.end);
  }
  total.converged = total.converged && attempt.solved.converged;
  total.residual = std::max(total.residual, attempt.solved.residual);
  total.condition = attempt.solved.condition;
  attempt.solved = total;
  bound_energy(step,
               {problem.velocity, restitution.groups(), pushed_work(own.size(), problem, tried)},
               blocks.end, attempt.energy);
  attempt.energy.impact_loss += before - kinetic_energy(step, blocks.end);
}

}  // namespace quoin::solver
