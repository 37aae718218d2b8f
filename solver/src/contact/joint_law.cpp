#include "contact/joint_law.hpp"

#include <algorithm>
#include <cmath>

namespace quoin::solver {
namespace {

/// Of the smaller block: blocks laid no farther apart are bonded. It is the least reach of a
/// search.
constexpr double kLaidGap = 1e-4;

bool loses_friction(const Joint& joint) {
  return joint.residual_friction_angle >= 0.0 &&
         joint.residual_friction_angle != joint.friction_angle;
}

double damage(const Joint& joint, const Contact& contact) {
  if (contact.failed) return 1.0;
  return joint.softening_slip > 0.0 ? std::min(1.0, contact.slip / joint.softening_slip) : 0.0;
}

/// Mean of the damage while the slip grows by `further`.
double mean_damage(const Joint& joint, const Contact& contact, double further) {
  const double now = damage(joint, contact);
  if (now == 1.0 || !(joint.softening_slip > 0.0) || !(further > 0.0)) return now;
  const double rising = std::min(further, joint.softening_slip - contact.slip);
  const double end = now + rising / joint.softening_slip;
  return (0.5 * (now + end) * rising + (further - rising)) / further;
}

/// Softer contacts are augmentations, whose multipliers make up for it. Ties and dashpots are not.
double softness_of(const LinearContact& c, double softness) { return is_link(c) ? 1.0 : softness; }

Vector3 trial_force(const LinearContact& c, const Vector3& multiplier, double all) {
  const double softness = softness_of(c, all);
  const double normal = softness * c.normal_stiffness, shear = softness * c.shear_stiffness;
  return {multiplier[0] - normal * c.relative[0], multiplier[1] - shear * c.relative[1],
          multiplier[2] - shear * c.relative[2]};
}

/// What pulls a bond takes off its shear.
double friction_limit(const LinearContact& c, double normal_force) {
  const double presses = c.bonded ? normal_force : std::max(normal_force, 0.0);
  return std::max(c.friction * presses + c.cohesion, 0.0);
}

/// Direction of the friction that a sliding contact had, or zero.
Eigen::Vector2d known_direction(const LinearContact& c) {
  const double size = c.multiplier.tail<2>().norm();
  return size > 0.0 ? Eigen::Vector2d(c.multiplier.tail<2>() / size) : Eigen::Vector2d::Zero();
}

double spring_energy(double stiffness, double squared_stretch) {
  return 0.5 * stiffness * squared_stretch;
}

double squared_normal_stretch(double gap, bool bonded) {
  const double stretch = bonded ? gap : std::min(gap, 0.0);
  return stretch * stretch;
}

}  // namespace

bool bonded_in_shear(const Joint& joint, const Contact& contact) {
  const bool brittle = joint.softening_slip == 0.0 && !contact.failed;
  return brittle &&
         (std::max(joint.cohesion, joint.residual_cohesion) > 0.0 || loses_friction(joint));
}

bool can_fail(const Joint& joint) {
  return std::max({joint.cohesion, joint.residual_cohesion, joint.tension}) > 0.0 ||
         loses_friction(joint);
}

JointStrength strength(const Joint& joint, const Contact& contact, double further_slip) {
  const double share = mean_damage(joint, contact, further_slip);
  const double friction = std::tan(joint.friction_angle);
  if (share == 0.0) return {friction, joint.cohesion, joint.tension};
  const double residual =
      loses_friction(joint) ? std::tan(joint.residual_friction_angle) : friction;
  const auto mix = [share](double peak, double low) { return peak + share * (low - peak); };
  return {mix(friction, residual), mix(joint.cohesion, joint.residual_cohesion),
          mix(joint.tension, joint.residual_tension)};
}

double opening(const Joint& joint, const Contact& contact, double further_slip) {
  const double offset = contact.spring_offset;
  const double closed = contact.closed_gap + (contact.bonded ? offset : std::min(offset, 0.0));
  if (joint.dilation_angle == 0.0) return closed;
  double slip = contact.slip + further_slip;
  if (joint.dilation_slip > 0.0) slip = std::min(slip, joint.dilation_slip);
  return closed + slip * std::tan(joint.dilation_angle);
}

double dilation_slope(const Joint& joint, const Contact& contact) {
  const bool done = joint.dilation_slip > 0.0 && contact.slip >= joint.dilation_slip;
  return done || joint.dilation_angle == 0.0 ? 0.0 : std::tan(joint.dilation_angle);
}

double dilation(const LinearContact& c, double slip) {
  return c.dilation_slope * std::min(slip, c.dilating_slip);
}

void open_by_slip(LinearContact& c) {
  if (c.dilation_slope == 0.0) return;
  const double slip = (c.relative.tail<2>() - c.start.tail<2>()).norm();
  c.relative[0] -= dilation(c, slip) - c.dilation;
}

bool clings(const Joint& joint, const Contact& contact) {
  const bool has_area = contact.point.area > 0.0;
  if (contact.bonded || (joint.tension > 0.0 && !has_area)) return false;
  return bonded_in_shear(joint, contact) || (strength(joint, contact).cohesion > 0.0 && has_area);
}

bool is_link(const LinearContact& c) { return c.compliant && c.law >= ContactLaw::Bilateral; }

bool unpressed(const LinearContact& c) { return c.clings && !(c.force[0] > 0.0); }

void lay(const Joint& joint, double size, Contact& contact) {
  contact.failed = !(std::abs(contact.point.gap) <= kLaidGap * size);
  if (contact.failed || !(contact.point.area > 0.0)) return;
  if (can_fail(joint)) contact.closed_gap = contact.point.gap;
  contact.bonded = joint.tension > 0.0;
  if (!contact.bonded) return;
  contact.mode = ContactMode::Stick;
}

void part(Contact& contact) {
  if (contact.bonded) contact.closed_gap = 0.0;
  contact.bonded = false;
}

bool wears_off(const Joint& joint, const Contact& contact, double further_slip) {
  return !contact.failed && joint.softening_slip > 0.0 &&
         contact.slip + further_slip >= joint.softening_slip;
}

void weaken(const Joint& joint, Contact& contact) {
  if (contact.failed || !(joint.residual_tension > 0.0)) part(contact);
  contact.failed = true;
}

void apply_assumed(double softness, LinearContact& c) {
  if (c.law == ContactLaw::Tie) return apply_law(softness, c);
  c.mode = c.law == ContactLaw::Bilateral ? ContactMode::Stick : c.assumed;
  if (c.mode == ContactMode::Open) {
    c.force.setZero();
    return;
  }
  c.force = trial_force(c, c.multiplier, softness);
  if (c.mode == ContactMode::Stick && c.law != ContactLaw::Frictionless) return;
  c.mode = ContactMode::Slip;
  if (c.law == ContactLaw::Frictionless)
    c.force.tail<2>().setZero();
  else
    c.force.tail<2>() = friction_limit(c, c.force[0]) * known_direction(c);
}

namespace {

/// Open: slack; Slip: yields.
ContactMode project_tie(const LinearContact& c, Vector3& force) {
  const double trial = force[0];
  force[0] = std::clamp(trial, c.bonded ? -c.cohesion : 0.0, c.cohesion);
  if (force[0] == trial && trial != 0.0) return ContactMode::Stick;
  if (force[0] != 0.0) return ContactMode::Slip;
  force.setZero();
  return c.bonded ? ContactMode::Stick : ContactMode::Open;
}

/// `force`: in, the trial; out, what is borne.
ContactMode project(const LinearContact& c, Vector3& force) {
  if (c.law >= ContactLaw::Bilateral)
    return c.law == ContactLaw::Tie ? project_tie(c, force) : ContactMode::Stick;
  if (!c.bonded && !(force[0] > 0.0)) {
    if (!c.clings) {
      force.setZero();
      return ContactMode::Open;
    }
    force[0] = 0.0;
  }
  if (c.law == ContactLaw::Stuck) return ContactMode::Stick;
  if (c.law == ContactLaw::Frictionless) {
    force.tail<2>().setZero();
    return ContactMode::Slip;
  }
  const double bound = friction_limit(c, force[0]);
  const double size = force.tail<2>().norm();
  if (size <= bound) return ContactMode::Stick;
  force.tail<2>() *= bound / size;
  return ContactMode::Slip;
}

}  // namespace

void apply_law(double softness, LinearContact& c) {
  c.force = trial_force(c, c.multiplier, softness);
  c.mode = project(c, c.force);
}

Vector3 force_after_update(const LinearContact& c) {
  Vector3 force = trial_force(c, c.force, 1.0);
  project(c, force);
  return force;
}

double change_of_update(const LinearContact& c) { return (force_after_update(c) - c.force).norm(); }

namespace {

/// How the opening goes with the two slips.
Eigen::Vector2d gap_by_slip(const LinearContact& c) {
  const Eigen::Vector2d slip = c.relative.tail<2>() - c.start.tail<2>();
  const double size = slip.norm();
  if (!(size > 0.0) || size > c.dilating_slip) return Eigen::Vector2d::Zero();
  return c.dilation_slope / size * slip;
}

}  // namespace

Matrix3 tangent(const LinearContact& c, const TangentOptions& options) {
  Matrix3 result = Matrix3::Zero();
  if (c.mode == ContactMode::Open) return result;
  const double softness = softness_of(c, options.softness);
  const double normal = softness * c.normal_stiffness, shear = softness * c.shear_stiffness;
  if (options.assumed || !unpressed(c)) result(0, 0) = normal;
  if (c.law == ContactLaw::Frictionless) return result;
  if (c.mode == ContactMode::Stick) {
    result(1, 1) = result(2, 2) = shear;
    return result;
  }
  if (c.law == ContactLaw::Tie) return Vector3(0.0, shear, shear).asDiagonal();
  const bool follows =
      c.force[0] > options.negligible || (c.bonded && friction_limit(c, c.force[0]) > 0.0);
  if (options.assumed) {
    if (follows) result.bottomLeftCorner<2, 1>() = c.friction * normal * known_direction(c);
    return result;
  }
  const Eigen::Vector2d trial = trial_force(c, c.multiplier, options.softness).tail<2>();
  const double size = trial.norm();
  if (!(size > 0.0)) return result;
  const Eigen::Vector2d along = trial / size;
  result.topRightCorner<1, 2>() = -result(0, 0) * gap_by_slip(c).transpose();
  result.bottomRightCorner<2, 2>() = (shear * friction_limit(c, c.force[0]) / size) *
                                     (Eigen::Matrix2d::Identity() - along * along.transpose());
  if (!follows) return result;
  result.bottomLeftCorner<2, 1>() = c.friction * normal * along;
  result.bottomRightCorner<2, 2>() += c.friction * along * result.topRightCorner<1, 2>();
  return result;
}

double stretch_kept(const LinearContact& c, const Vector3& moved) {
  const bool of_middle = c.shear_stiffness < c.shear_spring;  // else it ends beyond what is held
  const double held = c.force.tail<2>().norm() / c.shear_spring;
  const double end = (c.start + moved).tail<2>().norm();
  return of_middle && end < held ? end / held : 1.0;
}

double slip_in_step(const LinearContact& c, const Vector3& moved) {
  if (c.mode != ContactMode::Slip) return 0.0;
  if (!c.compliant) return (c.relative.tail<2>() - c.start.tail<2>()).norm();
  if (!(c.shear_spring > 0.0)) return moved.tail<2>().norm();
  const double stretch = stretch_kept(c, moved) * c.force.tail<2>().norm() / c.shear_spring;
  return std::max(0.0, (c.start + moved).tail<2>().norm() - stretch);
}

ContactWork contact_work(const LinearContact& c, const Vector3& moved) {
  ContactWork work;
  const double rubbed = -c.force.tail<2>().dot(moved.tail<2>());
  const double lifted = c.force[0] * c.dilation;
  if (!c.compliant) {
    const bool impact = c.closing_share > 0.0;  // its force stands for an impulse
    work.impulse = impact ? c.force.dot(moved) : c.force[0] * moved[0] - lifted;
    if (!impact) work.heat = rubbed - lifted;
    return work;
  }
  const Vector3 end = c.start + moved;
  double end_stretch = 0.0;
  if (c.mode == ContactMode::Stick) end_stretch = end.tail<2>().squaredNorm();
  if (c.mode == ContactMode::Slip && c.shear_spring > 0.0) {
    const double kept = stretch_kept(c, moved);
    end_stretch = kept * kept * c.force.tail<2>().squaredNorm() / (c.shear_spring * c.shear_spring);
  }
  const double start_stretch = c.was_closed ? c.start.tail<2>().squaredNorm() : 0.0;
  const double normal_start = squared_normal_stretch(c.start[0], c.was_bonded);
  const double normal_end = squared_normal_stretch(end[0] - c.dilation, c.bonded);
  const double shear_change =
      spring_energy(c.shear_spring, end_stretch) - spring_energy(c.shear_spring, start_stretch);
  work.stored =
      spring_energy(c.normal_spring, normal_end) + spring_energy(c.shear_spring, end_stretch);
  const double lost = -c.force.dot(moved) - shear_change -
                      spring_energy(c.normal_spring, normal_end - normal_start);
  if (c.mode == ContactMode::Slip) work.heat = rubbed - shear_change - lifted;
  if (c.was_bonded && !c.bonded && c.start[0] > 0.0)
    work.heat += spring_energy(c.normal_spring, normal_start);
  work.scheme = lost - work.heat;
  return work;
}

}  // namespace quoin::solver
