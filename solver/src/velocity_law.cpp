#include <algorithm>
#include <cmath>
#include <numeric>

#include "contact/joint_law.hpp"
#include "energy_bound.hpp"
#include "step.hpp"

namespace quoin::solver {
namespace {

constexpr double kEnergyRounding = 1e-9;  // of the energy before an impact
// Of what friction can stop within a step. Measured: from 1e-4 to 1e-2 walls at 0.98 of their limit
// load keep still and no row of validate changes; from 0 they gain energy.
constexpr double kCreep = 1e-3;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

void set_velocity(const Vector12& v, BlockState& block) {
  block.velocity = v.head<3>();
  block.angular_velocity = v.segment<3>(3);
  block.strain_rate = v.tail<6>();
}

/// Relative velocity of a contact from the velocities of both blocks, wherever they come from.
Vector3 relative_velocity(const BodyContact& contact, const LinearContact& c, const State& state) {
  return c.jacobian_a * velocity_vector(state.blocks[index(contact.a)]) +
         c.jacobian_b * velocity_vector(state.blocks[index(contact.b)]);
}

/// Gain of relative normal velocity over the step if no contact acted, m/s.
double relative_free_gain(const LinearContact& c, const BlockVector& free_gain) {
  double gain = 0.0;
  if (c.slot_a >= 0) gain += c.jacobian_a.row(0).dot(free_gain[index(c.slot_a)]);
  if (c.slot_b >= 0) gain += c.jacobian_b.row(0).dot(free_gain[index(c.slot_b)]);
  return gain;
}

/// What each block's velocity would gain in the step without contacts: 2 (D_free/dt - v).
void set_free_velocity_gain(const CompiledScene& compiled, const State& start, double time_step,
                            const Workspace& work, BlockVector& gain) {
  gain.resize(work.force.size());
  for (std::size_t s = 0; s < gain.size(); ++s) {
    const BlockState& block = start.blocks[index(compiled.slots.block_of_slot[s])];
    gain[s] = 2.0 * ((work.compliance[s] * work.force[s]) / time_step - velocity_vector(block));
    if (!work.poses.deforms[index(compiled.slots.block_of_slot[s])]) gain[s].tail<6>().setZero();
  }
}

/// Sliding that is more than creep against what friction can stop within a step: it goes on with
/// the friction that the positions gave it, along the mean direction of the step (second order). Of
/// a creeping contact the sign of the slip says nothing, and its friction follows the normal
/// impulse.
bool slides_on(const BodyContact& contact, const LinearContact& c, const State& end,
               double time_step, const std::vector<Matrix12>& compliance) {
  const Vector3 now = relative_velocity(contact, c, end);
  const double friction = c.multiplier.tail<2>().norm();
  const double stopped =
      friction * std::max(compliance_along(c, 1, compliance), compliance_along(c, 2, compliance));
  return now.tail<2>().dot(c.multiplier.tail<2>()) <= 0.0 &&
         now.tail<2>().norm() * time_step > kCreep * stopped;
}

/// A contact of the step turned into one of velocities: d is the relative velocity times dt, the
/// force 2/dt of the impulse. False when nothing is to be set there.
bool velocity_contact(const CompiledScene& compiled, const State& start, const State& end,
                      const BodyContact& contact, const BlockVector& free_gain, double slowest,
                      double time_step, const StepPoses& poses,
                      const std::vector<Matrix12>& compliance, const LinearContact& position,
                      LinearContact& c, double& bounce) {
  if (position.mode == ContactMode::Open || position.compliant) return false;
  c = position;
  c.normal_spring = c.shear_spring = 0.0;
  c.cohesion = 2.0 * position.cohesion;
  linearise_velocity(contact, poses, c);
  for (const auto& [block, jacobian] :
       {std::pair{contact.a, &c.jacobian_a}, std::pair{contact.b, &c.jacobian_b}}) {
    if (compiled.models[index(block)].unknowns > 0) continue;
    c.offset += time_step * (*jacobian * velocity_vector(end.blocks[index(block)]));
  }
  c.start = c.offset;
  // Between the impact and the end of the step the rebound goes on like free flight.
  const double approach = relative_velocity(contact, c, start)[0];
  const double gain = relative_free_gain(c, free_gain);
  const double impact = approach + position.closing_share * gain;
  if (impact < -slowest && contact.joint.restitution > 0.0) {
    const double flight =
        position.closing_share > 0.0 ? (1.0 - position.closing_share) * gain : 0.0;
    bounce = time_step * (contact.joint.restitution * impact - flight);
  }
  Vector3 t1, t2;
  tangent_frame(contact, contact.state.point.normal, t1, t2);
  const Vector3& shear = contact.state.shear_force;  // on A
  c.multiplier = 2.0 * Vector3(contact.state.normal_force, -t1.dot(shear), -t2.dot(shear));
  if (c.law == ContactLaw::Coulomb && position.mode == ContactMode::Slip && contact.was_closed) {
    if (slides_on(contact, c, end, time_step, compliance)) c.law = ContactLaw::Frictionless;
  }
  if (c.law == ContactLaw::Frictionless) c.multiplier.tail<2>().setZero();
  c.assumed = position.mode;
  if (position.mode == ContactMode::Slip) {  // a joint that dilates opens
    const double sliding = relative_velocity(contact, c, end).tail<2>().norm();
    c.offset[0] -= time_step * dilation_slope(contact.joint, contact.state) * sliding;
  }
  return true;
}

bool velocity_held_point(const HeldPoint& held, double time, double time_step,
                         const StepPoses& poses, const LinearContact& position, LinearContact& c) {
  const std::size_t b = index(held.block);
  c = position;
  c.jacobian_b = motion(poses.end[b], held.arm, poses.deforms[b] != 0);
  const double eps = 0.5 * time_step;
  const Vector3 target =
      held.displacement.is_constant()
          ? Vector3(Vector3::Zero())
          : Vector3((held.displacement.at(time + eps) - held.displacement.at(time - eps)));
  c.start = c.offset = -target;
  c.multiplier = 2.0 * position.force;
  return true;
}

/// Until the first new contact closed, contacts that were closed before pushed as in the last step,
/// unless that was an impulse.
void add_earlier_impulses(const Workspace& work, const Attempt& attempt, BlockVector& force) {
  double share = 1.0;
  bool impact = false;
  for (const LinearContact& c : work.linear) {
    if (c.mode == ContactMode::Open || !(c.closing_share > 0.0)) continue;
    impact = true;
    share = std::min(share, c.closing_share);
  }
  if (!impact) return;
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    const Contact& before = work.contacts[i].state;
    if (!work.contacts[i].was_closed || before.impact) continue;
    const LinearContact& c = work.linear[i];
    if (c.compliant) continue;
    Vector3 t1, t2;
    const Vector3& normal = attempt.contacts[i].state.point.normal;
    tangent_frame(work.contacts[i], normal, t1, t2);
    const Vector3 push =
        2.0 * share *
        Vector3(before.normal_force, -t1.dot(before.shear_force), -t2.dot(before.shear_force));
    if (c.slot_a >= 0) force[index(c.slot_a)] += c.jacobian_a.transpose() * push;
    if (c.slot_b >= 0) force[index(c.slot_b)] += c.jacobian_b.transpose() * push;
  }
}

/// Groups of blocks joined by contacts: by slot, the least slot of its group.
void find_islands(const std::vector<LinearContact>& contacts, std::vector<int>& islands) {
  std::iota(islands.begin(), islands.end(), 0);
  const auto root = [&](int slot) {
    while (islands[index(slot)] != slot) {
      islands[index(slot)] = islands[index(islands[index(slot)])];
      slot = islands[index(slot)];
    }
    return slot;
  };
  for (const LinearContact& c : contacts) {
    if (c.slot_a < 0 || c.slot_b < 0) continue;
    const auto [low, high] = std::minmax({root(c.slot_a), root(c.slot_b)});
    islands[index(high)] = low;
  }
  for (int& island : islands) island = root(island);
}

std::size_t island_of(const std::vector<int>& islands, const LinearContact& c) {
  return index(islands[index(c.slot_a >= 0 ? c.slot_a : c.slot_b)]);
}

/// `shares`: of each island's restitution, 0 where nothing bounces. Halves the restitution of the
/// islands that have more energy than they had, with the work done on them (a quarter of it is
/// followed by none); true when there are any. `shares`, `energy`: by island; `energy` is memory.
bool bounce_less(const CompiledScene& compiled, const State& start, const Attempt& attempt,
                 const std::vector<int>& islands, std::vector<double>& energy,
                 std::vector<double>& shares) {
  const auto mechanical = [&](std::size_t b, const State& state) {
    return kinetic_energy(compiled.models[b], state.blocks[b]) +
           strain_energy(compiled.models[b], state.blocks[b]);
  };
  if (std::ranges::none_of(shares, [](double share) { return share > 0.0; })) return false;
  energy.assign(2 * islands.size(), 0.0);  // available, and at the end
  for (std::size_t s = 0; s < islands.size(); ++s) {
    const std::size_t b = index(compiled.slots.block_of_slot[s]), island = index(islands[s]);
    energy[2 * island] += mechanical(b, start) + attempt.work_on[b];
    energy[2 * island + 1] += mechanical(b, attempt.end);
  }
  bool any = false;
  for (std::size_t island = 0; island < islands.size(); ++island) {
    const double available = energy[2 * island];
    if (energy[2 * island + 1] <= available + kEnergyRounding * std::abs(available)) continue;
    if (!(shares[island] > 0.0)) continue;
    shares[island] = shares[island] > 0.25 ? 0.5 * shares[island] : 0.0;
    any = true;
  }
  return any;
}

}  // namespace

void apply_velocity_law(const CompiledScene& compiled, const StepOptions& options,
                        const State& start, double time_step, Workspace& work) {
  if (compiled.slots.count() == 0) return;
  const double slowest = 2.0 * compiled.scene.gravity.at(start.time).norm() * time_step;
  Attempt& attempt = work.attempt;
  auto& [contacts, tried, bounces, shares, energy, pushed, islands, free_gain, velocity, force,
         solution] = work.velocity;
  set_free_velocity_gain(compiled, start, time_step, work, free_gain);
  islands.resize(work.force.size());
  contacts.clear();
  bounces.clear();
  for (std::size_t i = 0; i < work.linear.size(); ++i) {
    LinearContact c;
    double bounce = 0.0;
    const bool held = i >= work.contacts.size();
    const bool active =
        held ? velocity_held_point(compiled.held[i - work.contacts.size()], attempt.end.time,
                                   time_step, work.poses, work.linear[i], c)
             : velocity_contact(compiled, start, attempt.end, attempt.contacts[i], free_gain,
                                slowest, time_step, work.poses, work.compliance, work.linear[i], c,
                                bounce);
    if (!active) continue;
    set_augmentation(work.compliance, c);
    contacts.push_back(c);
    bounces.push_back(bounce);
  }
  if (contacts.empty()) return;
  velocity.resize(work.base.diagonal.size());
  force.resize(velocity.size());
  for (std::size_t s = 0; s < velocity.size(); ++s) {
    velocity[s] =
        time_step * velocity_vector(attempt.end.blocks[index(compiled.slots.block_of_slot[s])]);
    if (!work.poses.deforms[index(compiled.slots.block_of_slot[s])])
      velocity[s].tail<6>().setZero();
    force[s] = work.base.diagonal[s] * velocity[s];
  }
  add_earlier_impulses(work, attempt, force);
  for (const LinearContact& c : contacts) {
    if (c.slot_a >= 0) force[index(c.slot_a)] -= c.jacobian_a.transpose() * c.multiplier;
    if (c.slot_b >= 0) force[index(c.slot_b)] -= c.jacobian_b.transpose() * c.multiplier;
  }
  OpenCloseOptions tuning;
  tuning.force_tolerance = options.tolerance;
  tuning.gap_tolerance = options.tolerance * compiled.smallest_size;
  tuning.gap_rounding = gap_rounding(work.linear);
  tuning.raise = true;
  tuning.predicted = true;
  const double before = kinetic_energy(compiled, attempt.end);
  find_islands(contacts, islands);
  shares.assign(islands.size(), 0.0);
  for (std::size_t i = 0; i < bounces.size(); ++i) {
    if (bounces[i] != 0.0) shares[island_of(islands, contacts[i])] = 1.0;
  }
  // With friction and several contacts Newton's restitution can create energy: less of it then.
  for (bool again = true; again;) {
    tried = contacts;
    for (std::size_t i = 0; i < tried.size(); ++i) {
      tried[i].offset[0] += shares[island_of(islands, tried[i])] * bounces[i];
    }
    solution = velocity;
    tuning.max_iterations = work.iterations_left;
    work.clock.charge(&PhaseSeconds::assemble);
    const OpenCloseResult solved = solve_contacts(options, force, tried, tuning, solution, work);
    work.clock.charge(&PhaseSeconds::solve);
    for (std::size_t s = 0; s < solution.size(); ++s) {
      set_velocity(solution[s] / time_step,
                   attempt.end.blocks[index(compiled.slots.block_of_slot[s])]);
    }
    work.iterations_left -= solved.iterations;
    attempt.solved.iterations += solved.iterations;
    attempt.solved.solves += solved.solves;
    attempt.solved.factorizations += solved.factorizations;
    again = bounce_less(compiled, start, attempt, islands, energy, shares);
    if (again) continue;
    attempt.solved.converged = attempt.solved.converged && solved.converged;
    attempt.solved.residual = std::max(attempt.solved.residual, solved.residual);
  }
  pushed.assign(islands.size(), 0.0);
  for (std::size_t i = 0; i < tried.size(); ++i) {
    const LinearContact& c = tried[i];
    pushed[index(c.slot_a >= 0 ? c.slot_a : c.slot_b)] -=
        0.5 * (c.force - contacts[i].multiplier).dot(c.start);
  }
  bound_energy(compiled, start, {velocity, time_step, islands, pushed}, attempt);
  attempt.impact_loss += before - kinetic_energy(compiled, attempt.end);
}

}  // namespace quoin::solver
