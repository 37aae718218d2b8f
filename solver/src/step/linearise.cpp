#include "step/linearise.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/index.hpp"
#include "contact/joint_failure.hpp"
#include "contact/joint_law.hpp"
#include "contact/joint_springs.hpp"
#include "linear/small_matrices.hpp"
#include "step/predict.hpp"

namespace quoin::solver {
namespace {

void set_rigid_inverse(const Matrix12& matrix, Matrix12& inverse) {
  inverse.diagonal().head<3>() = matrix.diagonal().head<3>().cwiseInverse();
  inverse.block<3, 3>(3, 3) = matrix.block<3, 3>(3, 3).inverse();
}

bool same(const StepScheme& x, const StepScheme& y) {
  return x.time_step == y.time_step && x.end_share == y.end_share && x.deforms == y.deforms;
}

}  // namespace

void set_matrices(const SubStep& step, const StepPoses& poses, BlockTerms& terms) {
  const std::vector<int>& blocks = step.island.slots.block_of_slot;
  const int width = step.island.slots.width();
  terms.base.diagonal.resize(blocks.size(), width);
  terms.base.frames.resize(blocks.size());
  terms.compliance.resize(blocks.size(), width);
  terms.scheme.resize(blocks.size());
  for (std::size_t s = 0; s < blocks.size(); ++s) {
    const std::size_t b = index(blocks[s]);
    const bool deforms = poses.deforms[b] != 0;
    terms.base.frames[s] = {poses.start[b].centroid, poses.start[b].rotation};
    const StepScheme scheme = step.scheme(deforms);
    if (same(scheme, terms.scheme[s])) continue;
    terms.scheme[s] = scheme;
    const Matrix12 matrix = block_matrix(step.compiled.models[b], scheme);
    Matrix12 inverse = Matrix12::Zero();
    if (deforms)
      invert_symmetric(matrix, inverse);
    else
      set_rigid_inverse(matrix, inverse);
    terms.base.diagonal[s] = matrix.topLeftCorner(width, width);
    terms.compliance[s] = inverse.topLeftCorner(width, width);
  }
}

void set_force(const SubStep& step, const StepPoses& poses, BlockTerms& terms) {
  const std::vector<int>& blocks = step.island.slots.block_of_slot;
  const double time = step.load_time();
  const Vector3 gravity = step.compiled.scene.gravity.at(time);
  terms.force.resize(blocks.size());
  for (std::size_t s = 0; s < blocks.size(); ++s) {
    const std::size_t b = index(blocks[s]);
    const BlockModel& model = step.compiled.models[b];
    const StepScheme scheme = step.scheme(poses.deforms[b] != 0);
    terms.force[s] =
        step.dynamic() ? block_force(model, start_state(step, poses, b), scheme, poses.increment[b])
                       : static_block_force(model, step.state[b]);
    terms.force[s].head<3>() += model.mass * gravity;
  }
  for (const int l : step.island.loads) {
    const PointForce& load = step.compiled.loads[index(l)];
    const std::size_t b = index(load.block);
    const Matrix3x12 motion =
        mean_motion(poses.start[b], poses.end[b], poses.increment[b].segment<3>(3), load.arm,
                    poses.deforms[b] != 0);
    terms.force[index(step.slot_of_block[b])] += motion.transpose() * force(step, poses, load);
  }
}

namespace {

// Springs that the user leaves to the solver. Chosen: a deformable block then shares out its
// compression one to fifty with a contact; a rigid scene sags by 1e-6 of a block.
constexpr double kSpringOfBlock = 50.0;  // E L
constexpr double kSpringOfWeight = 1e6;  // weight / block size
constexpr double kLeastGravity = 1.0;    // m/s2: what a scene without gravity is taken to bear
constexpr double kAtOnce = std::numeric_limits<double>::epsilon();  // share of the step: none

// Of its own acceleration, how many steps of it a contact has to close with: a slender block swings
// on one edge for long though its other edge lands slowly. Of what gravity does in two steps: less
// is what moving blocks leave of gaps.
constexpr double kSteps = 4.0, kNoise = 0.05;
// Of its own acceleration again, where a block deforms: from rest that closes a gap within the step
// with a half of it at most, as where strain is set free, or what pressed an impact's blocks is not
// known. Taken for an impact it would hold the strain, and so come back in each step.
constexpr double kFromRest = 2.0;

/// A coefficient that nothing slides by while a scene settles.
constexpr double kSettles = 100.0;

/// A bond that is pulled has no friction: shear that settling left on it would spring free in the
/// next stage.
JointStrength strength_in(const StepOptions& options, const BodyContact& contact, double slip) {
  JointStrength now = strength(*contact.joint, contact.state, slip);
  const bool pulled = contact.state.bonded && contact.state.normal_force < 0.0;
  if (options.analysis == Analysis::Settle && !pulled)
    now.friction = std::max(now.friction, kSettles);
  return now;
}

/// The joint's stiffness on the contact's share of the area, or that of the method.
void set_springs(const StepOptions& options, double penalty, const BodyContact& contact,
                 LinearContact& c) {
  const Joint& joint = *contact.joint;
  if (joint.normal_stiffness > 0.0 && contact.state.spring_area > 0.0) {
    c.normal_spring = joint.normal_stiffness * contact.state.spring_area;
    c.shear_spring = joint.shear_stiffness * contact.state.spring_area;
  } else if (options.method != ContactMethod::AugmentedLagrangian) {
    c.normal_spring = penalty * contact.penalty_share;
    c.shear_spring = options.shear_ratio * c.normal_spring;
  }
  if (c.law == ContactLaw::Frictionless) c.shear_spring = 0.0;
  c.compliant = options.method == ContactMethod::Springs || joint.normal_stiffness > 0.0;
  c.compliant = c.compliant && c.normal_spring > 0.0;
}

/// What opens within the step, or meets, bears none: its shear would jump where it is pressed, and
/// steps had no solution.
bool bears_cohesion(const LinearContact& c) { return c.bonded || c.clings; }

/// As the contact stands at the start of the step. `parting_gap`: beyond it only what was closed
/// clings, m.
void set_law(const StepOptions& options, double penalty, double parting_gap, BodyContact& contact,
             LinearContact& c) {
  const Joint& joint = *contact.joint;
  contact.opening = opening(joint, contact.state);
  const bool near = contact.state.point.gap - contact.opening <= parting_gap;
  c.clings = clings(joint, contact.state) && !contact.parted && (contact.was_closed || near);
  c.bonded = contact.state.bonded;
  JointStrength now = strength_in(options, contact, 0.0);
  if (!bears_cohesion(c)) now.cohesion = 0.0;
  const bool rough = now.friction > 0.0 || now.cohesion > 0.0;
  c.law = rough ? ContactLaw::Coulomb : ContactLaw::Frictionless;
  if (bonded_in_shear(joint, contact.state) && bears_cohesion(c)) c.law = ContactLaw::Stuck;
  c.friction = now.friction;
  c.cohesion = now.cohesion * contact.state.point.area;
  c.was_bonded = contact.was_bonded;
  c.was_closed = contact.was_closed;
  c.assumed = contact.state.mode;
  set_springs(options, penalty, contact, c);
}

/// Of a spring as its contact lies: gap beyond the opening, and the length of its slips, m.
Vector3 stretch(const BodyContact& contact, const Pose& a, const Pose& b) {
  const ContactGeometry now = contact_geometry(contact, a, b);
  return {now.gap - contact.opening, shear_stretch(a, b, now.normal, contact.state).norm(), 0.0};
}

void set_stiffness(const BlockTerms& terms, LinearContact& c) {
  if (c.normal_spring > 0.0) {
    c.normal_stiffness = c.normal_spring;
    c.shear_stiffness = c.shear_spring;
  } else {
    set_augmentation(terms.compliance, c);
  }
}

/// A spring at the middle of the step by its discrete gradient, -(U(g') - U(g))/(g' - g) with
/// U = p min(g,0)^2/2: work and stored energy then agree exactly. [Simo & Tarnow 1992; Gonzalez
/// 2000] The offset has more than the start, as what a support moves by: that is of the end alone.
void apply_discrete_gradient(double gap_end, LinearContact& c) {
  const double p = c.normal_stiffness, gap_start = c.start[0];
  c.multiplier.setZero();
  c.offset.tail<2>() += c.start.tail<2>();  // the mean of both: (s + s')/2 with stiffness p
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

double end_gap(const BodyContact& contact, const StepPoses& poses, const LinearContact& c) {
  Vector3 end = c.offset;
  if (c.slot_a >= 0) end += c.jacobian_a * poses.increment[index(contact.a)];
  if (c.slot_b >= 0) end += c.jacobian_b * poses.increment[index(contact.b)];
  return end[0];
}

void linearise_held(const SubStep& step, const StepPoses& poses, const HeldPoint& held,
                    LinearContact& c) {
  const std::size_t b = index(held.block);
  const bool deforms = poses.deforms[b] != 0;
  c.jacobian_b.set(mean_motion(poses.start[b], poses.end[b], poses.increment[b].segment<3>(3),
                               held.arm, deforms),
                   deforms);
  c.offset =
      displacement(step.compiled, held, poses.start[b]) - held.displacement.at(step.end_time());
  // Also of a point at the centroid: what the block is pushed by is rounded as places on it are.
  const double place = std::max(held.arm.norm(), 0.5 * step.compiled.models[b].size);
  c.rounding = 4.0 * std::numeric_limits<double>::epsilon() * place;
}

/// What a contact that was closed bore, on its blocks. The impulse of an impact says nothing of
/// that.
void add_last_force(const SubStep& step, const StepPoses& poses, const BodyContact& contact,
                    BlockVector& force) {
  const Contact& last = contact.state;
  if (!contact.was_closed || last.impact) return;
  const Vector3 on_b = last.next_normal_force * last.point.normal - last.next_shear_force;
  const auto add = [&](int block, const Vector3& arm, const Vector3& on_block) {
    const int slot = step.slot_of_block[index(block)];
    if (slot < 0) return;
    const Matrix3x12 moving = motion(poses.start[index(block)], arm, poses.deforms[index(block)]);
    force[index(slot)] += moving.transpose() * on_block;
  };
  add(contact.a, contact.arm_a, -on_b);
  add(contact.b, contact.arm_b, on_b);
}

/// How a contact would move in the step if it did nothing. Blocks without unknowns count like all
/// others: what moves along with one of them closes as if both were at rest.
struct FreeFlight {
  Vector3 start = Vector3::Zero();  ///< d as the blocks stand at the start of the step, m
  Vector3 end = Vector3::Zero();    ///< d at its end, m
  double approach = 0.0;            ///< normal velocity at its start, m in a step
  bool deforms = false;             ///< one of its blocks, in this step or a later one
};

/// Normal velocity at the start, m/s.
double approach_speed(const SubStep& step, const StepPoses& poses, const BodyContact& contact) {
  const auto velocity = [&](int block, const Vector3& arm) -> Vector3 {
    const std::size_t b = index(block);
    return motion(poses.start[b], arm, poses.deforms[b]) * velocity_vector(step.state[b]);
  };
  const Pose &a = poses.start[index(contact.a)], &b = poses.start[index(contact.b)];
  return contact_geometry(contact, a, b)
      .normal.dot(velocity(contact.b, contact.arm_b) - velocity(contact.a, contact.arm_a));
}

/// By the mean rows of the step what turns as one comes on by about so much, m: by a twelfth of the
/// turn's square at its arm (measured on three bonded cubes, not derived).
double common_turn(const SubStep& step, const BodyContact& contact) {
  const double turned =
      step.length * std::min(step.state[index(contact.a)].angular_velocity.norm(),
                             step.state[index(contact.b)].angular_velocity.norm());
  return turned * turned / 12.0 * std::max(contact.arm_a.norm(), contact.arm_b.norm());
}

FreeFlight free_flight(const SubStep& step, const BlockTerms& terms, const StepPoses& poses,
                       const BodyContact& contact, const LinearContact& c) {
  FreeFlight flight{.start = c.offset, .end = c.offset};
  const auto deforms = [&](int block) { return step.compiled.models[index(block)].unknowns == 12; };
  flight.deforms = deforms(contact.a) || deforms(contact.b);
  const auto add = [&](int slot, int block, const ContactJacobian& jacobian) {
    if (slot >= 0)
      flight.end += jacobian * terms.free_increment[index(slot)];
    else  // its motion is in the offset
      flight.start -= jacobian * poses.increment[index(block)];
    flight.approach += step.length * jacobian.normal(velocity_vector(step.state[index(block)]));
  };
  add(c.slot_a, contact.a, c.jacobian_a);
  add(c.slot_b, contact.b, c.jacobian_b);
  const double missed = std::max(step.gap_tolerance(), common_turn(step, contact));
  if (std::abs(flight.start[0]) <= missed)
    flight.approach = step.length * approach_speed(step, poses, contact);
  return flight;
}

/// A contact that closes in this step: sliding starts when it has closed, and it may bounce if it
/// closes by more than `slowest` (m in a step). In free flight the gap is a parabola in time; it
/// closes at its root (of a gap within `gap_tolerance`, m, that would be the root of noise), and
/// flies on after the impact for the rest of the step. Blocks that touch and come on are hit at
/// once; those that come to touch, to the tolerance, as the step ends are hit in it.
void set_closing(const FreeFlight& flight, double gap_tolerance, double slowest, const Joint& joint,
                 LinearContact& c) {
  const double gap = flight.start[0];
  const bool at_once =
      std::abs(gap) <= gap_tolerance && flight.approach < -std::max(slowest, gap_tolerance);
  const double last = gap > gap_tolerance ? gap_tolerance : 0.0;  // gap that counts as closed
  if (!(gap > 0.0 || at_once) || !(flight.end[0] < last)) return;
  const double fall = gap - flight.end[0];
  const double bend = -2.0 * (fall + flight.approach);
  const double root =
      std::sqrt(std::max(0.0, flight.approach * flight.approach - 2.0 * bend * gap));
  const double share =
      gap <= gap_tolerance ? gap / fall : std::min(1.0, 2.0 * gap / (root - flight.approach));
  c.closing_share = at_once ? kAtOnce : share;
  const double speed = at_once ? -flight.approach : gap / share;
  const double most = flight.deforms ? std::max(slowest, kFromRest * std::abs(bend)) : slowest;
  c.hits = speed > std::clamp(kSteps * std::abs(bend), kNoise * slowest, most);
  c.offset.tail<2>() -= share * (flight.end.tail<2>() - flight.start.tail<2>());
  if (fall > slowest) {
    const double left = 1.0 - share;
    const double rebound = -joint.restitution * (flight.approach + share * bend) * left;
    c.offset[0] -= std::max(0.0, rebound + 0.5 * bend * left * left);
  }
}

/// What a joint that softens bears in shear, as the mean over the slip of the step.
struct ShearOfPoint {
  double friction = 0.0;  ///< tan of the friction angle
  double cohesion = 0.0;  ///< N
};

ShearOfPoint shear_of_point(const StepOptions& options, const BodyContact& contact,
                            const LinearContact& c) {
  const JointStrength mean = strength_in(options, contact, c.slip);
  return {mean.friction, bears_cohesion(c) ? mean.cohesion * contact.state.point.area : 0.0};
}

/// Strength and opening go with the slip of the step, as the last solution had it: where
/// linearisations agree nothing lags, and the work of softening and dilation is exact.
void follow_slip(const StepOptions& options, const BodyContact& contact, LinearContact& c) {
  const Joint& joint = *contact.joint;
  c.dilation = opening(joint, contact.state, c.slip) - contact.opening;
  c.offset[0] -= c.dilation;
  const bool slides = !c.compliant && c.law != ContactLaw::Stuck;
  c.dilation_slope = slides ? dilation_slope(joint, contact.state) : 0.0;
  c.dilating_slip = joint.dilation_slip > 0.0 ? joint.dilation_slip - contact.state.slip
                                              : std::numeric_limits<double>::infinity();
  if (!(joint.softening_slip > 0.0)) return;
  const ShearOfPoint mean = shear_of_point(options, contact, c);
  c.friction = mean.friction;
  c.cohesion = mean.cohesion;
}

/// Static: d, the motion of the step, is held. Dynamic: dashpots to a ground with twice the
/// velocity of the incoming wave [Joyner & Chen 1975], beside what held it.
void linearise_quiet(const SubStep& step, const BlockTerms& terms, const StepPoses& poses,
                     int number, LinearContact& c) {
  const QuietPoint& quiet = step.compiled.quiet[index(number)];
  const std::size_t b = index(quiet.block);
  const bool deforms = poses.deforms[b] != 0;
  const Matrix3 rows = quiet_frame(quiet, poses.start[b]);
  c.jacobian_b.set(rows * mean_motion(poses.start[b], poses.end[b],
                                      poses.increment[b].segment<3>(3), quiet.arm, deforms),
                   deforms);
  if (!step.dynamic()) return set_stiffness(terms, c);
  c.offset = -2.0 * step.length * (rows * quiet.velocity.at(step.load_time()));
  c.normal_stiffness = quiet.normal_viscosity / step.length;
  c.shear_stiffness = quiet.shear_viscosity / step.length;
  c.multiplier = rows * step.quiet[index(number)];
}

void set_tie_law(const SubStep& step, int number, LinearContact& c) {
  const Tie& tie = step.compiled.ties[index(number)].tie;
  const auto slot = [&](int block) { return block < 0 ? -1 : step.slot_of_block[index(block)]; };
  c.slot_a = slot(tie.a);
  c.slot_b = slot(tie.b);
  if (c.slot_a < 0 || c.slot_b < 0) c.pair = -2 - std::max(0, c.slot_a < 0 ? tie.a : tie.b);
  c.law = ContactLaw::Tie;
  c.assumed = ContactMode::Stick;
  c.compliant = true;
  c.bonded = !tie.tension_only;
  c.cohesion = tie.yield_force;
  c.normal_spring = tie.stiffness;
  c.force[0] = step.ties[index(number)].force;
}

}  // namespace

Matrix3 quiet_frame(const QuietPoint& quiet, const Pose& pose) {
  const Vector3 normal = pose.rotation * quiet.normal;
  Matrix3 rows;
  rows.row(0) = normal;
  rows.row(1) = normal.unitOrthogonal();
  rows.row(2) = normal.cross(Vector3(rows.row(1)));
  return rows;
}

Vector3 force_in_frame(const Contact& force, const BodyContact& contact, const Vector3& normal) {
  Vector3 t1, t2;
  tangent_frame(contact, normal, t1, t2);
  const Vector3& shear = force.next_shear_force;  // on A
  return Vector3(force.next_normal_force, -t1.dot(shear), -t2.dot(shear));
}

Vector3 moved_by(const StepPoses& poses, const BodyContact& contact, const LinearContact& c) {
  return c.jacobian_a * poses.increment[index(contact.a)] +
         c.jacobian_b * poses.increment[index(contact.b)];
}

double contact_spring(const CompiledScene& compiled, const StepOptions& options) {
  if (options.method == ContactMethod::AugmentedLagrangian) return 0.0;
  if (options.penalty > 0.0) return options.penalty;
  // Of the stiffest deformable block, else of the heaviest.
  double penalty = 0.0, weight = 0.0;
  const double gravity = std::max(compiled.scene.gravity.at(0.0).norm(), kLeastGravity);
  for (const BlockModel& model : compiled.models) {
    penalty = std::max(penalty, kSpringOfBlock * model.elasticity(0, 0) * model.size);
    weight = std::max(weight, model.mass * gravity);
  }
  return penalty > 0.0 ? penalty : kSpringOfWeight * weight / compiled.smallest_size;
}

void set_laws(const SubStep& step, std::span<BodyContact> contacts,
              std::vector<LinearContact>& linear) {
  const double spring = contact_spring(step.compiled, step.options);
  const IslandBlocks& island = step.island;
  const std::size_t first_tie = contacts.size() + island.held.size();
  const std::size_t first_quiet = first_tie + island.ties.size();
  linear.resize(first_quiet + island.quiet.size());
  for (ContactTerms& c : linear) c = {};
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    LinearContact& c = linear[i];
    c.slot_a = step.slot_of_block[index(contacts[i].a)];
    c.slot_b = step.slot_of_block[index(contacts[i].b)];
    if (c.slot_a < 0 || c.slot_b < 0) c.pair = -2 - (c.slot_a < 0 ? contacts[i].a : contacts[i].b);
    set_law(step.options, spring, step.parting_gap(), contacts[i], c);
    const double gap = contacts[i].state.point.gap;
    const bool touches = gap <= step.gap_tolerance();
    if (contacts[i].laid && touches) c.assumed = ContactMode::Stick;  // most of a masonry does
    if (c.compliant) continue;
    c.multiplier = force_in_frame(contacts[i].state, contacts[i], contacts[i].state.point.normal);
    if (c.law == ContactLaw::Frictionless) c.multiplier.tail<2>().setZero();
  }
  for (std::size_t h = 0; h < step.island.held.size(); ++h) {
    LinearContact& c = linear[contacts.size() + h];
    const HeldPoint& held = step.compiled.held[index(step.island.held[h])];
    c.slot_b = step.slot_of_block[index(held.block)];
    c.law = ContactLaw::Bilateral;
  }
  for (std::size_t t = 0; t < island.ties.size(); ++t)
    set_tie_law(step, island.ties[t], linear[first_tie + t]);
  for (std::size_t q = 0; q < island.quiet.size(); ++q) {
    LinearContact& c = linear[first_quiet + q];
    c.slot_b = step.slot_of_block[index(step.compiled.quiet[index(island.quiet[q])].block)];
    c.law = ContactLaw::Bilateral;
    c.compliant = step.dynamic();
  }
}

void set_free_increment(const SubStep& step, const StepPoses& poses,
                        std::span<const BodyContact> contacts, BlockTerms& terms) {
  const auto may_close = [](const BodyContact& contact) { return !contact.was_closed; };
  if (!std::ranges::any_of(contacts, may_close)) return;  // nobody asks
  terms.free_increment = terms.force;
  for (const BodyContact& contact : contacts)
    add_last_force(step, poses, contact, terms.free_increment);
  for (std::size_t s = 0; s < terms.force.size(); ++s)
    terms.free_increment[s] = terms.compliance.times(s, terms.free_increment[s]);
}

void linearise(const SubStep& step, const BlockTerms& terms, const StepPoses& poses,
               std::span<const TieState> ties, std::span<BodyContact> contacts,
               std::span<LinearContact> linear) {
  const double slowest = step.bounce_speed() * step.length;
  const bool impacts = step.options.method == ContactMethod::AugmentedLagrangian && step.dynamic();
  const bool midpoint = step.scheme().end_share < 1.0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    BodyContact& contact = contacts[i];
    LinearContact& c = linear[i];
    const std::size_t a = index(contact.a), b = index(contact.b);
    uncross_turned_edges({poses.start[a], poses.start[b]}, {poses.end[a], poses.end[b]}, contact);
    linearise(contact, poses, step.compiled.models, c);
    set_stiffness(terms, c);
    const Vector3 motion = c.offset;
    // What a spring stores goes by its whole stretch, and so does its force: it has no impact.
    if (!contact.was_closed && impacts && !c.compliant) {
      set_closing(free_flight(step, terms, poses, contact, c), step.gap_tolerance(), slowest,
                  *contact.joint, c);
    }
    follow_slip(step.options, contact, c);
    c.left_out = c.offset - motion;
    if (c.compliant && midpoint) apply_discrete_gradient(end_gap(contact, poses, c), c);
  }
  for (std::size_t h = 0; h < step.island.held.size(); ++h) {
    LinearContact& c = linear[contacts.size() + h];
    linearise_held(step, poses, step.compiled.held[index(step.island.held[h])], c);
    set_stiffness(terms, c);
  }
  std::size_t next = contacts.size() + step.island.held.size();
  for (std::size_t t = 0; t < ties.size(); ++t) {
    linearise_tie(step.compiled.ties[index(step.island.ties[t])], ties[t], poses,
                  step.scheme().end_share, linear[next++]);
  }
  for (const int q : step.island.quiet) linearise_quiet(step, terms, poses, q, linear[next++]);
}

void measure_slips(const StepPoses& poses, std::span<const BodyContact> contacts, bool opens,
                   std::span<LinearContact> linear) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const BodyContact& contact = contacts[i];
    LinearContact& c = linear[i];
    if (contact.joint->dilation_angle == 0.0 && !(contact.joint->softening_slip > 0.0)) continue;
    const bool opened = c.mode == ContactMode::Open && (contact.was_closed || c.start[0] <= 0.0);
    c.slip = opened ? (c.relative.tail<2>() - c.start.tail<2>()).norm()
                    : slip_in_step(c, moved_by(poses, contact, c));
    if (opens && c.dilation_slope > 0.0) c.dilation = dilation(c, c.slip);
  }
}

bool slip_lags(const StepOptions& options, std::span<const BodyContact> contacts,
               std::span<const LinearContact> linear, double tolerance) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const BodyContact& contact = contacts[i];
    const LinearContact& c = linear[i];
    if (c.mode != ContactMode::Slip) continue;
    const double normal = c.bonded ? c.force[0] : std::max(c.force[0], 0.0);
    const double opened = opening(*contact.joint, contact.state, c.slip) - contact.opening;
    if (c.normal_spring * std::abs(opened - c.dilation) > tolerance * normal) return true;
    if (!(contact.joint->softening_slip > 0.0)) continue;
    const ShearOfPoint mean = shear_of_point(options, contact, c);
    const double used = std::max(c.friction * normal + c.cohesion, 0.0);
    const double change = std::max(mean.friction * normal + mean.cohesion, 0.0) - used;
    if (std::abs(change) > tolerance * used) return true;
  }
  return false;
}

double gap_rounding(std::span<const LinearContact> contacts) {
  double largest = 0.0;
  for (const LinearContact& c : contacts) largest = std::max(largest, c.rounding);
  return largest;
}

void store_at_rest(const CompiledScene& compiled, const StepOptions& options,
                   std::span<const Pose> poses, std::span<BodyContact> contacts,
                   std::vector<double>& stored) {
  const double spring = contact_spring(compiled, options);
  const std::vector<int>& slots = compiled.slots.slot_of_block;
  for (BodyContact& contact : contacts) {
    LinearContact c;
    set_law(options, spring, 0.0, contact, c);
    if (!c.compliant) continue;
    c.start = stretch(contact, poses[index(contact.a)], poses[index(contact.b)]);
    c.mode = contact.was_closed ? ContactMode::Stick : ContactMode::Open;
    const int slot =
        slots[index(contact.a)] >= 0 ? slots[index(contact.a)] : slots[index(contact.b)];
    // And what was stored on areas that are gone, which is booked as lost when a step is taken.
    stored[index(slot)] += contact_work(c, Vector3::Zero()).stored + contact.spring_loss;
  }
}

}  // namespace quoin::solver
