#include "step/impact_law.hpp"

#include <algorithm>
#include <cmath>

#include "contact/joint_law.hpp"
#include "index.hpp"

namespace quoin::solver {
namespace {

// Of what friction can stop within a step. Measured: from 1e-4 to 1e-2 walls at 0.98 of their limit
// load keep still and no row of validate changes; from 0 they gain energy.
constexpr double kCreep = 1e-3;

/// What the velocity problem is made from.
struct ImpactStep {
  const SubStep& step;
  const BlockTerms& terms;
  const StepPoses& poses;
  std::span<const BlockState> end;  ///< as the positions have it
  const BlockVector& free_gain;     ///< by slot: of velocity by what acts but new contacts
  double slowest = 0.0;             ///< m/s: no slower impact bounces
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

/// Of it, along the normal.
double normal_velocity(const BodyContact& contact, const LinearContact& c,
                       std::span<const BlockState> blocks) {
  const auto along = [&](const Matrix3x12& jacobian, int block) {
    const BlockState& state = blocks[index(block)];
    const auto row = jacobian.row(0);
    return row.head<3>().dot(state.velocity) + row.segment<3>(3).dot(state.angular_velocity) +
           row.tail<6>().dot(state.strain_rate);
  };
  return along(c.jacobian_a, contact.a) + along(c.jacobian_b, contact.b);
}

/// Gain of relative normal velocity over the step by what acts but new contacts, m/s.
double relative_free_gain(const LinearContact& c, const BlockVector& free_gain) {
  double gain = 0.0;
  if (c.slot_a >= 0) gain += c.jacobian_a.row(0).dot(free_gain[index(c.slot_a)]);
  if (c.slot_b >= 0) gain += c.jacobian_b.row(0).dot(free_gain[index(c.slot_b)]);
  return gain;
}

/// 2 (D_free/dt - v) of each block: what a rebound is found with.
void set_free_velocity_gain(const SubStep& step, const BlockTerms& terms, const StepPoses& poses,
                            BlockVector& gain) {
  gain.resize(terms.force.size());
  for (std::size_t s = 0; s < gain.size(); ++s) {
    const std::size_t b = index(step.island.slots.block_of_slot[s]);
    gain[s] = 2.0 * (terms.free_increment[s] / step.length - velocity_vector(step.state[b]));
    if (!poses.deforms[b]) gain[s].tail<6>().setZero();
  }
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

/// Between the impact and the end of the step the rebound goes on like free flight. What was closed
/// at the start does not come on: the last velocities saw to that.
double full_bounce(const ImpactStep& at, const BodyContact& contact, const LinearContact& position,
                   const LinearContact& c) {
  if (!(contact.joint.restitution > 0.0) || contact.was_closed) return 0.0;
  const double approach = normal_velocity(contact, c, at.step.state);
  const bool closed = position.closing_share > 0.0;
  const double gain = closed ? relative_free_gain(c, at.free_gain) : 0.0;
  const double impact = approach + position.closing_share * gain;
  if (!(impact < -at.slowest)) return 0.0;
  const double flight = (1.0 - position.closing_share) * gain;
  return at.step.length * (contact.joint.restitution * impact - flight);
}

/// What a contact bore, in its frame with this normal, N.
Vector3 force_in_frame(const Contact& force, const BodyContact& contact, const Vector3& normal) {
  Vector3 t1, t2;
  tangent_frame(contact, normal, t1, t2);
  const Vector3& shear = force.shear_force;  // on A
  return Vector3(force.normal_force, -t1.dot(shear), -t2.dot(shear));
}

/// `contact`: as it ended, `position`: as it was solved. Nothing where nothing is to be set.
void add_contact(const ImpactStep& at, const BodyContact& contact, const LinearContact& position,
                 VelocityProblem& problem) {
  if (position.mode == ContactMode::Open || position.compliant) return;
  LinearContact& c = problem.contacts.emplace_back(position);
  const double dt = at.step.length;
  c.normal_spring = c.shear_spring = 0.0;
  c.cohesion = 2.0 * position.cohesion;
  linearise_velocity(contact, at.poses, c);
  const auto carry = [&](int slot, int block, const Matrix3x12& jacobian) {  // by a moving support
    const Vector12 velocity = velocity_vector(at.end[index(block)]);
    if (slot < 0 && !velocity.isZero(0.0)) c.offset += dt * (jacobian * velocity);
  };
  carry(c.slot_a, contact.a, c.jacobian_a);
  carry(c.slot_b, contact.b, c.jacobian_b);
  c.start = c.offset;
  problem.bounces.push_back(full_bounce(at, contact, position, c));
  c.multiplier = 2.0 * force_in_frame(contact.state, contact, contact.state.point.normal);
  const bool resting = !contact.state.impact;
  if (c.law == ContactLaw::Coulomb && position.mode == ContactMode::Slip && resting) {
    if (slides_on(at, contact, c)) c.law = ContactLaw::Frictionless;
  }
  if (c.law == ContactLaw::Frictionless) c.multiplier.tail<2>().setZero();
  c.assumed = position.mode;
  const double slope = dilation_slope(contact.joint, contact.state);
  if (position.mode == ContactMode::Slip && slope != 0.0) {  // a joint that dilates opens
    c.offset[0] -= dt * slope * relative_velocity(contact, c, at.end).tail<2>().norm();
  }
  set_augmentation(at.terms.compliance, c);
}

void add_held_point(const ImpactStep& at, const HeldPoint& held, const LinearContact& position,
                    VelocityProblem& problem) {
  const std::size_t b = index(held.block);
  LinearContact& c = problem.contacts.emplace_back(position);
  problem.bounces.push_back(0.0);
  c.jacobian_b = motion(at.poses.end[b], held.arm, at.poses.deforms[b] != 0);
  const double time = at.step.end_time(), eps = 0.5 * at.step.length;
  c.offset.setZero();
  if (!held.displacement.is_constant()) {
    c.offset = -(held.displacement.at(time + eps) - held.displacement.at(time - eps));
  }
  c.start = c.offset;
  c.multiplier = 2.0 * position.force;
  set_augmentation(at.terms.compliance, c);
}

/// Until the first impact contacts that were closed before pushed as in the last step,
/// unless that was an impulse.
void add_earlier_impulses(std::span<const BodyContact> contacts, const Attempt& attempt,
                          VelocityProblem& problem) {
  problem.pushed_before.clear();
  const double share = attempt.first_impact;
  if (!(share > 0.0)) return;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& before = contacts[i].state;
    const LinearContact& c = attempt.linear[i];
    if (!contacts[i].was_closed || before.impact || c.compliant) continue;
    const Vector3 push =
        2.0 * share * force_in_frame(before, contacts[i], attempt.contacts[i].state.point.normal);
    if (c.slot_a >= 0) problem.force[index(c.slot_a)] += c.jacobian_a.transpose() * push;
    if (c.slot_b >= 0) problem.force[index(c.slot_b)] += c.jacobian_b.transpose() * push;
    if (c.slot_a >= 0 && c.slot_b >= 0) problem.pushed_before.emplace_back(c.slot_a, c.slot_b);
  }
}

void set_contacts(const ImpactStep& at, const Attempt& attempt, VelocityProblem& problem) {
  problem.contacts.clear();
  problem.bounces.clear();
  for (std::size_t i = 0; i < attempt.contacts.size(); ++i) {
    add_contact(at, attempt.contacts[i], attempt.linear[i], problem);
  }
  for (std::size_t h = 0; h < at.step.island.held.size(); ++h) {
    const HeldPoint& held = at.step.compiled.held[index(at.step.island.held[h])];
    add_held_point(at, held, attempt.linear[attempt.contacts.size() + h], problem);
  }
}

void set_blocks(const ImpactStep& at, std::span<const BodyContact> contacts, const Attempt& attempt,
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
  add_earlier_impulses(contacts, attempt, problem);
  for (const LinearContact& c : problem.contacts) {
    if (c.slot_a >= 0) {
      problem.force[index(c.slot_a)] -= c.jacobian_a.transpose() * c.multiplier;
    }
    if (c.slot_b >= 0) {
      problem.force[index(c.slot_b)] -= c.jacobian_b.transpose() * c.multiplier;
    }
  }
}

/// Work of moving supports by the impulses beyond the positions' forces, by slot, J.
void set_pushed_work(std::size_t slots, const VelocityProblem& problem,
                     std::span<const LinearContact> solved, std::vector<double>& pushed) {
  pushed.assign(slots, 0.0);
  for (std::size_t i = 0; i < solved.size(); ++i) {
    const LinearContact& c = solved[i];
    pushed[index(c.slot_a >= 0 ? c.slot_a : c.slot_b)] -=
        0.5 * (c.force - problem.contacts[i].multiplier).dot(c.start);
  }
}

}  // namespace

void attempt_velocities(const SubStep& step, std::span<const BodyContact> contacts,
                        AttemptMemory& memory, BlocksAtEnd& blocks, Attempt& attempt) {
  const std::vector<int>& own = step.island.slots.block_of_slot;
  if (own.empty()) return;
  ImpactMemory& impact = memory.impact;
  VelocityProblem& problem = impact.problem;
  const auto closed = [](const LinearContact& c) { return c.closing_share > 0.0; };
  if (std::ranges::any_of(attempt.linear, closed)) {
    set_free_velocity_gain(step, memory.terms, blocks.poses, impact.free_gain);
  }
  const ImpactStep at{step,       memory.terms,     blocks.poses,
                      blocks.end, impact.free_gain, step.bounce_speed()};
  set_contacts(at, attempt, problem);
  if (problem.contacts.empty()) return;
  set_blocks(at, contacts, attempt, problem);
  OpenCloseOptions tuning{.force_tolerance = step.options.tolerance,
                          .gap_tolerance = step.gap_tolerance()};
  tuning.gap_rounding = gap_rounding(attempt.linear);
  tuning.raise = tuning.predicted = true;
  const double before = kinetic_energy(step, blocks.end);
  impact.restitution.begin(own.size(), problem);
  OpenCloseResult total = attempt.solved;
  // With friction and several contacts Newton's restitution can create energy: less of it then.
  for (bool again = true; again;) {
    impact.restitution.apply(problem, impact.tried);
    impact.solution = problem.velocity;
    memory.clock.charge(&PhaseSeconds::assemble);
    const OpenCloseResult solved = memory.solver.solve(
        step.options, {memory.terms.base, problem.force}, impact.tried, tuning, impact.solution);
    memory.clock.charge(&PhaseSeconds::solve);
    for (std::size_t s = 0; s < own.size(); ++s) {
      set_velocity(impact.solution[s] / step.length, blocks.end[index(own[s])]);
    }
    add(solved, total);
    again = impact.restitution.lessen(step, attempt.energy.work_on, blocks.end);
  }
  total.converged = total.converged && attempt.solved.converged;
  total.residual = std::max(total.residual, attempt.solved.residual);
  total.condition = attempt.solved.condition;
  attempt.solved = total;
  set_pushed_work(own.size(), problem, impact.tried, impact.pushed);
  bound_energy(step, {problem.velocity, impact.restitution.groups(), impact.pushed}, blocks.end,
               attempt.energy, impact.of_group);
  attempt.energy.impact_loss += before - kinetic_energy(step, blocks.end);
}

}  // namespace quoin::solver
