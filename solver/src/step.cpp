#include "step.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/joint_failure.hpp"
#include "contact/joint_law.hpp"
#include "contact_problem.hpp"

namespace quoin::solver {
namespace {

constexpr int kLinearisations = 30;
constexpr int kStrictLinearisations = 10;  // to the last bit; then to the tolerance
// Changes go down quadratically: what the next linearisation would still mend is the square of it.
constexpr double kAgreement = 1e-6;  // of the smallest block, where contacts yield
// Open-close iterations before the interior point takes over. On small scenes like those of
// bench/moving.md 15 took an arch and a tower eight times the factorizations, as it came in where
// it was not needed; with 80 a rocking wall took 1.4 times as many.
constexpr int kPatience = 40;
constexpr double kUndamped = 0.5;
constexpr double kOpened = 10.0;  // of the gap tolerance: closed contacts are good to one

StepScheme scheme_of(const StepOptions& options, double time_step, bool deforms = true) {
  const bool undamped =
      options.scheme == TimeScheme::EnergyMomentum && options.analysis == Analysis::Dynamic;
  return {time_step, undamped ? kUndamped : 1.0, deforms};
}

std::size_t index(int i) { return static_cast<std::size_t>(i); }

void set_start(const CompiledScene& compiled, const StepOptions& options, const State& state,
               double time_step, const std::vector<PrescribedMotion>& motion_end, Workspace& work) {
  const std::size_t n = state.blocks.size();
  work.poses.deforms.resize(n);
  for (std::size_t b = 0; b < n; ++b) work.poses.deforms[b] = compiled.models[b].unknowns == 12;
  work.poses.start.resize(n);
  work.poses.end.resize(n);
  work.poses.increment.assign(n, Vector12::Zero());
  for (std::size_t b = 0; b < n; ++b) {
    work.poses.start[b] = pose(state.blocks[b]);
    if (compiled.models[b].unknowns == 0 || options.analysis != Analysis::Dynamic) continue;
    const BlockState& now = state.blocks[b];
    work.poses.increment[b] = time_step * velocity_vector(now);
    const bool steady = std::abs(work.last_time_step - time_step) < 1e-9 * time_step;
    if (steady && !work.hit[b]) {  // acceleration as in the last step
      const std::size_t slot = index(compiled.slots.slot_of_block[b]);
      work.poses.increment[b] +=
          0.5 * time_step * (velocity_vector(now) - work.last_velocity[slot]);
    }
    if (compiled.models[b].unknowns == 6) work.poses.increment[b].tail<6>().setZero();
  }
  for (std::size_t p = 0; p < compiled.prescribed.size(); ++p) {
    work.poses.increment[index(compiled.prescribed[p])].head<3>() =
        motion_end[p].displacement - work.motion[p].displacement;
  }
}

void set_end(const CompiledScene& compiled, const State& state, Workspace& work) {
  for (std::size_t b = 0; b < state.blocks.size(); ++b) {
    if (compiled.idle[b] && work.poses.increment[b].isZero(0.0)) {
      work.poses.end[b] = work.poses.start[b];
    } else {
      work.poses.end[b] = pose(displaced(state.blocks[b], work.poses.increment[b]));
    }
  }
}

void set_matrix(const CompiledScene& compiled, const StepOptions& options, double time_step,
                std::size_t slot, Workspace& work) {
  const std::size_t b = index(compiled.slots.block_of_slot[slot]);
  const bool deforms = work.poses.deforms[b] != 0;
  work.base.frames[slot] = {work.poses.start[b].centroid, work.poses.start[b].rotation};
  Matrix12& matrix = work.base.diagonal[slot];
  Matrix12& inverse = work.compliance[slot];
  matrix = block_matrix(compiled.models[b], scheme_of(options, time_step, deforms));
  if (deforms) {
    inverse = matrix.ldlt().solve(Matrix12::Identity());
    return;
  }
  inverse.setZero();
  inverse.diagonal().head<3>() = matrix.diagonal().head<3>().cwiseInverse();
  inverse.block<3, 3>(3, 3) = matrix.block<3, 3>(3, 3).inverse();
}

void set_matrices(const CompiledScene& compiled, const StepOptions& options, double time_step,
                  Workspace& work) {
  work.base.diagonal.resize(index(compiled.slots.count()));
  work.base.frames.resize(work.base.diagonal.size());
  work.compliance.resize(index(compiled.slots.count()));
  for (std::size_t s = 0; s < work.base.diagonal.size(); ++s) {
    set_matrix(compiled, options, time_step, s, work);
  }
}

ContactLaw law_of(const JointStrength& strength, const StepOptions& options) {
  if (options.analysis == Analysis::Settle) return ContactLaw::Stuck;
  const bool rough = strength.friction > 0.0 || strength.cohesion > 0.0;
  return rough ? ContactLaw::Coulomb : ContactLaw::Frictionless;
}

/// Penalty of one contact: a joint of more than four corners has that of four, shared out by area.
double penalty_of(double penalty, const BodyContact& contact) {
  if (contact.joint_points <= 4) return penalty;
  const bool has_area = contact.state.point.area > 0.0;
  return 4.0 * penalty *
         (has_area ? contact.state.point.area / contact.joint_area : 1.0 / contact.joint_points);
}

/// The joint's stiffness on the contact's share of the area, or that of the method.
void set_springs(const StepOptions& options, double penalty, const BodyContact& contact,
                 LinearContact& c) {
  const Joint& joint = contact.joint;
  if (joint.normal_stiffness > 0.0 && contact.state.spring_area > 0.0) {
    c.normal_spring = joint.normal_stiffness * contact.state.spring_area;
    c.shear_spring = joint.shear_stiffness * contact.state.spring_area;
  } else if (options.method != ContactMethod::AugmentedLagrangian) {
    c.normal_spring = penalty_of(penalty, contact);
    c.shear_spring = options.shear_ratio * c.normal_spring;
  }
  if (c.law == ContactLaw::Frictionless) c.shear_spring = 0.0;
  c.compliant = options.method == ContactMethod::Springs || joint.normal_stiffness > 0.0;
  c.compliant = c.compliant && c.normal_spring > 0.0;
}

/// As the contact stands at the start of the step.
void set_law(const StepOptions& options, double penalty, BodyContact& contact, LinearContact& c) {
  const JointStrength now = strength(contact.joint, contact.state);
  c.law = bonded_in_shear(contact.joint, contact.state) ? ContactLaw::Stuck : law_of(now, options);
  c.friction = now.friction;
  c.cohesion = now.cohesion * contact.state.point.area;
  c.bonded = contact.state.bonded;
  c.was_bonded = contact.was_bonded;
  c.was_closed = contact.was_closed;
  c.assumed = contact.state.mode;
  contact.opening = opening(contact.joint, contact.state);
  set_springs(options, penalty, contact, c);
}

/// Contacts first, then one entry per held point.
void set_linear_contacts(const CompiledScene& compiled, const StepOptions& options,
                         Workspace& work) {
  work.linear.assign(work.contacts.size() + compiled.held.size(), LinearContact{});
  const auto& slot_of = compiled.slots.slot_of_block;
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    const BodyContact& contact = work.contacts[i];
    LinearContact& linear = work.linear[i];
    linear.slot_a = slot_of[index(contact.a)];
    linear.slot_b = slot_of[index(contact.b)];
    set_law(options, work.spring, work.contacts[i], linear);
    const bool touches = contact.state.point.gap <= options.tolerance * compiled.smallest_size;
    if (contact.laid && touches) linear.assumed = ContactMode::Stick;  // most of a masonry does
    if (linear.compliant) continue;
    Vector3 t1, t2;
    tangent_frame(contact, contact.state.point.normal, t1, t2);
    linear.multiplier = Vector3(contact.state.normal_force, -t1.dot(contact.state.shear_force),
                                -t2.dot(contact.state.shear_force));
    if (linear.law == ContactLaw::Frictionless) linear.multiplier.tail<2>().setZero();
  }
  for (std::size_t h = 0; h < compiled.held.size(); ++h) {
    LinearContact& linear = work.linear[work.contacts.size() + h];
    linear.slot_b = slot_of[index(compiled.held[h].block)];
    linear.law = ContactLaw::Bilateral;
  }
  set_pairs(work.linear, work.base);
}

void set_stiffness(const Workspace& work, LinearContact& c) {
  if (c.normal_spring > 0.0) {
    c.normal_stiffness = c.normal_spring;
    c.shear_stiffness = c.shear_spring;
  } else {
    set_augmentation(work.compliance, c);
  }
}

/// A spring at the middle of the step by its discrete gradient, -(U(g') - U(g))/(g' - g) with
/// U = p min(g,0)^2/2: work and stored energy then agree exactly. [Simo & Tarnow 1992; Gonzalez
/// 2000]
void apply_discrete_gradient(double gap_start, double gap_end, LinearContact& c) {
  const double p = c.normal_stiffness;
  c.offset.tail<2>() *= 2.0;  // the mean of start and end: (s + s')/2 with stiffness p
  c.shear_stiffness *= 0.5;
  const double g0 = std::min(gap_start, 0.0), g1 = std::min(gap_end, 0.0);
  if (c.bonded || (gap_start < 0.0 && gap_end < 0.0)) {
    c.normal_stiffness = 0.5 * p;
    c.offset[0] += gap_start;
    return;
  }
  if (gap_end >= 0.0 && gap_start >= 0.0) {  // open so far; the next linearisation knows better
    c.normal_stiffness = 0.5 * p;
    return;
  }
  const double mean_force = -0.5 * p * (g1 * g1 - g0 * g0) / (gap_end - gap_start);
  c.multiplier = Vector3(mean_force, 0.0, 0.0);
  c.normal_stiffness = 0.0;
}

void linearise_held(const CompiledScene& compiled, double time_end, Workspace& work) {
  for (std::size_t h = 0; h < compiled.held.size(); ++h) {
    const HeldPoint& held = compiled.held[h];
    const std::size_t b = index(held.block);
    LinearContact& linear = work.linear[work.contacts.size() + h];
    linear.jacobian_b =
        mean_motion(work.poses.start[b], work.poses.end[b], work.poses.increment[b].segment<3>(3),
                    held.arm, work.poses.deforms[b] != 0);
    linear.offset =
        displacement(compiled, held, work.poses.start[b]) - held.displacement.at(time_end);
    linear.rounding = 4.0 * std::numeric_limits<double>::epsilon() * held.arm.norm();
  }
}

/// How a contact would move in the step if it did nothing.
struct FreeFlight {
  Vector3 end = Vector3::Zero();  ///< d at the end of the step, m
  double approach = 0.0;          ///< normal velocity at its start, m in a step
};

/// A contact that closes in this step: sliding starts when it has closed, and it may bounce if it
/// closes by more than `slowest` (m in a step). In free flight the gap is a parabola in time; it
/// closes at its root (of a gap within `gap_tolerance`, m, that would be the root of noise), and
/// flies on after the impact for the rest of the step.
void set_closing(const FreeFlight& flight, double gap_tolerance, double slowest, const Joint& joint,
                 LinearContact& c) {
  const double gap = c.offset[0];
  if (!(gap > 0.0) || !(flight.end[0] < 0.0)) return;
  const double fall = gap - flight.end[0];
  const double bend = -2.0 * (fall + flight.approach);
  const double root =
      std::sqrt(std::max(0.0, flight.approach * flight.approach - 2.0 * bend * gap));
  const double share = gap <= gap_tolerance ? gap / fall : 2.0 * gap / (root - flight.approach);
  c.closing_share = share;
  c.offset.tail<2>() -= share * (flight.end.tail<2>() - c.offset.tail<2>());
  if (fall > slowest) {
    const double left = 1.0 - share;
    const double rebound = -joint.restitution * (flight.approach + share * bend) * left;
    c.offset[0] -= std::max(0.0, rebound + 0.5 * bend * left * left);
  }
}

/// Rebounds slower than gravity's own speed in two steps are not resolved by the step.
double bounce_speed(const CompiledScene& compiled, double time, double time_step) {
  return 2.0 * compiled.scene.gravity.at(time).norm() * time_step;
}

Vector3 moved(const BodyContact& contact, const StepPoses& poses, const LinearContact& c) {
  return c.jacobian_a * poses.increment[index(contact.a)] +
         c.jacobian_b * poses.increment[index(contact.b)];
}

/// Strength and opening go with the slip of the step, as the last solution had it: where
/// linearisations agree nothing lags, and the work of softening and dilation is exact.
void follow_slip(const BodyContact& contact, LinearContact& c) {
  const Joint& joint = contact.joint;
  c.dilation = opening(joint, contact.state, c.slip) - contact.opening;
  c.offset[0] -= c.dilation;
  if (!(joint.softening_slip > 0.0)) return;
  const JointStrength mean = strength(joint, contact.state, c.slip);
  c.friction = mean.friction;
  c.cohesion = mean.cohesion * contact.state.point.area;
}

/// Of joints whose law goes with the slip. A contact that has just opened counts, too: were it
/// closed it would have slid so far, and what it dilates by may be what closes it.
void measure_slips(Workspace& work) {
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    const BodyContact& contact = work.contacts[i];
    LinearContact& c = work.linear[i];
    if (contact.joint.dilation_angle == 0.0 && !can_fail(contact.joint)) continue;
    const bool opened = c.mode == ContactMode::Open && (contact.was_closed || c.start[0] <= 0.0);
    c.slip = opened ? (c.relative.tail<2>() - c.start.tail<2>()).norm()
                    : slip_in_step(c, moved(contact, work.poses, c));
  }
}

FreeFlight free_flight(const State& state, const BodyContact& contact,
                       const BlockVector& free_increment, double time_step,
                       const LinearContact& c) {
  FreeFlight flight{.end = c.offset};
  const auto add = [&](int slot, int block, const Matrix3x12& jacobian) {
    if (slot < 0) return;
    flight.end += jacobian * free_increment[index(slot)];
    flight.approach += time_step * jacobian.row(0).dot(velocity_vector(state.blocks[index(block)]));
  };
  add(c.slot_a, contact.a, c.jacobian_a);
  add(c.slot_b, contact.b, c.jacobian_b);
  return flight;
}

void linearise_all(const CompiledScene& compiled, const StepOptions& options, const State& state,
                   double time_step, Workspace& work) {
  const StepScheme scheme = scheme_of(options, time_step);
  const double slowest = bounce_speed(compiled, state.time, time_step);
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    const BodyContact& contact = work.contacts[i];
    LinearContact& c = work.linear[i];
    linearise(contact, work.poses, compiled.models, c);
    set_stiffness(work, c);
    if (!contact.was_closed && options.method == ContactMethod::AugmentedLagrangian &&
        options.analysis == Analysis::Dynamic) {
      set_closing(free_flight(state, contact, work.free_increment, time_step, c),
                  options.tolerance * compiled.smallest_size, slowest * time_step, contact.joint,
                  c);
    }
    follow_slip(contact, c);
    if (c.compliant && scheme.end_share < 1.0) {
      Vector3 end = c.offset;
      if (c.slot_a >= 0) end += c.jacobian_a * work.poses.increment[index(contact.a)];
      if (c.slot_b >= 0) end += c.jacobian_b * work.poses.increment[index(contact.b)];
      c.multiplier.setZero();
      apply_discrete_gradient(c.offset[0], end[0], c);
    }
  }
  linearise_held(compiled, state.time + duration(options, time_step), work);
  for (std::size_t h = work.contacts.size(); h < work.linear.size(); ++h) {
    set_stiffness(work, work.linear[h]);
  }
}

/// Loads stand for the middle of a dynamic step; a static one takes no time.
double load_time(const StepOptions& options, const State& state, double time_step) {
  return state.time + 0.5 * duration(options, time_step);
}

void set_force(const CompiledScene& compiled, const StepOptions& options, const State& state,
               double time_step, Workspace& work) {
  const double time = load_time(options, state, time_step);
  const Vector3 gravity = compiled.scene.gravity.at(time);
  work.force.resize(work.base.diagonal.size());
  for (std::size_t s = 0; s < work.force.size(); ++s) {
    const std::size_t b = index(compiled.slots.block_of_slot[s]);
    if (options.analysis == Analysis::Dynamic) {
      const StepScheme scheme = scheme_of(options, time_step, work.poses.deforms[b] != 0);
      work.force[s] =
          block_force(compiled.models[b], state.blocks[b], scheme, work.poses.increment[b]);
    } else {
      work.force[s] = static_block_force(compiled.models[b], state.blocks[b]);
    }
    work.force[s].head<3>() += compiled.models[b].mass * gravity;
  }
  for (const PointForce& load : compiled.loads) {
    const std::size_t b = index(load.block);
    const Matrix3x12 motion =
        mean_motion(work.poses.start[b], work.poses.end[b], work.poses.increment[b].segment<3>(3),
                    load.arm, work.poses.deforms[b] != 0);
    work.force[index(compiled.slots.slot_of_block[b])] +=
        motion.transpose() * (load.factor * load.force.at(time));
  }
}

void by_slot(const CompiledScene& compiled, const BlockVector& blocks, BlockVector& slots) {
  slots.resize(index(compiled.slots.count()));
  for (std::size_t s = 0; s < slots.size(); ++s) {
    slots[s] = blocks[index(compiled.slots.block_of_slot[s])];
  }
}

void by_block(const CompiledScene& compiled, const BlockVector& slots, BlockVector& blocks) {
  for (std::size_t s = 0; s < slots.size(); ++s) {
    blocks[index(compiled.slots.block_of_slot[s])] = slots[s];
  }
}

enum class Impacts { Expected, Solved };

/// Blocks that an impact of this step hits, and those that lean on them: expected from how they
/// move before the step is solved, or as it was solved.
void find_hit_blocks(const CompiledScene& compiled, const StepOptions& options, const State& state,
                     double time_step, Impacts impacts, Workspace& work) {
  work.hit.assign(state.blocks.size(), 0);
  if (options.method == ContactMethod::Springs || options.analysis != Analysis::Dynamic) return;
  const double slowest = bounce_speed(compiled, state.time, time_step) * time_step;
  bool grows = false;
  const auto hit = [&](int block) {
    if (compiled.idle[index(block)] || work.hit[index(block)]) return;
    work.hit[index(block)] = 1;
    grows = true;
  };
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    const LinearContact& c = work.linear[i];
    if (!(c.closing_share > 0.0) || !(c.start[0] > slowest * c.closing_share)) continue;
    if (impacts == Impacts::Solved && c.mode == ContactMode::Open) continue;
    hit(work.contacts[i].a);
    hit(work.contacts[i].b);
  }
  while (grows) {
    grows = false;
    for (const BodyContact& contact : work.contacts) {
      if (!contact.was_closed) continue;
      if (work.hit[index(contact.a)]) hit(contact.b);
      if (work.hit[index(contact.b)]) hit(contact.a);
    }
  }
}

/// The impulse of an impact is no force of one step's length: it would load the strain of every
/// block it passes through with energy that is not there. Hit blocks move rigidly through the step;
/// their strain goes on in the next. True when there are any that deform.
bool hold_strain_of_hit_blocks(const CompiledScene& compiled, const StepOptions& options,
                               double time_step, Workspace& work) {
  bool any = false;
  for (std::size_t b = 0; b < work.hit.size(); ++b) {
    if (!work.hit[b] || !work.poses.deforms[b]) continue;
    work.poses.deforms[b] = 0;
    work.poses.increment[b].tail<6>().setZero();
    any = true;
  }
  if (any) set_matrices(compiled, options, time_step, work);
  return any;
}

void show_contact_problem(const CompiledScene& compiled, const StepOptions& options,
                          const Workspace& work) {
  if (!options.contact_problem || !ConeProblem::suits(work.linear)) return;
  options.contact_problem(
      contact_problem(compiled.slots, work.base, work.force, work.linear, work.increment));
}

/// Linearise, solve, and again from where it ended, until the solution satisfies its own
/// linearisation.
OpenCloseResult solve_positions(const CompiledScene& compiled, const StepOptions& options,
                                const State& state, double time_step, Workspace& work) {
  OpenCloseOptions tuning;
  tuning.force_tolerance = options.tolerance;
  tuning.gap_tolerance = options.tolerance * compiled.smallest_size;
  tuning.raise = options.method == ContactMethod::AugmentedLagrangian;
  OpenCloseResult total;
  for (int pass = 0; pass < kLinearisations; ++pass) {
    set_end(compiled, state, work);
    set_force(compiled, options, state, time_step, work);
    if (pass == 0) {
      work.free_increment.resize(work.force.size());
      for (std::size_t s = 0; s < work.force.size(); ++s) {
        work.free_increment[s] = work.compliance[s] * work.force[s];
      }
    }
    linearise_all(compiled, options, state, time_step, work);
    if (pass == 0) find_hit_blocks(compiled, options, state, time_step, Impacts::Expected, work);
    if (pass == 0 && hold_strain_of_hit_blocks(compiled, options, time_step, work)) {
      set_force(compiled, options, state, time_step, work);
      linearise_all(compiled, options, state, time_step, work);
    }
    tuning.gap_rounding = gap_rounding(work.linear);
    by_slot(compiled, work.poses.increment, work.increment);
    work.clock.charge(&PhaseSeconds::assemble);
    tuning.predicted = pass == 0;
    tuning.max_iterations = work.iterations_left;
    if (pass == 0) show_contact_problem(compiled, options, work);
    const OpenCloseResult solved =
        solve_contacts(options, work.force, work.linear, tuning, work.increment, work);
    work.clock.charge(&PhaseSeconds::solve);
    by_block(compiled, work.increment, work.poses.increment);
    measure_slips(work);
    work.iterations_left -= solved.iterations;
    total.iterations += solved.iterations;
    total.solves += solved.solves;
    total.factorizations += solved.factorizations;
    total.residual = solved.residual;
    total.converged = solved.converged;
    if (solved.factorizations > 0) total.condition = solved.condition;
    double allowed = pass < kStrictLinearisations ? tuning.gap_rounding : tuning.gap_tolerance;
    if (work.yielding) allowed = kAgreement * compiled.smallest_size;
    if (!solved.converged || solved.change <= allowed) break;
    total.converged = false;  // until the next linearisation agrees
  }
  set_end(compiled, state, work);
  return total;
}

/// Both anchors to where the contact is now, `stretch` (place of b minus place of a) apart. The
/// anchor of a vertex stays on it.
void move_anchor(const Pose& a, const Pose& b, const ContactGeometry& now, const Vector3& stretch,
                 BodyContact& contact) {
  const Vector3 normal_part = now.gap * now.normal;
  if (contact.normal_on_a) {
    contact.state.anchor_b = contact.arm_b;
    contact.state.anchor_a = reference_arm(a, now.place_b - normal_part - stretch);
  } else {
    contact.state.anchor_a = contact.arm_a;
    contact.state.anchor_b = reference_arm(b, now.place_a + normal_part + stretch - now.between);
  }
}

void record_contacts(const Workspace& work, std::vector<BodyContact>& contacts) {
  contacts = work.contacts;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    BodyContact& contact = contacts[i];
    const LinearContact& c = work.linear[i];
    Contact& state = contact.state;
    const Pose& a = work.poses.end[index(contact.a)];
    const Pose& b = work.poses.end[index(contact.b)];
    const ContactGeometry now = contact_geometry(contact, a, b);
    Vector3 t1, t2;
    const ContactGeometry before = contact_geometry(contact, work.poses.start[index(contact.a)],
                                                    work.poses.start[index(contact.b)]);
    tangent_frame(contact, 0.5 * (before.normal + now.normal), t1, t2);
    state.mode = c.mode;
    state.impact = work.hit[index(contact.a)] || work.hit[index(contact.b)];
    state.normal_force = c.force[0];
    state.shear_force = -(c.force[1] * t1 + c.force[2] * t2);
    state.point.point_a = a.centroid + now.place_a;
    state.point.point_b = a.centroid + now.place_b;
    state.point.normal = now.normal;
    state.point.gap = now.gap;
    state.slip += slip_in_step(c, moved(contact, work.poses, c));
    if (contact.joint.softening_slip > 0.0 && state.slip >= contact.joint.softening_slip) {
      weaken(contact.joint, state);
    }
    if (c.mode == ContactMode::Open) continue;
    if (c.mode == ContactMode::Slip || (!contact.was_closed && !c.compliant)) {
      // The anchor follows: what stretch is left is the spring's at its limit (none for a
      // multiplier).
      Vector3 stretch = Vector3::Zero();
      if (c.compliant && c.shear_spring > 0.0) stretch = state.shear_force / c.shear_spring;
      move_anchor(a, b, now, stretch, contact);
    }
  }
}

void account_contact(const CompiledScene& compiled, const Workspace& work, std::size_t i,
                     Attempt& attempt) {
  const LinearContact& c = work.linear[i];
  const BodyContact& contact = work.contacts[i];
  const Vector12 &move_a = work.poses.increment[index(contact.a)],
                 &move_b = work.poses.increment[index(contact.b)];
  const auto push = [&](int idle, int other, const Matrix3x12& jacobian, const Vector12& motion) {
    if (compiled.models[index(idle)].unknowns > 0) return;
    const double done = c.force.dot(jacobian * motion);
    attempt.load_work -= done;
    attempt.work_on[index(other)] -= done;
  };
  push(contact.a, contact.b, c.jacobian_a, move_a);
  push(contact.b, contact.a, c.jacobian_b, move_b);
  const ContactWork done = contact_work(c, moved(contact, work.poses, c));
  attempt.spring_energy += done.stored;
  attempt.friction_work += done.heat;
  attempt.contact_work += done.impulse;
  attempt.scheme_loss += done.scheme;
}

/// What moves a held point does work.
void account_held(const HeldPoint& held, const LinearContact& c, const Workspace& work,
                  Attempt& attempt) {
  if (held.displacement.is_constant()) return;
  attempt.load_work += c.force.dot(c.jacobian_b * work.poses.increment[index(held.block)]);
}

/// omega dt of the stiffest spring: compliance of its blocks = (dt^2/2) / effective mass.
double stiffest_omega_dt(const Workspace& work) {
  double largest = 0.0;
  for (const LinearContact& c : work.linear) {
    if (!c.compliant || c.mode == ContactMode::Open) continue;
    const double compliance = compliance_along(c, 0, work.compliance);
    largest = std::max(largest, std::sqrt(2.0 * c.normal_spring * compliance));
  }
  return largest;
}

void account(const CompiledScene& compiled, const StepOptions& options, const State& state,
             double time_step, Workspace& work, Attempt& attempt) {
  const StepScheme scheme = scheme_of(options, time_step);
  const double time = load_time(options, state, time_step);
  const Vector3 gravity = compiled.scene.gravity.at(time);
  double largest_force = 0.0, unbalanced = 0.0;
  attempt.work_on.assign(state.blocks.size(), 0.0);
  for (std::size_t s = 0; s < work.increment.size(); ++s) {
    const std::size_t b = index(compiled.slots.block_of_slot[s]);
    const BlockModel& model = compiled.models[b];
    const Vector12& d = work.increment[s];
    attempt.work_on[b] = model.mass * gravity.dot(d.head<3>());
    attempt.gravity_work += attempt.work_on[b];
    if (model.unknowns == 12) {
      const Vector6 e = d.tail<6>();
      attempt.scheme_loss += (scheme.end_share - 0.5) * model.volume * e.dot(model.elasticity * e);
    }
    const double factor = 2.0 / (time_step * time_step);
    Vector12 inertial = Vector12::Zero();
    inertial.head<3>() = factor * model.mass * d.head<3>();
    inertial.segment<3>(3) = factor * (model.inertia * d.segment<3>(3));
    inertial.tail<6>() = factor * (model.strain_inertia * d.tail<6>());
    unbalanced = std::max(unbalanced, force_size(inertial, model.size));
    Vector12 prestress = Vector12::Zero();
    prestress.tail<6>() = model.volume * model.initial_stress;
    largest_force =
        std::max({largest_force, model.mass * gravity.norm(), force_size(prestress, model.size)});
  }
  for (const PointForce& load : compiled.loads) {
    const std::size_t b = index(load.block);
    const Vector3 force = load.factor * load.force.at(time);
    const Pose &start = work.poses.start[b], &end = work.poses.end[b];
    const Vector3 moved = between(start, end) + (end.shape * load.arm - start.shape * load.arm);
    attempt.load_work += force.dot(moved);
    attempt.work_on[b] += force.dot(moved);
    largest_force = std::max(largest_force, force.norm());
  }
  attempt.stiffest_omega_dt = stiffest_omega_dt(work);
  for (std::size_t i = 0; i < work.linear.size(); ++i) {
    largest_force = std::max(largest_force, work.linear[i].force.norm());
    if (i >= work.contacts.size()) {
      account_held(compiled.held[i - work.contacts.size()], work.linear[i], work, attempt);
    } else {
      account_contact(compiled, work, i, attempt);
    }
  }
  attempt.unbalance = largest_force > 0.0 ? unbalanced / largest_force : 0.0;
}

}  // namespace

OpenCloseResult solve_contacts(const StepOptions& options, const BlockVector& force,
                               std::span<LinearContact> contacts, const OpenCloseOptions& tuning,
                               BlockVector& increment, Workspace& work) {
  const bool open_close =
      options.contact_iteration == ContactIteration::OpenClose || !ConeProblem::suits(contacts);
  if (open_close) return work.open_close.solve(work.base, force, contacts, tuning, increment);
  OpenCloseResult tried;
  if (options.contact_iteration == ContactIteration::Automatic && !work.yielding) {
    const std::vector<LinearContact> start(contacts.begin(), contacts.end());
    const BlockVector guess = increment;
    OpenCloseOptions first = tuning;
    first.max_iterations = std::min(kPatience, tuning.max_iterations);
    tried = work.open_close.solve(work.base, force, contacts, first, increment);
    if (tried.converged) return tried;
    std::ranges::copy(start, contacts.begin());
    increment = guess;
  }
  work.yielding = true;
  OpenCloseOptions rest = tuning;
  rest.max_iterations -= tried.iterations;
  OpenCloseResult solved = work.moving_contacts.solve(work.base, force, contacts, rest, increment);
  solved.iterations += tried.iterations;
  solved.solves += tried.solves;
  solved.factorizations += tried.factorizations;
  return solved;
}

void list_contacts(std::span<const BodyContact> bodies, std::vector<Contact>& contacts) {
  contacts.clear();
  for (const BodyContact& contact : bodies) contacts.push_back(contact.state);
  std::ranges::sort(contacts, {}, [](const Contact& contact) { return contact.point.key; });
}

void start_end(const State& state, State& end) {
  end.step = state.step;
  end.origin = state.origin;
  end.energy = state.energy;
  end.blocks = state.blocks;
}

double duration(const StepOptions& options, double time_step) {
  return options.analysis == Analysis::Dynamic ? time_step : 0.0;
}

double gap_rounding(std::span<const LinearContact> contacts) {
  double largest = 0.0;
  for (const LinearContact& c : contacts) largest = std::max(largest, c.rounding);
  return largest;
}

double contact_spring(const CompiledScene& compiled, const StepOptions& options) {
  if (options.method == ContactMethod::AugmentedLagrangian) return 0.0;
  if (options.penalty > 0.0) return options.penalty;
  // 50 E L of the stiffest deformable block; for rigid scenes a static sag of 1e-6 of the block
  // size.
  double penalty = 0.0, weight = 0.0;
  const double gravity = std::max(compiled.scene.gravity.at(0.0).norm(), 1.0);
  for (const BlockModel& model : compiled.models) {
    penalty = std::max(penalty, 50.0 * model.elasticity(0, 0) * model.size);
    weight = std::max(weight, model.mass * gravity);
  }
  return penalty > 0.0 ? penalty : 1e6 * weight / compiled.smallest_size;
}

double spring_energy_at_rest(const CompiledScene& compiled, const StepOptions& options,
                             Workspace& work) {
  double sum = 0.0;
  for (BodyContact& contact : work.contacts) {
    LinearContact c;
    set_law(options, contact_spring(compiled, options), contact, c);
    c.start[0] = contact.state.point.gap - contact.opening;
    if (c.compliant) sum += contact_work(c, Vector3::Zero()).stored;
  }
  return sum;
}

void attempt_step(const CompiledScene& compiled, const StepOptions& options, const State& state,
                  double time_step, Workspace& work) {
  Attempt& attempt = work.attempt;
  static_cast<AttemptTotals&>(attempt) = {};
  work.yielding = false;
  work.spring = contact_spring(compiled, options);
  attempt.motion = work.motion;
  for (std::size_t p = 0; p < compiled.prescribed.size(); ++p) {
    attempt.motion[p] =
        advance_motion(compiled.scene.blocks[index(compiled.prescribed[p])].motion, work.motion[p],
                       state.time, state.time + duration(options, time_step));
  }
  set_start(compiled, options, state, time_step, attempt.motion, work);
  set_matrices(compiled, options, time_step, work);
  OpenCloseResult total;
  do {
    set_linear_contacts(compiled, options, work);
    const OpenCloseResult solved = solve_positions(compiled, options, state, time_step, work);
    total.iterations += solved.iterations;
    total.solves += solved.solves;
    total.factorizations += solved.factorizations;
    total.converged = solved.converged;
    total.residual = solved.residual;
    total.condition = solved.condition;
  } while (total.converged &&
           fail_overloaded(work.contacts, std::span(work.linear).first(work.contacts.size()),
                           kOpened * options.tolerance * compiled.smallest_size));
  work.clock.charge(&PhaseSeconds::assemble);
  attempt.solved = total;
  account(compiled, options, state, time_step, work, attempt);

  start_end(state, attempt.end);
  attempt.end.time = state.time + duration(options, time_step);
  for (std::size_t b = 0; b < state.blocks.size(); ++b) {
    const Vector12& d = work.poses.increment[b];
    if (compiled.models[b].unknowns == 0) {
      move_centroid(d.head<3>(), attempt.end.blocks[b]);
      continue;
    }
    BlockState& end = attempt.end.blocks[b];
    end = displaced(state.blocks[b], d);
    if (options.analysis == Analysis::Dynamic) {
      end = with_end_velocity(end, state.blocks[b], d, time_step);
      if (!work.poses.deforms[b]) end.strain_rate.setZero();
    } else {
      end.velocity.setZero();
      end.angular_velocity.setZero();
      end.strain_rate.setZero();
    }
    const double moved =
        d.head<3>().norm() + d.segment<3>(3).norm() * 0.5 * compiled.models[b].size;
    attempt.displacement = std::max(attempt.displacement, moved / compiled.models[b].size);
  }
  for (std::size_t p = 0; p < compiled.prescribed.size(); ++p) {
    attempt.end.blocks[index(compiled.prescribed[p])].velocity = attempt.motion[p].velocity;
  }
  find_hit_blocks(compiled, options, state, time_step, Impacts::Solved, work);
  record_contacts(work, attempt.contacts);
  list_contacts(attempt.contacts, attempt.end.contacts);
}

}  // namespace quoin::solver
