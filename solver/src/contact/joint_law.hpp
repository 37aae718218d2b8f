#pragma once
/// The law of a joint: strength, opening, force, tangent, work. Failure is in joint_failure.hpp.
///
/// At one contact, with slip s so far and softening slip L,
///   damage     1 once it has failed, else s / L (0 where the joint is brittle: L = 0)
///   strength   peak + damage (residual - peak), for tan(friction angle), cohesion and tension
///   opening    gap at which it is closed: the gap it was laid with (a bond's while it holds), the
///              offset of its spring (joint_springs.hpp), and tan(dilation angle) min(s, dilation
///              slip)
/// and, f on the contact (compression positive), d its gap beyond the opening and its two slips,
///   f_n >= 0 (bonded: any),   f_n = -normal_spring d_n (rigid: d_n = 0) where f_n is not at that
///   limit, |f_t| <= friction max(f_n, 0) + cohesion,   f_t against d_t at the limit.
/// Friction needs compression; in tension, and where blocks touch unpressed, cohesion alone bears
/// shear.

#include <utility>

#include "contact/linear_contact.hpp"

namespace quoin::solver {

/// A brittle joint that has not failed does not slide, wherever a corner's share of its strength is
/// exceeded: its area decides (joint_failure.hpp).
bool bonded_in_shear(const Joint& joint, const Contact& contact);

/// Whether peak and residual strength differ, or it bears tension.
bool can_fail(const Joint& joint);

/// What a contact bears.
struct JointStrength {
  double friction = 0.0;  ///< tan of the friction angle
  double cohesion = 0.0;  ///< Pa
  double tension = 0.0;   ///< Pa
};

/// As it stands; `further_slip` (m): the mean over that much more sliding, whose work is then
/// exact.
JointStrength strength(const Joint& joint, const Contact& contact, double further_slip = 0.0);

/// Gap at which the contact is closed after `further_slip` more sliding, m.
double opening(const Joint& joint, const Contact& contact, double further_slip = 0.0);

/// Opening per slip as it stands.
double dilation_slope(const Joint& joint, const Contact& contact);

/// Further opening in the step that goes with this slip, m, where it slides.
double dilation(const LinearContact& contact, double slip);

/// Takes off its gap what that is, by the slip that d says, beyond its linearisation.
void open_by_slip(LinearContact& contact);

/// Whether it bears shear while it touches, pressed or not. Were its shear gone as its normal force
/// gets to zero, the law would jump there, and a step in which a corner just lifts had no solution:
/// what has opened is found when the step is solved (joint_failure.hpp).
bool clings(const Joint& joint, const Contact& contact);

/// Whether it is a tie or a dashpot: its stiffness is its own, and never an augmentation.
bool is_link(const LinearContact& contact);

/// Whether it clings, and nothing presses it: no force and no condition along its normal.
bool unpressed(const LinearContact& contact);

/// A contact of the first step: what has strength is closed, and a bond where it has tension, at
/// the gap it is laid with. `size`: of the smaller block, m.
void lay(const Joint& joint, double size, Contact& contact);

/// Its bond, if it has one, is gone.
void part(Contact& contact);

/// Whether `further_slip` (m) is the last that a joint that softens takes before it has failed.
bool wears_off(const Joint& joint, const Contact& contact, double further_slip);

/// Residual strength from now on; one that had failed parts for good.
void weaken(const Joint& joint, Contact& contact);

/// Projects the trial force `multiplier - softness × stiffness × d` on what the contact bears; sets
/// force and mode.   [Alart & Curnier 1991]
void apply_law(double softness, LinearContact& contact);

/// The law of the assumed mode, whether or not its conditions hold.
void apply_assumed(double softness, LinearContact& contact);

/// The force if the one it has now became its multiplier.
Vector3 force_after_update(const LinearContact& contact);
double change_of_update(const LinearContact& contact);  ///< how far that is from it, N

/// How the tangent of a contact is taken.
struct TangentOptions {
  bool assumed = false;
  double softness = 1.0;
  double negligible = 0.0;  ///< N: no friction below
};

/// -df/dd: what the contact adds to the stiffness. A sliding contact's friction follows its normal
/// force: unsymmetric.
Matrix3 tangent(const LinearContact& contact, const TangentOptions& options);

/// Share of the stretch b/k that its force b holds which a sliding contact leaves its shear spring;
/// `moved`: J D. All of it, but no more than there is: by a time scheme whose force is that of the
/// middle of the step, a contact whose normal force falls slides on a stretch that ends, at s',
/// below what that force holds. With less than either friction would make energy: from s on,
///   work - change stored = k/2 [(b/T) |s'|^2 + (1 - b/T) |s|^2 - |left|^2],  T = k |s + s'|/2 > b,
/// is not negative where |left| = min(b/k, |s'|).
double stretch_kept(const LinearContact& contact, const Vector3& moved);

/// Slip of a solved contact in the step, m; `moved`: J D.
double slip_in_step(const LinearContact& contact, const Vector3& moved);

/// Where the work of a contact goes in a step, J.
struct ContactWork {
  double stored = 0.0;   ///< in its springs at the end of the step
  double heat = 0.0;     ///< friction, cohesion, broken bonds, less what dilation lifts
  double impulse = 0.0;  ///< on the blocks, by normal forces that no spring stores
  double scheme = 0.0;   ///< lost to the time scheme
};
ContactWork contact_work(const LinearContact& contact, const Vector3& moved);

}  // namespace quoin::solver
