#pragma once
/// One contact of a linearised step: what contact_jacobian makes and open_close works on.

#include <quoin/solver/state.hpp>

#include "displacement.hpp"

namespace quoin::solver {

enum class ContactLaw : std::uint8_t {
  Coulomb,
  Frictionless,
  Stuck,     ///< closed contacts cannot slide
  Bilateral  ///< a held point: all three components vanish
};

/// One contact after linearisation. Rows of d: gap beyond the joint's opening, two slips.
struct LinearContact {
  int slot_a = -1, slot_b = -1;  ///< -1: that side has no unknowns
  int pair = -1;                 ///< off-diagonal block of (slot_a, slot_b), -1: none
  ContactLaw law = ContactLaw::Coulomb;
  bool compliant = false;   ///< a spring: its multiplier stays zero
  bool bonded = false;      ///< bears tension without limit: judged when the step is solved
  bool was_bonded = false;  ///< at the start of the step
  bool was_closed = false;  ///< likewise
  Matrix3x12 jacobian_a = Matrix3x12::Zero(), jacobian_b = Matrix3x12::Zero();
  Vector3 offset = Vector3::Zero();
  double friction = 0.0;          ///< tan of the friction angle
  double cohesion = 0.0;          ///< N
  double normal_stiffness = 0.0;  ///< N/m: spring, or augmentation
  double shear_stiffness = 0.0;
  double normal_spring = 0.0;  ///< N/m, of the joint; 0: rigid
  double shear_spring = 0.0;
  double slip = 0.0;      ///< in this step, by the last solution, m
  double dilation = 0.0;  ///< further opening in this step that goes with it, m
  Vector3 start =
      Vector3::Zero();    ///< d at the start of the step: gap and stretch of the anchors, m
  double rounding = 0.0;  ///< m: a gap or slip this small is zero for all that doubles can tell
  double turn_correction = 0.0;  ///< m: the turn of crossed edges' normal beyond second order
  double closing_share = 0.0;  ///< of the step that had passed when it closed; 0: closed all along
  double closing_speed = 0.0;  ///< mean until then, m in a step
  Vector3 multiplier = Vector3::Zero();  ///< N, what the last iteration took as known

  ContactMode assumed = ContactMode::Open;  ///< what the first linear solve takes for granted

  Vector3 guess = Vector3::Zero();       ///< d of the first guess, m
  Vector3 relative = Vector3::Zero();    ///< result: d, m
  Vector3 force = Vector3::Zero();       ///< result: f, N
  double bound = 0.0;                    ///< result: friction limit, N
  ContactMode mode = ContactMode::Open;  ///< result
};

}  // namespace quoin::solver
