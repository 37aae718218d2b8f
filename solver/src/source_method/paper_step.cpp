#include "source_method/paper_step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/index.hpp"
#include "linear/small_matrices.hpp"
#include "step/energy_ledger.hpp"

namespace quoin::solver {
namespace {

/// P0'P1', m.
Vector3 between_after(const PointToFace& contact, const Vector12& d_i, const Vector12& d_j) {
  return contact.between + contact.motion_i * d_i - contact.motion_j * d_j;
}

/// Normal spring with multiplier, energy lambda d_n + Pn d_n²/2 (29): equations (31)–(41).
/// stiffness: Pn, N/m; multiplier: lambda, N, negative in compression.
ContactBlocks normal_blocks(const PointToFace& contact, double stiffness, double multiplier) {
  const Vector12 h = contact.motion_i.transpose() * contact.normal;  // (26)
  const Vector12 q = contact.motion_j.transpose() * contact.normal;  // (27)
  const double gap = contact.normal.dot(contact.between);            // (25)
  ContactBlocks blocks;
  blocks.ii = stiffness * h * h.transpose();
  blocks.ij = -stiffness * h * q.transpose();
  blocks.jj = stiffness * q * q.transpose();
  blocks.force.i = -(multiplier + stiffness * gap) * h;
  blocks.force.j = (multiplier + stiffness * gap) * q;
  return blocks;
}

/// Force of the normal spring's multiplier alone, the part of (39), (41) that an update changes.
ContactForces multiplier_forces(const PointToFace& contact, double multiplier) {
  const Vector3 push = multiplier * contact.normal;
  return {-contact.motion_i.transpose() * push, contact.motion_j.transpose() * push};
}

/// Shear spring, energy Ps (|P0'P1'|² - d_n²)/2 (43): equations (47), (48). stiffness: Ps, N/m.
ContactBlocks shear_blocks(const PointToFace& contact, double stiffness) {
  const Vector3& n = contact.normal;
  const Matrix3 tangential = Matrix3::Identity() - n * n.transpose();
  const Matrix3x12 on_i = tangential * contact.motion_i, on_j = tangential * contact.motion_j;
  ContactBlocks blocks;
  blocks.ii = stiffness * contact.motion_i.transpose() * on_i;
  blocks.ij = -stiffness * contact.motion_i.transpose() * on_j;
  blocks.jj = stiffness * contact.motion_j.transpose() * on_j;
  blocks.force.i = -stiffness * on_i.transpose() * contact.between;
  blocks.force.j = stiffness * on_j.transpose() * contact.between;
  return blocks;
}

/// Friction, energy F d·L/|L| (52): equations (54)–(57). friction: F, N; direction: L/|L| or zero.
ContactForces friction_forces(const PointToFace& contact, double friction,
                              const Vector3& direction) {
  return {-friction * contact.motion_i.transpose() * direction,
          friction * contact.motion_j.transpose() * direction};
}

// Solves in which what F changes by has not fallen to this share: it is rounding, if no more than
// that. Chosen: all cells of `quoin stability` keep their digits.
constexpr int kIdle = 10;
constexpr double kResidualFalls = 0.9;

Vector12 increment_of(int slot, const BlockVector& increment) {
  return slot < 0 ? Vector12(Vector12::Zero()) : increment[index(slot)];
}

void push(const PaperContact& c, const ContactForces& forces, BlockVector& right) {
  if (c.slot_i >= 0) right[index(c.slot_i)] += forces.i;
  if (c.slot_j >= 0) right[index(c.slot_j)] += forces.j;
}

/// A closed contact without friction and cohesion has no shear spring at all.
ContactMode closed_mode(const PaperContact& c, const PaperOptions& options) {
  const bool sticks = !options.sliding || c.friction > 0.0 || c.cohesion > 0.0;
  return sticks ? ContactMode::Stick : ContactMode::Slip;
}

/// Where the increment brings the contact, and what the next iteration takes for its normal force
/// and for the direction of sliding.
void measure(const BlockVector& increment, const PaperOptions& options, PaperContact& c) {
  const Vector12 d_i = increment_of(c.slot_i, increment), d_j = increment_of(c.slot_j, increment);
  const Vector3& n = c.normal.normal;
  c.gap = n.dot(between_after(c.normal, d_i, d_j));
  const Vector3 between = between_after(c.shear, d_i, d_j);
  c.slide = between - n.dot(between) * n;  // (51)
  if (c.mode == ContactMode::Open) return;
  c.compression = -(c.multiplier + options.normal_stiffness * c.gap);
  const bool onward = c.direction.isZero(0.0) || c.slide.dot(c.direction) > 0.0;
  if (c.mode == ContactMode::Slip && onward) c.direction = c.slide.stableNormalized();
}

/// (49): the shear spring is beyond the strength that the normal force `compression` gives.
bool slides(const PaperContact& c, const PaperOptions& options, double compression,
            double force_tolerance) {
  const double strength = std::max(compression, 0.0) * c.friction + c.cohesion;
  return options.shear_stiffness * c.slide.norm() > strength + force_tolerance;
}

/// An open contact that overlaps closes, and slides at once where the springs of its overlap and of
/// its slide say so: a block set in motion on a rough plane would first be held and tipped over.
/// One with cohesion sticks until its own shear spring is beyond that: the slide of a block that
/// nothing holds yet would break it.
ContactMode mode_after_open(const PaperContact& c, const PaperOptions& options,
                            double force_tolerance) {
  if (!(c.gap < -options.rounding)) return ContactMode::Open;
  const ContactMode closed = closed_mode(c, options);
  if (closed == ContactMode::Slip || !options.sliding || c.cohesion > 0.0) return closed;
  const double compression = -options.normal_stiffness * c.gap;
  return slides(c, options, compression, force_tolerance) ? ContactMode::Slip : ContactMode::Stick;
}

/// The mode that the result asks for; `force_tolerance`: N, no force is known better.
ContactMode next_mode(const PaperContact& c, const PaperOptions& options, double force_tolerance) {
  if (c.mode == ContactMode::Open) return mode_after_open(c, options, force_tolerance);
  if (c.compression < -c.tension - force_tolerance) return ContactMode::Open;
  if (!options.sliding || closed_mode(c, options) == ContactMode::Slip) return c.mode;
  if (c.mode == ContactMode::Slip)
    return c.slide.dot(c.direction) < 0.0 ? ContactMode::Stick : ContactMode::Slip;
  return slides(c, options, c.compression, force_tolerance) ? ContactMode::Slip
                                                            : ContactMode::Stick;
}

double largest_compression(std::span<const PaperContact> contacts) {
  double largest = 0.0;
  for (const PaperContact& c : contacts)
    if (c.mode != ContactMode::Open) largest = std::max(largest, std::abs(c.compression));
  return largest;
}

/// Tol1, N: a share of the largest normal force, and no less than what rounding makes of a gap.
double force_tolerance(std::span<const PaperContact> contacts, const PaperOptions& options) {
  return std::max(options.tolerance * largest_compression(contacts),
                  options.normal_stiffness * options.rounding);
}

/// What rounding of gaps makes of F, N: of each contact, and of all by chance. Below it F changes
/// for ever, and falls no more.
double rounding_of_right(std::span<const PaperContact> contacts, const PaperOptions& options) {
  return options.normal_stiffness * options.rounding *
         std::sqrt(static_cast<double>(contacts.size()));
}

/// Step 18: true when no contact changes its mode.
bool switch_modes(std::span<PaperContact> contacts, const PaperOptions& options) {
  const double tolerance = force_tolerance(contacts, options);
  bool same = true;
  for (PaperContact& c : contacts) {
    const ContactMode next = next_mode(c, options, tolerance);
    if (next == c.mode) continue;
    same = false;
    if (next == ContactMode::Slip) c.direction = c.slide.stableNormalized();
    if (next == ContactMode::Open) c.compression = 0.0;
    c.mode = next;
  }
  return same;
}

}  // namespace

void PaperOpenClose::add(const PaperContact& c, const ContactBlocks& blocks) {
  push(c, blocks.force, constant_);
  const int n = system_.diagonal.width();
  if (c.slot_i >= 0) system_.diagonal[index(c.slot_i)] += blocks.ii.topLeftCorner(n, n);
  if (c.slot_j >= 0) system_.diagonal[index(c.slot_j)] += blocks.jj.topLeftCorner(n, n);
  if (c.pair < 0) return;
  const auto ij = blocks.ij.topLeftCorner(n, n);
  auto upper = system_.off_diagonal[index(c.pair)];
  c.slot_i < c.slot_j ? upper += ij : upper += ij.transpose();
}

/// K and the part of F that stays while no contact changes its mode.
void PaperOpenClose::assemble(const BlockSystem& base, const BlockVector& force,
                              std::span<const PaperContact> contacts, const PaperOptions& options) {
  system_.diagonal = base.diagonal;
  system_.pairs = base.pairs;
  system_.off_diagonal.resize(base.pairs.size(), base.diagonal.width());
  system_.off_diagonal.set_zero();
  constant_ = force;
  for (const PaperContact& c : contacts) {
    if (c.mode == ContactMode::Open) continue;
    add(c, normal_blocks(c.normal, options.normal_stiffness, 0.0));
    if (c.mode == ContactMode::Stick) add(c, shear_blocks(c.shear, options.shear_stiffness));
  }
}

void PaperOpenClose::set_right(std::span<const PaperContact> contacts) {
  right_ = constant_;
  for (const PaperContact& c : contacts) {
    if (c.mode == ContactMode::Open) continue;
    push(c, multiplier_forces(c.normal, c.multiplier), right_);
    if (c.mode != ContactMode::Slip) continue;
    const double friction = c.friction * std::max(c.compression, 0.0);  // (50)
    push(c, friction_forces(c.shear, friction, c.direction), right_);
  }
}

/// Of (58): K stays, and K D is F.
PaperOpenClose::Change PaperOpenClose::change_of_right() const {
  double change = 0.0, size = 0.0;
  for (std::size_t s = 0; s < right_.size(); ++s) {
    change += (right_[s] - last_[s]).squaredNorm();
    size += last_[s].squaredNorm();
  }
  return {std::sqrt(change), std::sqrt(size)};
}

/// K D = F, and once more with what that leaves: K is stiff (springs of 5e10 N/m beside the inertia
/// of a block), and its rounding in D would come back in every step.   [Skeel 1980]
void PaperOpenClose::solve_refined(BlockVector& increment) {
  solver_.solve(right_, increment);
  rest_ = right_;
  for (std::size_t s = 0; s < rest_.size(); ++s)
    rest_[s] -= system_.diagonal.times(s, increment[s]);
  for (std::size_t k = 0; k < system_.pairs.size(); ++k) {
    const std::size_t i = index(system_.pairs[k].first), j = index(system_.pairs[k].second);
    rest_[i] -= system_.off_diagonal.times(k, increment[j]);
    rest_[j] -= system_.off_diagonal.times(k, increment[i], true);
  }
  correction_.resize(rest_.size());
  solver_.solve(rest_, correction_);
  for (std::size_t s = 0; s < rest_.size(); ++s) increment[s] += correction_[s];
}

/// Steps 10–17, contacts keep their modes. False when it does not end within the solves that are
/// left.
bool PaperOpenClose::augment(std::span<PaperContact> contacts, const PaperOptions& options,
                             BlockVector& increment, OpenCloseResult& result) {
  for (PaperContact& c : contacts) c.multiplier = 0.0;
  set_right(contacts);
  double least = std::numeric_limits<double>::infinity();  // that F changed by in a solve, N
  int idle = 0;                                            // solves since that fell
  while (result.solves < options.max_solves) {
    if (watch_ != nullptr) watch_->look();
    solve_refined(increment);
    ++result.solves;
    double update = 0.0;  // of the multipliers, N
    for (PaperContact& c : contacts) {
      measure(increment, options, c);
      if (c.mode == ContactMode::Open || !options.multipliers) continue;
      const double change = options.normal_stiffness * c.gap;
      update = std::max(update, std::abs(change));
      c.multiplier += change;  // (10)
    }
    std::swap(right_, last_);
    set_right(contacts);
    const auto [change, size] =
        change_of_right();  // K D of the next iteration, before it is solved
    result.residual = size > 0.0 ? change / size : 0.0;
    if (!std::isfinite(result.residual)) return false;
    idle = change < kResidualFalls * least ? 0 : idle + 1;
    least = std::min(least, change);
    const bool rounds = idle >= kIdle && change <= rounding_of_right(contacts, options);
    const bool agrees = rounds || result.residual <= options.tolerance;
    if (agrees && update <= force_tolerance(contacts, options)) return true;
  }
  return false;
}

OpenCloseResult PaperOpenClose::solve(const BlockSystem& base, const BlockVector& force,
                                      std::span<PaperContact> contacts, const PaperOptions& options,
                                      BlockVector& increment) {
  OpenCloseResult result;
  while (result.solves < options.max_solves) {
    ++result.iterations;
    assemble(base, force, contacts, options);
    ++result.factorizations;
    if (!solver_.factorize(system_)) break;
    if (!augment(contacts, options, increment, result)) break;
    if (switch_modes(contacts, options)) {
      result.converged = true;
      break;
    }
  }
  result.condition = solver_.condition_estimate();
  return result;
}

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
