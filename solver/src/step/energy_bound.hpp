#pragma once
/// Velocities of a step whose energy is not more than there is.

#include <span>

#include "step/energy_ledger.hpp"

namespace quoin::solver {

/// What a step's velocities are judged by, by slot.
struct VelocityBalance {
  const BlockVector& positions;    ///< velocities by the positions, 2D/dt - v, times dt
  std::span<const int> groups;     ///< blocks joined by closed contacts: the least slot of each
  std::span<const double> pushed;  ///< work of moving supports by the impulses that `end` has
                                   ///< beyond the positions' forces, J
  double allowed = 0.0;            ///< growth, of the energy that goes in
  /// By the slot of a group: its positions include a rebound; supports take up momentum of it.
  std::span<const char> bouncing = {}, grounded = {};
  std::span<const char> driven = {};  ///< likewise: and these supports move
};

/// Of a group of blocks, J. `law`: of the velocities given; `middle`: halfway to them.
struct GroupEnergy {
  double available = 0.0;  ///< at the start and by work, less strain energy at the end
  double magnitude = 0.0;  ///< of what `available` sums: its rounding goes with it
  double pushed =
      0.0;  ///< work of what moves supports, by the impulses beyond the positions' forces
  double positions = 0.0, middle = 0.0, law = 0.0;  ///< kinetic
  double share = 1.0;  ///< result: of the way from the positions' velocities to those of the law
};

/// Velocities (12x1, spin and strain rate in the turning frame) by slot, of blocks that would move
/// as one with the momentum that those of a group have in `end` (by block): a rigid motion with
/// their linear and angular momentum where `grounded` (by the group's slot) is false, else their
/// mean translation. The rest of their kinetic energy is that of motion relative to it. `groups`:
/// the least slot of each one's group.
void set_common_motion(const SubStep& step, std::span<const int> groups,
                       std::span<const char> grounded, std::span<const BlockState> end,
                       BlockVector& common);

/// Kinetic energy of each group with these velocities (by slot), by the slot of the group, J.
void set_group_energy(const SubStep& step, std::span<const int> groups, const BlockVector& velocity,
                      std::span<const BlockState> end, std::vector<double>& energy);

/// Coulomb's law has several solutions where friction jams, and impulses found beside the
/// positions' forces can give a group of blocks more energy than it had and was given
/// (energy.work_on). The positions' velocities keep the balance exactly: from there those of `end`
/// (by block) go only so far as energy allows. Not so in groups that bounce: their blocks' motion
/// against each other is scaled down as far as that takes, their momentum stays. What moving
/// supports do is booked. `of_group`: memory.
void bound_energy(const SubStep& step, const VelocityBalance& balance, std::span<BlockState> end,
                  StepEnergy& energy, std::vector<GroupEnergy>& of_group);

}  // namespace quoin::solver
