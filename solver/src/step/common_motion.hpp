#pragma once
/// What blocks have in common of their motion: all that contact forces between them must leave.

#include <span>

#include "step/sub_step.hpp"

namespace quoin::solver {

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

}  // namespace quoin::solver
