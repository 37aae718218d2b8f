#include "source_method/paper_step.hpp"

#include <algorithm>
#include <cmath>

#include "base/index.hpp"
#include "linear/small_matrices.hpp"
#include "step/energy_ledger.hpp"

namespace quoin::solver {
namespace {

/// What stays as it is through the step.
struct StepSetting {
  const CompiledScene& compiled;
  const StepOptions& options;
  const SubStep& sub_step;
  std::span<const Pose> start;             ///< by block
  const std::vector<Vector12>& increment;  ///< by block: D; until it is solved, of prescribed
                                           ///< blocks only

  bool dynamic() const { return sub_step.dynamic(); }
  double time_step() const { return sub_step.length; }
  double load_time() const { return sub_step.load_time(); }
  double end_time() const { return sub_step.end_time(); }
  const BlockState& state(int block) const { return sub_step.state[index(block)]; }
  /// T(x), 3×12, of a material point at the start of the step.
  Matrix3x12 point_motion(int block, const Vector3& arm) const {
    return motion(start[index(block)], arm, compiled.models[index(block)].unknowns == 12);
  }
  /// A material point from the centroid.
  Vector3 lever(int block, const Vector3& arm) const { return start[index(block)].shape * arm; }
  /// Of a held point since it began to be held.
  Vector3 moved(const HeldPoint& held) const {
    return displacement(compiled, held, start[index(held.block)]);
  }
};

/// K and F of the blocks alone; a held point is a spring of stiffness `penalty` (N/m).
void assemble_blocks(const StepSetting& step, double penalty, BlockSystem& base,
                     BlockVector& force) {
  const CompiledScene& compiled = step.compiled;
  const StepScheme scheme{step.time_step()};
  const double time = step.load_time();
  const int n = compiled.slots.width();
  base.diagonal.resize(compiled.slots.size.size(), n);
  force.clear();
  for (const int b : compiled.slots.block_of_slot) {
    const BlockModel& model = compiled.models[index(b)];
    const BlockState& now = step.state(b);
    const Matrix12 matrix = block_matrix(model, scheme);
    base.diagonal[force.size()] = matrix.topLeftCorner(n, n);
    force.push_back(step.dynamic() ? block_force(model, now, scheme, Vector12::Zero())
                                   : static_block_force(model, now));
    force.back().head<3>() += model.mass * compiled.scene.gravity.at(time);
  }
  const auto slot = [&](int block) { return index(compiled.slots.slot_of_block[index(block)]); };
  for (const PointForce& load : compiled.loads) {
    force[slot(load.block)] += step.point_motion(load.block, load.arm).transpose() *
                               load.at(step.start[index(load.block)], time);
  }
  for (const HeldPoint& held : compiled.held) {
    const Matrix3x12 t = step.point_motion(held.block, held.arm);
    const Vector3 off = step.moved(held) - held.displacement.at(step.end_time());
    const Matrix12 spring = penalty * t.transpose() * t;
    base.diagonal[slot(held.block)] += spring.topLeftCorner(n, n);
    force[slot(held.block)] -= penalty * t.transpose() * off;
  }
}

/// What the motion of prescribed blocks, a translation, adds to P0'P1', m.
Vector3 driven(const StepSetting& step, int i, int j) {
  return step.increment[index(i)].head<3>() - step.increment[index(j)].head<3>();
}

/// P1 on block i before P0 on block j.
PointToFace point_to_face(const StepSetting& step, int i, int j, const Vector3& arm_i,
                          const Vector3& arm_j, const Vector3& normal) {
  PointToFace contact;
  contact.normal = normal;
  contact.motion_i = step.point_motion(i, arm_i);
  contact.motion_j = step.point_motion(j, arm_j);
  contact.between = between(step.start[index(j)], step.start[index(i)]) +
                    (step.lever(i, arm_i) - step.lever(j, arm_j)) + driven(step, i, j);
  return contact;
}

/// The face is that of the block which carries the normal; of two crossed edges one stands for it.
PaperContact paper_contact(const StepSetting& step, const BodyContact& from) {
  const bool face_on_a = from.normal_on_a;
  const int i = face_on_a ? from.b : from.a, j = face_on_a ? from.a : from.b;
  const Vector3 a_to_b = contact_normal(from, step.start[index(from.a)], step.start[index(from.b)]);
  const Vector3 normal = face_on_a ? a_to_b : Vector3(-a_to_b);
  const Contact& state = from.state;
  PaperContact c;
  c.slot_i = step.compiled.slots.slot_of_block[index(i)];
  c.slot_j = step.compiled.slots.slot_of_block[index(j)];
  c.normal = point_to_face(step, i, j, face_on_a ? from.arm_b : from.arm_a,
                           face_on_a ? from.arm_a : from.arm_b, normal);
  c.shear = point_to_face(step, i, j, face_on_a ? state.anchor_b : state.anchor_a,
                          face_on_a ? state.anchor_a : state.anchor_b, normal);
  c.driven = driven(step, i, j);
  c.friction = std::tan(from.joint->friction_angle);
  c.cohesion = from.joint->cohesion * state.point.area;
  c.tension = from.joint->tension * state.point.area;
  const bool frictionless = c.friction == 0.0 && c.cohesion == 0.0;
  const bool settles = step.options.analysis == Analysis::Settle;
  if (from.was_closed) {
    c.mode = settles ? ContactMode::Stick : frictionless ? ContactMode::Slip : state.mode;
    c.compression = state.normal_force;
    const Vector3 on_i = face_on_a ? Vector3(-state.shear_force) : state.shear_force;
    c.direction = -on_i.stableNormalized();
  }
  return c;
}

PaperOptions paper_options(const StepSetting& step, double penalty,
                           std::span<const BodyContact> contacts) {
  PaperOptions result;
  result.normal_stiffness = penalty;
  result.shear_stiffness = step.options.shear_ratio * penalty;
  result.multipliers = step.options.method == ContactMethod::Paper;
  result.sliding = step.options.analysis != Analysis::Settle;
  result.tolerance = step.options.tolerance;
  for (const BodyContact& c : contacts) {
    const ContactGeometry now = contact_geometry(c, step.start[index(c.a)], step.start[index(c.b)]);
    result.rounding = std::max(result.rounding, now.rounding());
  }
  result.max_solves = step.options.max_iterations;
  return result;
}

/// Force on block i at its contact point, N: out of the face, and against sliding.
Vector3 force_on_i(const PaperContact& c, double shear_stiffness) {
  if (c.mode == ContactMode::Open) return Vector3::Zero();
  const Vector3 push = c.compression * c.normal.normal;
  if (c.mode == ContactMode::Stick) return push - shear_stiffness * c.slide;
  return push - c.friction * std::max(c.compression, 0.0) * c.direction;
}

/// Where the energy goes at one contact: into its springs, into friction, or it is lost.
void account_contact(const PaperContact& c, const PaperOptions& options, bool was_stuck,
                     Attempt& attempt) {
  const Vector3& n = c.normal.normal;
  const Vector3 force = force_on_i(c, options.shear_stiffness);
  attempt.energy.load_work -= force.dot(c.driven);
  const double gap_start = n.dot(c.normal.between - c.driven);
  const double normal_loss = -n.dot(force) * (c.gap - gap_start);
  if (options.multipliers) {
    attempt.energy.contact_work -= normal_loss;
  } else {
    const auto stored = [&](double gap) {
      return 0.5 * options.normal_stiffness * std::pow(std::min(gap, 0.0), 2);
    };
    const double end = c.mode == ContactMode::Open ? 0.0 : stored(c.gap);
    attempt.energy.stored.front() += end;
    attempt.energy.scheme_loss += stored(gap_start) - end + normal_loss;
  }
  const Vector3 between_start = c.shear.between - c.driven;
  const Vector3 slide_start = between_start - n.dot(between_start) * n;
  const Vector3 shear = force - n.dot(force) * n;
  const double q = 0.5 * options.shear_stiffness;
  const double start = was_stuck ? q * slide_start.squaredNorm() : 0.0;
  const double end = c.mode == ContactMode::Stick ? q * c.slide.squaredNorm() : 0.0;
  attempt.energy.stored.front() += end;
  (c.mode == ContactMode::Slip ? attempt.energy.friction_work : attempt.energy.scheme_loss) +=
      start - end - shear.dot(c.slide - slide_start);
}

/// Work of loads, gravity and the time scheme, and the static measure of unbalance.
void account_blocks(const StepSetting& step, Attempt& attempt) {
  const Vector3 gravity = step.compiled.scene.gravity.at(step.load_time());
  double largest = 0.0, unbalanced = 0.0;
  for (const int b : step.compiled.slots.block_of_slot) {
    const BlockModel& model = step.compiled.models[index(b)];
    const Vector12& d = step.increment[index(b)];
    attempt.energy.gravity_work += model.mass * gravity.dot(d.head<3>());
    if (!step.dynamic())
      attempt.energy.scheme_loss += static_loss(model, step.state(b), d, step.time_step());
    if (model.unknowns == 12) {
      const Vector6 e = d.tail<6>();
      attempt.energy.scheme_loss += 0.5 * model.volume * e.dot(model.elasticity * e);
    }
    const double factor = 2.0 / (step.time_step() * step.time_step());
    unbalanced = std::max({unbalanced, factor * model.mass * d.head<3>().norm(),
                           factor * (model.inertia * d.segment<3>(3)).norm() / model.size});
    largest = std::max(largest, model.mass * gravity.norm());
    const double moved = d.head<3>().norm() + 0.5 * model.size * d.segment<3>(3).norm();
    attempt.displacement = std::max(attempt.displacement, moved / model.size);
  }
  for (const PointForce& load : step.compiled.loads) {
    const Vector3 force = load.at(step.start[index(load.block)], step.load_time());
    attempt.energy.load_work +=
        force.dot(step.point_motion(load.block, load.arm) * step.increment[index(load.block)]);
    largest = std::max(largest, force.norm());
  }
  if (!(largest > 0.0)) largest = unbalanced;  // nothing holds it or drives it on
  attempt.unbalance = largest > 0.0 ? unbalanced / largest : 0.0;
}

/// Springs of held points.
void account_held(const StepSetting& step, double penalty, Attempt& attempt) {
  attempt.held_forces.clear();
  const double end = step.end_time();
  for (std::size_t h = 0; h < step.compiled.held.size(); ++h) {
    const HeldPoint& held = step.compiled.held[h];
    const Vector3 now = step.moved(held);
    const Vector3 before = now - held.displacement.at(step.sub_step.time);
    const Vector3 moved =
        step.point_motion(held.block, held.arm) * step.increment[index(held.block)];
    const Vector3 after = now + moved - held.displacement.at(end);
    attempt.held_forces.push_back(-penalty * after);
    const double kept = 0.5 * penalty * after.squaredNorm();
    attempt.energy.stored.front() += kept;
    // The hand that moves the point does the rest of the work.
    const Vector3 driven = held.displacement.at(end) - held.displacement.at(step.sub_step.time);
    attempt.energy.load_work -= penalty * after.dot(driven);
    attempt.energy.scheme_loss += 0.5 * penalty * before.squaredNorm() - kept +
                                  penalty * after.dot(moved) - penalty * after.dot(driven);
  }
}

BlockState end_state(const StepSetting& step, int block) {
  const Vector12& d = step.increment[index(block)];
  BlockState end = displaced(step.state(block), d);
  if (step.dynamic()) return with_end_velocity(end, step.state(block), d, step.time_step());
  end.velocity = end.angular_velocity = Vector3::Zero();
  end.strain_rate.setZero();
  return end;
}

/// Forces, modes and anchors at the end of the step. A contact that slid has its anchors where it
/// is.
void record_contact(const PaperContact& c, double shear_stiffness, std::span<const BlockState> end,
                    const BodyContact& contact, Contact& state) {
  const Pose a = pose(end[index(contact.a)]), b = pose(end[index(contact.b)]);
  const ContactGeometry now = contact_geometry(contact, a, b);
  const Vector3 force = force_on_i(c, shear_stiffness);
  const Vector3 shear = force - force.dot(c.normal.normal) * c.normal.normal;
  const bool broke =
      c.mode == ContactMode::Slip || (c.mode == ContactMode::Open && contact.was_closed);
  state.failed = state.failed || (broke && (c.cohesion > 0.0 || c.tension > 0.0));
  state.mode = c.mode;
  state.impact = false;
  state.normal_force = c.mode == ContactMode::Open ? 0.0 : c.compression;
  state.shear_force = contact.normal_on_a ? Vector3(-shear) : shear;
  state.point.point_a = a.centroid + now.place_a;
  state.point.point_b = a.centroid + now.place_b;
  state.point.normal = now.normal;
  state.point.gap = now.gap;
  if (c.mode == ContactMode::Open) state.slip = 0.0;
  if (c.mode != ContactMode::Slip) return;
  const Vector3& n = c.normal.normal;
  const Vector3 start = c.shear.between - n.dot(c.shear.between) * n;
  state.slip += (c.slide - start).norm();
  const Vector3 normal_part = now.gap * now.normal;
  state.anchor_a =
      contact.normal_on_a ? reference_arm(a, now.place_b - normal_part) : contact.arm_a;
  state.anchor_b = contact.normal_on_a ? contact.arm_b
                                       : reference_arm(b, now.place_a + normal_part - now.between);
}

/// omega dt of the stiffest closed contact, its blocks alone.
double stiffest_omega_dt(const BlockSystem& base, std::span<const PaperContact> contacts,
                         double stiffness) {
  double largest = 0.0;
  for (const PaperContact& c : contacts) {
    if (c.mode == ContactMode::Open) continue;
    double compliance = 0.0;
    for (const auto& [slot, motion] :
         {std::pair{c.slot_i, &c.normal.motion_i}, std::pair{c.slot_j, &c.normal.motion_j}}) {
      if (slot < 0) continue;
      const Vector12 row = motion->transpose() * c.normal.normal;
      const int n = base.diagonal.width();
      Matrix12 inverse = Matrix12::Zero();
      invert_symmetric(base.diagonal[index(slot)], inverse.topLeftCorner(n, n));
      compliance += row.dot(inverse * row);
    }
    largest = std::max(largest, std::sqrt(2.0 * stiffness * compliance));
  }
  return largest;
}

}  // namespace

void PaperMethod::attempt(const SubStep& at, std::span<const BodyContact> contacts,
                          PhaseClock& clock, BlocksAtEnd& blocks, Attempt& attempt) {
  const CompiledScene& compiled = at.compiled;
  const std::vector<int>& own = compiled.slots.block_of_slot;
  const StepSetting step{compiled, at.options, at, blocks.poses.start, blocks.poses.increment};
  const double penalty = contact_spring(compiled, at.options);
  for (const int block : own) blocks.poses.increment[index(block)].setZero();
  assemble_blocks(step, penalty, base_, force_);
  std::vector<PaperContact> solved;
  for (const BodyContact& contact : contacts) solved.push_back(paper_contact(step, contact));
  set_pairs(std::span(solved), &PaperContact::slot_i, &PaperContact::slot_j, base_.pairs);
  const PaperOptions tuning = paper_options(step, penalty, contacts);
  clock.charge(&PhaseSeconds::assemble);
  BlockVector increment(own.size(), Vector12::Zero());
  attempt = {};
  attempt.energy.stored.assign(own.size(), 0.0);  // all of it at the first: there is one island
  attempt.solved = open_close_.solve(base_, force_, solved, tuning, increment);
  clock.charge(&PhaseSeconds::solve);
  for (std::size_t s = 0; s < own.size(); ++s) {
    blocks.poses.increment[index(own[s])] = increment[s];
    blocks.end[index(own[s])] = end_state(step, own[s]);
  }
  account_blocks(step, attempt);
  account_held(step, penalty, attempt);
  for (std::size_t i = 0; i < solved.size(); ++i) {
    const BodyContact& before = contacts[i];
    account_contact(solved[i], tuning, before.was_closed && before.state.mode == ContactMode::Stick,
                    attempt);
    record_contact(solved[i], tuning.shear_stiffness, blocks.end, before,
                   attempt.contacts.emplace_back(before.state));
  }
  if (at.options.method == ContactMethod::Penalty)
    attempt.stiffest_omega_dt = stiffest_omega_dt(base_, solved, penalty);
}

}  // namespace quoin::solver
