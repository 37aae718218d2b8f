#include "step/impact_law.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/index.hpp"
#include "base/rounding.hpp"
#include "contact/contact_history.hpp"
#include "contact/joint_law.hpp"
#include "step/energy_bound.hpp"
#include "step/linearise.hpp"
#include "step/predict.hpp"
#include "step/step_attempt.hpp"

namespace quoin::solver {
namespace {

// Search for the share of restitution that makes no energy: what is tried next is at least
// kLessBounce of what has made some. It ends where what is left is kNearBounce of the kinetic
// energy, or the share that near to one that makes some, and after kBounces tries.
constexpr double kLessBounce = 0.5, kNearBounce = 1e-3;
constexpr int kBounces = 8;
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

bool BounceShare::change(bool too_much, double excess, double kinetic) {
  if (tries == kBounces) return false;
  if (!too_much) {
    const bool near = -excess <= kNearBounce * kinetic || share >= (1.0 - kNearBounce) * beyond;
    if (tries == 0 || near) return false;
    enough = share;
    left = -excess;
  } else {
    beyond = share;
    lacks = excess;
  }
  // Energy goes with the square of the share, less of it the more blocks move beside the bounce.
  const double low = enough * enough, high = beyond * beyond;
  double square = high * (1.0 - std::min(std::ldexp(lacks / kinetic, tries), 1.0));
  if (enough > 0.0) square = high - (high - low) * lacks / (lacks + left);
  share = ++tries < kBounces ? std::max(std::sqrt(square), kLessBounce * beyond) : enough;
  return true;
}

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
  shares_.resize(slots);
  for (std::size_t s = 0; s < slots; ++s) shares_[s] = {.share = bouncing_[s] ? 1.0 : 0.0};
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
    c.offset[0] = start.gap + shares_[group_of(c)].share * start.bounce;
  }
}

bool Restitution::lessen(const SubStep& step, const WorkOnBlocks& work,
                         const VelocityTolerance& tolerance, std::span<const BlockState> end) {
  const auto bounces = [](const BounceShare& of) { return of.share > 0.0; };
  if (std::ranges::none_of(shares_, bounces)) return false;
  pushed_.assign(shares_.size(), 0.0);
  available_.assign(shares_.size(), 0.0);
  now_.assign(shares_.size(), 0.0);
  strained_.assign(shares_.size(), 0.0);
  noise_.assign(shares_.size(), 0.0);
  for (std::size_t s = 0; s < groups_.size(); ++s) {
    const std::size_t b = index(step.island.slots.block_of_slot[s]), group = index(groups_[s]);
    const double before = mechanical_energy(step, b, step.state);
    available_[group] += before + work.forces[s] + work.impulses[s];
    noise_[group] +=
        tolerance.relative * (before + std::abs(work.forces[s]) + std::abs(work.impulses[s])) +
        tolerance.absolute * step.compiled.models[b].mass * end[b].velocity.norm();
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
    if (!bounces(shares_[group])) continue;
    const double kinetic = now_[group] - strained_[group], relative = kinetic - least[group];
    const double excess = now_[group] - available_[group];
    const double gained = now_[group] - free_[group] - pushed_[group];  // by impulses
    const bool taken_off = excess <= relative && gained <= kSlight * relative + noise_[group];
    any = shares_[group].change(excess > noise_[group] && !taken_off, excess, kinetic) || any;
  }
  return any;
}

std::size_t Restitution::group_of(const LinearContact& c) const {
  return index(groups_[index(c.first_slot())]);
}

namespace {

// Of what friction can stop within a step. Measured: from 1e-4 to 1e-2 walls at 0.98 of their limit
// load keep still and no row of validate changes; from 0 they gain energy.
constexpr double kCreep = 1e-3;

// Growth that velocities may make, of the energy that goes in: half of what a run flags. Less is
// left as it is: a velocity that is held back no longer rests on its contacts, and at 1e-7 a
// falling arch took four times the solves. Where contacts yield velocities rest on them no better.
constexpr double kAllowed = 5e-7, kAllowedYielding = 1e-8;

// Of the normal impulse: where a joint that dilates starts to slide with more than that beyond what
// its slope asks of the velocities, friction follows what is left of it.
constexpr double kSurplus = 1e-3;

// Solutions between which opening and slip of joints that dilate agree, to the gap tolerance. They
// do by tan(friction angle) tan(dilation angle) each.
constexpr int kOpenings = 30;

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
  const auto along = [&](const ContactJacobian& jacobian, int block) {
    const BlockState& state = blocks[index(block)];
    const auto row = jacobian.rigid.row(0);
    const double rigid =
        row.head<3>().dot(state.velocity) + row.tail<3>().dot(state.angular_velocity);
    return jacobian.strain ? rigid + jacobian.strain->row(0).dot(state.strain_rate) : rigid;
  };
  return along(c.jacobian_a, contact.a) + along(c.jacobian_b, contact.b);
}

/// Gain of relative normal velocity over the step by what acts but new contacts, m/s; of a moving
/// support by its motion.
double relative_free_gain(const ImpactStep& at, const BodyContact& contact,
                          const LinearContact& c) {
  double gain = 0.0;
  const auto add = [&](int slot, int block, const ContactJacobian& jacobian) {
    if (slot >= 0) {
      gain += jacobian.normal(at.free_gain[index(slot)]);
      return;
    }
    const Vector12& moved = at.poses.increment[index(block)];
    const Vector12 before = velocity_vector(at.step.state[index(block)]);
    gain += jacobian.normal(2.0 * (moved / at.step.length - before));
  };
  add(c.slot_a, contact.a, c.jacobian_a);
  add(c.slot_b, contact.b, c.jacobian_b);
  return gain;
}

/// 2 (D_free/dt - v) of each block: what a rebound is found with.
void set_free_velocity_gain(const SubStep& step, const BlockTerms& terms, const StepPoses& poses,
                            BlockVector& gain) {
  gain.resize(terms.force.size());
  for (std::size_t s = 0; s < gain.size(); ++s) {
    const std::size_t b = index(step.island.slots.block_of_slot[s]);
    gain[s] = 2.0 * (terms.free_increment[s] / step.length -
                     velocity_vector(start_state(step, poses, b)));
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
  const SquareBlocks& compliance = at.terms.compliance;
  const double stopped = friction * shear_compliance(c, compliance);
  return now.tail<2>().dot(c.multiplier.tail<2>()) <= 0.0 &&
         now.tail<2>().norm() * at.step.length > (contact.was_closed ? kCreep : 1.0) * stopped;
}

/// Between the impact and the end of the step the rebound goes on like free flight. What was closed
/// at the start does not come on: the last velocities saw to that.
double full_bounce(const ImpactStep& at, const BodyContact& contact, const LinearContact& c) {
  if (!(contact.joint->restitution > 0.0) || contact.was_closed) return 0.0;
  const double approach = normal_velocity(contact, c, at.step.state);
  const bool closed = c.closing_share > 0.0;
  const double gain = closed ? relative_free_gain(at, contact, c) : 0.0;
  const double impact = approach + c.closing_share * gain;
  if (!(impact < -at.slowest)) return 0.0;
  const double flight = (1.0 - c.closing_share) * gain;
  return at.step.length * (contact.joint->restitution * impact - flight);
}

/// The positions' forces hold over the whole step. A block whose velocity does not yet follow the
/// slope comes onto it within the step, and leaves it with twice the impulse, normal and friction.
bool has_surplus(const ImpactStep& at, const BodyContact& contact, const LinearContact& c,
                 double slope) {
  const Vector3 now = relative_velocity(contact, c, at.end);
  const double surplus = at.step.length * (now[0] - slope * now.tail<2>().norm());
  return surplus > kSurplus * c.multiplier[0] * normal_compliance(c, at.terms.compliance);
}

VelocityProblem::Start start_of(const LinearContact& c, double bounce) {
  return {c.multiplier, c.offset[0], c.normal_stiffness, c.shear_stiffness, bounce, c.assumed};
}

/// What moving supports carry a contact by in a step's time at the end's velocities, m.
Vector3 carried(const ImpactStep& at, const BodyContact& contact, const LinearContact& c) {
  Vector3 way = Vector3::Zero();
  const auto add = [&](int slot, int block, const ContactJacobian& jacobian) {
    const Vector12 velocity = velocity_vector(at.end[index(block)]);
    if (slot < 0 && !velocity.isZero(0.0)) way += at.step.length * (jacobian * velocity);
  };
  add(c.slot_a, contact.a, c.jacobian_a);
  add(c.slot_b, contact.b, c.jacobian_b);
  return way;
}

/// `ended`: as the positions leave it. `c`: as these solved it; it becomes that of the velocities.
void set_contact(const ImpactStep& at, const BodyContact& contact, const Contact& ended,
                 LinearContact& c, VelocityProblem& problem) {
  const double dt = at.step.length;
  c.normal_spring = c.shear_spring = c.dilation_slope = 0.0;
  c.cohesion *= 2.0;
  linearise_velocity(contact, at.poses, c);
  c.start = c.offset = carried(at, contact, c);
  const double bounce = full_bounce(at, contact, c);
  c.multiplier = 2.0 * force_in_frame(ended, contact, ended.point.normal);
  const bool resting = !ended.impact;
  const double slope = c.mode == ContactMode::Slip ? dilation_slope(*contact.joint, ended) : 0.0;
  const bool sought = slope != 0.0 && (!resting || has_surplus(at, contact, c, slope));
  if (c.law == ContactLaw::Coulomb && c.mode == ContactMode::Slip && resting && !sought) {
    if (slides_on(at, contact, c)) c.law = ContactLaw::Frictionless;
  }
  if (c.law == ContactLaw::Frictionless) {
    c.clings = false;
    c.multiplier.tail<2>().setZero();
  }
  c.assumed = c.mode;
  if (slope != 0.0) {  // a joint that dilates opens
    const double opened = dt * slope * relative_velocity(contact, c, at.end).tail<2>().norm();
    c.offset[0] -= opened;
    if (sought) problem.openings.push_back({problem.starts.size(), slope, opened});
  }
  set_augmentation(at.terms.compliance, c);
  problem.starts.push_back(start_of(c, bounce));
}

void set_held_point(const ImpactStep& at, const HeldPoint& held, LinearContact& c,
                    VelocityProblem& problem) {
  const std::size_t b = index(held.block);
  const bool deforms = at.poses.deforms[b] != 0;
  c.jacobian_b.set(motion(at.poses.end[b], held.arm, deforms), deforms);
  const double time = at.step.end_time(), eps = 0.5 * at.step.length;
  c.offset.setZero();
  if (!held.displacement.is_constant())
    c.offset = -(held.displacement.at(time + eps) - held.displacement.at(time - eps));
  c.start = c.offset;
  c.multiplier = 2.0 * c.force;
  set_augmentation(at.terms.compliance, c);
  problem.starts.push_back(start_of(c, 0.0));
}

/// Until the first impact contacts that were closed before, but for springs, push as in the last
/// step, unless that was an impulse.
bool pushed_before(const BodyContact& contact) {
  return contact.was_closed && !contact.state.impact;
}

/// What they have pushed the blocks with until the first impact.
void add_earlier_impulses(const ImpactStep& at, std::span<const BodyContact> contacts,
                          const Attempt& attempt, VelocityProblem& problem) {
  problem.pushed_before.clear();
  problem.work_before.assign(problem.force.size(), 0.0);
  const double share = attempt.first_impact;
  if (!(share > 0.0)) return;
  LinearContact end;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& before = contacts[i].state;
    const LinearContact& c = attempt.linear[i];
    if (c.compliant || !pushed_before(contacts[i])) continue;
    const Vector3 push =
        2.0 * share * force_in_frame(before, contacts[i], attempt.contacts[i].point.normal);
    linearise_velocity(contacts[i], at.poses, end);  // a mean arm would keep no angular momentum
    if (c.slot_a >= 0) problem.force[index(c.slot_a)] += end.jacobian_a.push(push);
    if (c.slot_b >= 0) problem.force[index(c.slot_b)] += end.jacobian_b.push(push);
    if (c.slot_a >= 0 && c.slot_b >= 0) problem.pushed_before.emplace_back(c.slot_a, c.slot_b);
    end.slot_a = c.slot_a;
    end.slot_b = c.slot_b;
    problem.work_before[index(c.first_slot())] -= 0.5 * push.dot(carried(at, contacts[i], end));
  }
}

/// Closed ones have a velocity to be set, and so have those that are struck; springs do what they
/// do.
bool takes_part(const SolvedContact& contact) {
  return !contact.compliant && (contact.mode != ContactMode::Open || contact.struck);
}

/// The contacts of the positions become those of the velocities, where they are kept.
void set_contacts(const ImpactStep& at, std::span<const BodyContact> contacts, Attempt& attempt,
                  VelocityProblem& problem) {
  std::vector<LinearContact>& linear = attempt.linear;
  std::size_t count = 0;
  problem.starts.clear();
  problem.openings.clear();
  problem.starts.reserve(linear.size());
  const auto take = [&](std::size_t i) -> LinearContact& {
    if (i != count) std::swap(linear[count], linear[i]);
    return linear[count++];
  };
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (!takes_part(attempt.positions[i])) continue;
    set_contact(at, contacts[i], attempt.contacts[i], take(i), problem);
  }
  for (std::size_t h = 0; h < at.step.island.held.size(); ++h) {
    const HeldPoint& held = at.step.compiled.held[index(at.step.island.held[h])];
    set_held_point(at, held, take(contacts.size() + h), problem);
  }
  problem.contacts = std::span(linear).first(count);
}

/// Which contacts the velocities fight for.
void note_changes(std::span<const LinearContact> solved, Attempt& attempt) {
  std::size_t at = 0;
  for (std::size_t i = 0; i < attempt.contacts.size(); ++i) {
    SolvedContact& contact = attempt.positions[i];
    if (takes_part(contact)) contact.change = change_of_update(solved[at++]);
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
    const SquareBlocks& inertia = at.terms.base.diagonal;
    problem.force[s].setZero();
    problem.force[s].head(inertia.width()) = inertia[s] * velocity.head(inertia.width());
  }
  add_earlier_impulses(at, contacts, attempt, problem);
}

/// Contacts that open along their slope open by the slip of the last solution. Largest change, m.
double follow_openings(VelocityProblem& problem) {
  double change = 0.0;
  for (VelocityProblem::Opening& opening : problem.openings) {
    const Vector3& relative = problem.contacts[opening.contact].relative;
    const double opened = opening.slope * relative.tail<2>().norm();
    change = std::max(change, std::abs(opened - opening.opened));
    problem.starts[opening.contact].gap -= opened - opening.opened;
    opening.opened = opened;
  }
  return change;
}

/// What the positions' forces have done is part of the velocities.
void take_off_forces(VelocityProblem& problem) {
  for (const LinearContact& c : problem.contacts) c.push(-c.multiplier, problem.force);
}

/// Work of moving supports by the impulses beyond the positions' forces, by slot, J.
void set_pushed_work(const VelocityProblem& problem, std::vector<double>& pushed) {
  pushed = problem.work_before;
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    const LinearContact& c = problem.contacts[i];
    pushed[index(c.first_slot())] -= 0.5 * (c.force - problem.starts[i].multiplier).dot(c.start);
  }
}

/// Within the law: what pushed before an impact may have mended gaps, and friction that velocities
/// leave to the positions is of another normal force. `cohesion`: N.
void limit_force(double friction, double cohesion, bool bonded, Contact& contact) {
  if (!bonded) contact.normal_force = std::max(0.0, contact.normal_force);
  const double limit = std::max(0.0, friction * contact.normal_force + cohesion);
  const double size = contact.shear_force.norm();
  if (size > limit) contact.shear_force *= limit / size;
}

/// Force in the world, on B.
Vector3 in_world(const BodyContact& contact, const Vector3& normal, const Vector3& force) {
  Vector3 t1, t2;
  tangent_frame(contact, normal, t1, t2);
  return force[0] * normal + force[1] * t1 + force[2] * t2;
}

/// What the velocities have changed of the positions' forces: these also mend gaps, or stand for an
/// impact. Until the first impact contacts pushed as before. So contacts balance what the blocks
/// have gained, by groups that went a share of the way to the law (bound_energy) likewise; but for
/// what is beyond the law.
void record_impulses(const ImpactStep& at, std::span<const BodyContact> contacts,
                     const ImpactMemory& impact, Attempt& attempt) {
  const VelocityProblem& problem = impact.problem;
  const auto share = [&](int slot) {
    return impact.of_group[index(impact.restitution.groups()[index(slot)])].share;
  };
  const auto changed = [&](std::size_t i) -> Vector3 {
    return 0.5 * (problem.contacts[i].force - problem.starts[i].multiplier);
  };
  std::size_t next = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const BodyContact& contact = contacts[i];
    Contact& ended = attempt.contacts[i];
    if (attempt.positions[i].compliant) continue;
    Vector3 force = Vector3::Zero();
    const LinearContact* c = nullptr;
    if (takes_part(attempt.positions[i])) {
      c = &problem.contacts[next];
      force = changed(next++);
    }
    if (pushed_before(contact))
      force += attempt.first_impact * force_in_frame(contact.state, contact, ended.point.normal);
    if (c == nullptr && force.isZero(0.0)) continue;
    const int slot_a = at.step.slot_of_block[index(contact.a)];
    const int slot = slot_a >= 0 ? slot_a : at.step.slot_of_block[index(contact.b)];
    set_force_on_b(force_on_b(ended) + share(slot) * in_world(contact, ended.point.normal, force),
                   ended);
    if (c != nullptr) {
      const bool stuck = c->law == ContactLaw::Stuck;  // its joint is judged as a whole
      const double cohesion = stuck ? std::numeric_limits<double>::infinity() : 0.5 * c->cohesion;
      limit_force(c->friction, cohesion, contact.was_bonded, ended);
    } else {
      const JointStrength bears = strength(*contact.joint, contact.state);
      limit_force(bears.friction, bears.cohesion * ended.point.area, contact.was_bonded, ended);
    }
  }
  for (Vector3& force : attempt.held_forces) {
    const int slot = problem.contacts[next].slot_b;
    force += share(slot) * changed(next++);
  }
}

}  // namespace

void attempt_velocities(const SubStep& step, std::span<const BodyContact> contacts,
                        AttemptMemory& memory, BlocksAtEnd& blocks, Attempt& attempt) {
  const std::vector<int>& own = step.island.slots.block_of_slot;
  const bool none = std::ranges::none_of(attempt.positions, takes_part);
  ImpactMemory& impact = memory.impact;
  impact.restitution.forget();
  if (own.empty() || (none && step.island.held.empty())) return;
  VelocityProblem& problem = impact.problem;
  const auto closed = [](const LinearContact& c) { return c.closing_share > 0.0; };
  if (std::ranges::any_of(attempt.linear, closed))
    set_free_velocity_gain(step, memory.terms, blocks.poses, impact.free_gain);
  const ImpactStep at{step,       memory.terms,     blocks.poses,
                      blocks.end, impact.free_gain, step.bounce_speed()};
  set_blocks(at, contacts, attempt, problem);
  set_contacts(at, contacts, attempt, problem);
  take_off_forces(problem);
  OpenCloseOptions tuning{.force_tolerance = step.options.tolerance,
                          .gap_tolerance = step.gap_tolerance()};
  tuning.gap_rounding = attempt.rounding;
  tuning.raise = tuning.predicted = true;
  tuning.moves = is_moving(step.island.slots, problem.velocity);
  if (tuning.moves) {
    tuning.gap_tolerance *= kVelocityGap;
    tuning.softness = attempt.solved.softness;
  }
  const double before = kinetic_energy(step, blocks.end);
  impact.restitution.begin(step, problem, memory.terms.compliance, blocks.end);
  OpenCloseResult total = attempt.solved;
  int left = kOpenings;
  // With friction and several contacts Newton's restitution can create energy: less of it then.
  for (bool again = true; again;) {
    impact.restitution.apply(problem);
    impact.solution = problem.velocity;
    memory.clock.charge(&PhaseSeconds::assemble);
    const OpenCloseResult solved =
        memory.solver.solve(step.options, {memory.terms.base, problem.force}, problem.contacts,
                            tuning, impact.solution);
    memory.clock.charge(&PhaseSeconds::solve);
    for (std::size_t s = 0; s < own.size(); ++s)
      set_velocity(impact.solution[s] / step.length, blocks.end[index(own[s])]);
    add(solved, total);
    if (!solved.converged) note_changes(problem.contacts, attempt);
    set_pushed_work(problem, impact.pushed);
    again = follow_openings(problem) > tuning.gap_tolerance && left-- > 0;
    if (again) continue;
    const bool yields = memory.solver.yielding();
    const VelocityTolerance tolerance{
        tuning.gap_tolerance / step.length,
        yields ? crowd_tolerance(step.options.tolerance) : kRelativeRounding};
    again = impact.restitution.lessen(step, {attempt.energy.work_on, impact.pushed}, tolerance,
                                      blocks.end);
  }
  total.converged = total.converged && attempt.solved.converged;
  total.residual = worse_residual(total.residual, attempt.solved.residual);
  total.condition = attempt.solved.condition;
  attempt.solved = total;
  attempt.squeezed = attempt.squeezed || (!total.converged && attempt.shift > 0.0) ||
                     is_squeezed(attempt.shift, problem.contacts);
  const double allowed = memory.solver.yielding() ? kAllowedYielding : kAllowed;
  bound_energy(
      step,
      {problem.velocity, impact.restitution.groups(), impact.pushed, allowed,
       impact.restitution.bouncing(), impact.restitution.grounded(), impact.restitution.driven()},
      blocks.end, attempt.energy, impact.of_group);
  record_impulses(at, contacts, impact, attempt);
  attempt.energy.impact_loss += before - kinetic_energy(step, blocks.end);
}

}  // namespace quoin::solver
