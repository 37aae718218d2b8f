#pragma once
/// Where the energy of a sub-step goes.

#include "contact/contact_jacobian.hpp"
#include "step/sub_step.hpp"

namespace quoin::solver {

/// Of an island in a sub-step, J.
struct StepEnergy {
  double friction_work = 0.0;  ///< >= 0
  double contact_work = 0.0;   ///< by normal forces that no spring stores
  double load_work = 0.0;      ///< by loads and prescribed motion
  double gravity_work = 0.0;
  double scheme_loss = 0.0;
  std::vector<double> stored;  ///< in springs of contacts at the end of the step, by the slot of
                               ///< the first block of each contact that has one
  double impact_loss = 0.0;
  std::vector<double> work_on;  ///< by slot: of gravity, loads and prescribed neighbours

  /// All zero, for so many slots.
  void clear(std::size_t slots) {
    friction_work = contact_work = load_work = gravity_work = scheme_loss = impact_loss = 0.0;
    stored.assign(slots, 0.0);
    work_on.assign(slots, 0.0);
  }
};

/// Work and losses of the solved positions. `linear`: contacts, then held points, ties, and quiet
/// points. `ties`: of the island, as they end. `energy`: its memory is reused.
void account(const SubStep& step, const StepPoses& poses, std::span<const BodyContact> contacts,
             std::span<const LinearContact> linear, std::span<const TieState> ties,
             StepEnergy& energy);

/// StepReport::unbalance
double unbalance(const SubStep& step, const StepPoses& poses,
                 std::span<const LinearContact> linear);

/// omega dt of the stiffest closed spring; `compliance`: inverse of each block's K, by slot.
double stiffest_omega_dt(std::span<const LinearContact> linear, const SquareBlocks& compliance);

/// Of the island's blocks, J. `state`: by block.
double kinetic_energy(const SubStep& step, std::span<const BlockState> state);
double strain_energy(const SubStep& step, std::span<const BlockState> state);

/// By how much the mechanical energy of the island grows in an attempt, beyond the work of loads,
/// J. `end`: by block; `stored_before`: in the island's springs at the start, J.
double energy_growth(const SubStep& step, const StepEnergy& done, std::span<const BlockState> end,
                     double stored_before);

/// Of a block in a static sub-step of this length, J: what inertia takes, and the kinetic energy
/// that it sets out with, as the step begins at rest.
double static_loss(const BlockModel& model, const BlockState& start, const Vector12& increment,
                   double length);

/// Books an accepted sub-step but for the energies that the step ends with, which are those of its
/// last sub-step. `growth`: energy_growth().
void book(const StepEnergy& done, double growth, EnergyLedger& energy);

}  // namespace quoin::solver
