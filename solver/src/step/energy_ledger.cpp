#include "step/energy_ledger.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/index.hpp"
#include "contact/joint_law.hpp"
#include "contact/joint_springs.hpp"
#include "step/linearise.hpp"
#include "step/predict.hpp"

namespace quoin::solver {
namespace {

/// Of strain rates, J: what vibrated has no place in an impact.
double vibration_energy(const BlockModel& model, const BlockState& state) {
  return kinetic_energy(model, state) - kinetic_energy(model, with_held_strain(model, state));
}

/// What the inertia of a static step takes on its way, J: D (2 M/tau^2) D, lost when it is at rest.
double held_back(const BlockModel& model, const Vector12& increment, double tau) {
  BlockState moving;
  moving.velocity = increment.head<3>() / tau;
  moving.angular_velocity = increment.segment<3>(3) / tau;
  moving.strain_rate = increment.tail<6>() / tau;
  return 4.0 * kinetic_energy(model, moving);
}

}  // namespace

double static_loss(const BlockModel& model, const BlockState& start, const Vector12& increment,
                   double length) {
  return held_back(model, increment, length) + kinetic_energy(model, start);
}

namespace {

void account_blocks(const SubStep& step, const StepPoses& poses, StepEnergy& energy) {
  const Vector3 gravity = step.compiled.scene.gravity.at(step.load_time());
  const double lag = step.scheme().end_share - 0.5;
  const std::vector<int>& blocks = step.island.slots.block_of_slot;
  for (std::size_t s = 0; s < blocks.size(); ++s) {
    const BlockModel& model = step.compiled.models[index(blocks[s])];
    const Vector12& d = poses.increment[index(blocks[s])];
    energy.work_on[s] = model.mass * gravity.dot(d.head<3>());
    energy.gravity_work += energy.work_on[s];
    if (!step.dynamic())
      energy.scheme_loss += static_loss(model, step.state[index(blocks[s])], d, step.length);
    if (model.unknowns != 12) continue;
    if (step.dynamic() && !poses.deforms[index(blocks[s])])
      energy.impact_loss += vibration_energy(model, step.state[index(blocks[s])]);
    const Vector6 e = d.tail<6>();
    energy.scheme_loss += lag * model.volume * e.dot(model.elasticity * e);
  }
}

void account_loads(const SubStep& step, const StepPoses& poses, StepEnergy& energy) {
  for (const int l : step.island.loads) {
    const PointForce& load = step.compiled.loads[index(l)];
    const std::size_t b = index(load.block);
    const Pose &start = poses.start[b], &end = poses.end[b];
    const Vector3 pull = force(step, poses, load);
    const Vector3 way = between(start, end) + (end.shape * load.arm - start.shape * load.arm);
    energy.load_work += pull.dot(way);
    energy.work_on[index(step.slot_of_block[b])] += pull.dot(way);
  }
}

/// Of a contact, J.
struct ContactShare {
  double load_work = 0.0;
  ContactWork work;
};

void add(const ContactShare& share, StepEnergy& energy) {
  energy.load_work += share.load_work;
  energy.friction_work += share.work.heat;
  energy.contact_work += share.work.impulse;
  energy.scheme_loss += share.work.scheme;
}

/// What the shear spring of a joint has stored that has broken, and has no friction, J.
double shear_energy(const BodyContact& contact, const StepPoses& poses) {
  const Pose &a = poses.start[index(contact.a)], &b = poses.start[index(contact.b)];
  const Vector3 normal = contact_geometry(contact, a, b).normal;
  return 0.5 * contact.joint->shear_stiffness * contact.state.spring_area *
         shear_stretch(a, b, normal, contact.state).squaredNorm();
}

/// What the pulled spring of a bond gives up that wears off as the step ends, J.
double worn_off(const BodyContact& contact, const LinearContact& c, const Vector3& moved) {
  Contact end = contact.state;
  if (!c.compliant || !c.bonded || !wears_off(*contact.joint, end, slip_in_step(c, moved)))
    return 0.0;
  weaken(*contact.joint, end);
  const double stretch = std::max(c.start[0] + moved[0] - c.dilation, 0.0);
  return end.bonded ? 0.0 : 0.5 * c.normal_spring * stretch * stretch;
}

/// What slots have of it is added to `energy`.
ContactShare account_contact(const SubStep& step, const BodyContact& contact,
                             const LinearContact& c, const StepPoses& poses, StepEnergy& energy) {
  ContactShare share;
  const Vector12 &move_a = poses.increment[index(contact.a)],
                 &move_b = poses.increment[index(contact.b)];
  const auto push = [&](int idle, int other, const ContactJacobian& jacobian,
                        const Vector12& motion) {
    if (idle >= 0 || motion.isZero(0.0)) return;
    const double done = c.force.dot(jacobian * motion);
    share.load_work -= done;
    if (other >= 0 && !c.compliant) energy.work_on[index(other)] -= done;
  };
  push(c.slot_a, c.slot_b, c.jacobian_a, move_a);
  push(c.slot_b, c.slot_a, c.jacobian_b, move_b);
  if (c.compliant) {  // what its spring gives or takes is work on each block
    if (c.slot_a >= 0) energy.work_on[index(c.slot_a)] += c.force.dot(c.jacobian_a * move_a);
    if (c.slot_b >= 0) energy.work_on[index(c.slot_b)] += c.force.dot(c.jacobian_b * move_b);
  }
  const Vector3 moved = moved_by(poses, contact, c);
  share.work = contact_work(c, moved);
  // At rest a joint has its stretch on all of its area: what moved the blocks there has pressed it.
  const bool pressed = contact.spring_loss < 0.0 && !step.dynamic();
  if (pressed) share.load_work -= contact.spring_loss;
  if (!pressed) share.work.scheme += contact.spring_loss;
  const double lost = worn_off(contact, c, moved);
  share.work.heat += lost;
  share.work.stored -= lost;
  if (c.compliant && c.law == ContactLaw::Frictionless && contact.was_closed)
    share.work.heat += shear_energy(contact, poses);
  energy.stored[index(c.first_slot())] += share.work.stored;
  return share;
}

/// A tie pushes its blocks as a spring does; an end that is moved does work.
void account_tie(const SubStep& step, int number, const TieState& end, const LinearContact& c,
                 const StepPoses& poses, StepEnergy& energy) {
  const Tie& tie = step.compiled.ties[index(number)].tie;
  const auto push = [&](int block, int slot, const ContactJacobian& jacobian) {
    if (block < 0) return;
    const double done = c.force.dot(jacobian * poses.increment[index(block)]);
    if (slot >= 0) energy.work_on[index(slot)] += done;
    if (slot < 0) energy.load_work -= done;
  };
  push(tie.a, c.slot_a, c.jacobian_a);
  push(tie.b, c.slot_b, c.jacobian_b);
  add({.work = tie_work(tie, step.ties[index(number)], end, c.force[0])}, energy);
  energy.stored[index(c.first_slot())] += stored_energy(tie, end);
}

/// Dashpots take the work of their force on d, the motion against the ground.
void account_quiet(const SubStep& step, int number, const LinearContact& c, const StepPoses& poses,
                   StepEnergy& energy) {
  const QuietPoint& quiet = step.compiled.quiet[index(number)];
  const double done = c.force.dot(c.jacobian_b * poses.increment[index(quiet.block)]);
  energy.work_on[index(c.slot_b)] += done;
  if (!c.compliant) {
    energy.contact_work += done;
    return;
  }
  const double heat = -(c.force - c.multiplier).dot(c.relative);
  energy.friction_work += heat;
  energy.load_work += done + heat;
}

/// How far a held point is moved by what prescribes its displacement, m: never what is left of its
/// gap, except that the first step brings it to where it is to be.
Vector3 prescribed_way(const SubStep& step, const HeldPoint& held, const StepPoses& poses) {
  const bool begins = !step.dynamic() || step.time == held.since;
  const Vector3 from = begins ? displacement(step.compiled, held, poses.start[index(held.block)])
                              : held.displacement.at(step.time);
  return held.displacement.at(step.end_time()) - from;
}

/// Loads do the work of a held point's force on its prescribed way. The rest of its way closes its
/// gap, as at contacts.
void account_held(const SubStep& step, const HeldPoint& held, const LinearContact& c,
                  const StepPoses& poses, StepEnergy& energy) {
  const double done = c.force.dot(prescribed_way(step, held, poses));
  energy.load_work += done;
  energy.contact_work += c.force.dot(c.jacobian_b * poses.increment[index(held.block)]) - done;
  if (c.slot_b >= 0) energy.work_on[index(c.slot_b)] += done;
}

/// Inertia of an increment from rest.
Vector12 inertia_force(const BlockModel& model, const Vector12& increment, double length) {
  const double factor = 2.0 / (length * length);
  Vector12 force = Vector12::Zero();
  force.head<3>() = factor * model.mass * increment.head<3>();
  force.segment<3>(3) = factor * (model.inertia * increment.segment<3>(3));
  force.tail<6>() = factor * (model.strain_inertia * increment.tail<6>());
  return force;
}

Vector6 strain_at_end(const SubStep& step, const StepPoses& poses, int block) {
  return step.state[index(block)].strain + poses.increment[index(block)].tail<6>();
}

}  // namespace

void account(const SubStep& step, const StepPoses& poses, std::span<const BodyContact> contacts,
             std::span<const LinearContact> linear, std::span<const TieState> ties,
             StepEnergy& energy) {
  energy.clear(step.island.slots.size.size());
  account_blocks(step, poses, energy);
  account_loads(step, poses, energy);
  for (std::size_t i = 0; i < contacts.size(); ++i)
    add(account_contact(step, contacts[i], linear[i], poses, energy), energy);
  for (std::size_t h = 0; h < step.island.held.size(); ++h) {
    account_held(step, step.compiled.held[index(step.island.held[h])], linear[contacts.size() + h],
                 poses, energy);
  }
  std::size_t next = contacts.size() + step.island.held.size();
  for (std::size_t t = 0; t < ties.size(); ++t)
    account_tie(step, step.island.ties[t], ties[t], linear[next++], poses, energy);
  for (const int q : step.island.quiet) account_quiet(step, q, linear[next++], poses, energy);
}

namespace {

// Of the largest force, the least that the unbalance of a block with weight is measured by. A
// thrust of thousands of weights is turned by some of them: by the thrust alone they would be none.
constexpr double kLight = 0.01;

/// Inertia of the step, and of what the block comes with and would be stopped by in it.
double moving_force(const SubStep& step, const StepPoses& poses, int block) {
  const BlockModel& model = step.compiled.models[index(block)];
  const Vector12 inertial = inertia_force(model, poses.increment[index(block)], step.length);
  const double force = force_size(inertial, model.size);
  if (!step.dynamic()) return force;
  const Vector12 coasting = step.length * velocity_vector(start_state(step, poses, index(block)));
  return std::max(force, force_size(0.5 * inertia_force(model, coasting, step.length), model.size));
}

/// Weight, load or contact force of the island, N. `gravity`: m/s2.
double largest_force(const SubStep& step, const StepPoses& poses,
                     std::span<const LinearContact> linear, double gravity) {
  double largest = 0.0, sources = 0.0;
  for (const int block : step.island.slots.block_of_slot) {
    const BlockModel& model = step.compiled.models[index(block)];
    Vector12 prestress = Vector12::Zero(), elastic = Vector12::Zero();
    prestress.tail<6>() = model.volume * model.initial_stress;
    elastic.tail<6>() = model.volume * (model.elasticity * strain_at_end(step, poses, block));
    const double weight = model.mass * gravity, stress = force_size(prestress, model.size);
    largest = std::max({largest, weight, stress});
    sources += weight + stress + force_size(elastic, model.size);
  }
  for (const int l : step.island.loads) {
    const PointForce& load = step.compiled.loads[index(l)];
    const double size = load.at(poses.start[index(load.block)], step.load_time()).norm();
    largest = std::max(largest, size);
    sources += size;
  }
  for (const LinearContact& c : linear)
    if (c.compliant || c.law == ContactLaw::Bilateral) sources += c.force.norm();
  // Rigid contacts that are redundant can brace each other with any forces.
  if (!(sources > 0.0)) sources = std::numeric_limits<double>::infinity();
  for (const LinearContact& c : linear)
    largest = std::max(largest, std::min(c.force.norm(), sources));
  return largest;
}

}  // namespace

double unbalance(const SubStep& step, const StepPoses& poses,
                 std::span<const LinearContact> linear) {
  const double gravity = step.compiled.scene.gravity.at(step.load_time()).norm();
  const double least = (gravity > 0.0 ? kLight : 1.0) * largest_force(step, poses, linear, gravity);
  double worst = 0.0;
  for (const int block : step.island.slots.block_of_slot) {
    const double force = moving_force(step, poses, block);
    const double scale = std::max(least, step.compiled.models[index(block)].mass * gravity);
    if (force > 0.0) worst = std::max(worst, scale > 0.0 ? force / scale : 1.0);
  }
  return worst;
}

/// Compliance of its blocks = (dt^2/2) / effective mass.
double stiffest_omega_dt(std::span<const LinearContact> linear, const SquareBlocks& compliance) {
  double largest = 0.0;
  for (const LinearContact& c : linear) {
    if (!c.compliant || c.mode == ContactMode::Open) continue;
    largest =
        std::max(largest, std::sqrt(2.0 * c.normal_spring * normal_compliance(c, compliance)));
  }
  return largest;
}

double kinetic_energy(const SubStep& step, std::span<const BlockState> state) {
  double sum = 0.0;
  for (const int block : step.island.slots.block_of_slot)
    sum += kinetic_energy(step.compiled.models[index(block)], state[index(block)]);
  return sum;
}

double strain_energy(const SubStep& step, std::span<const BlockState> state) {
  double sum = 0.0;
  for (const int block : step.island.slots.block_of_slot)
    sum += strain_energy(step.compiled.models[index(block)], state[index(block)]);
  return sum;
}

double energy_growth(const SubStep& step, const StepEnergy& done, std::span<const BlockState> end,
                     double stored_before) {
  const double stored = std::accumulate(done.stored.begin(), done.stored.end(), 0.0);
  const double before =
      kinetic_energy(step, step.state) + strain_energy(step, step.state) + stored_before;
  const double after =
      kinetic_energy(step, end) + strain_energy(step, end) + stored - done.gravity_work;
  return after - before - done.load_work;
}

void book(const StepEnergy& done, double growth, EnergyLedger& energy) {
  const double impact_loss = done.impact_loss - done.contact_work;
  energy.potential -= done.gravity_work;
  energy.work += done.load_work;
  energy.friction_loss += done.friction_work;
  energy.impact_loss += impact_loss;
  energy.algorithmic_loss += done.scheme_loss;
  energy.closure -= growth + done.friction_work + impact_loss + done.scheme_loss;
}

}  // namespace quoin::solver
