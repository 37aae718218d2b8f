#pragma once
/// One attempt at one (sub-)step: equilibrium of positions, then the velocity law.

#include "advance.hpp"

namespace quoin::solver {

/// What an attempt came to. `end` is the state it proposes.
struct Attempt {
  State end;
  std::vector<BodyContact> contacts;  ///< work.contacts with forces and modes at the end of the step
  std::vector<PrescribedMotion> motion;
  OpenCloseResult solved;
  double displacement = 0.0;   ///< largest of a vertex, relative to its block's size
  double friction_work = 0.0;  ///< J, >= 0
  double contact_work = 0.0;   ///< by normal forces that no spring stores, J
  double load_work = 0.0;      ///< by loads and prescribed motion, J
  double gravity_work = 0.0;   ///< J
  double scheme_loss = 0.0;    ///< J
  double spring_energy = 0.0;  ///< in penalty contacts at the end of the step, J
  double impact_loss = 0.0;    ///< J
  double unbalance = 0.0;
  double stiffest_omega_dt = 0.0;
};

/// Solves for the increments of [time, time + dt] with contacts work.contacts.
Attempt attempt_step(const CompiledScene& compiled, const StepOptions& options, const State& state,
                     double time_step, Workspace& work);

/// Velocities at the end of the step: restitution at closing contacts, rest at sticking ones.
/// [Moreau 1988]; the impulses replace the contact forces of the step, so that momentum is kept.
void apply_velocity_law(const CompiledScene& compiled, const StepOptions& options,
                        const State& start, double time_step, Workspace& work, Attempt& attempt);

/// What the rounding of coordinates makes of a gap: 4 eps of the largest coordinate, m.
double coordinate_rounding(const CompiledScene& compiled, const State& state);

/// Spring of a penalty contact when the user gives none, N/m.
double default_penalty(const CompiledScene& compiled);

}  // namespace quoin::solver
