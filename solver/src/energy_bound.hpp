#pragma once
/// Velocities of a step whose energy is not more than there is.

#include <span>

#include "step.hpp"

namespace quoin::solver {

/// What a step's velocities are judged by, by slot.
struct VelocityBalance {
  const BlockVector& positions;    ///< velocities by the positions, 2D/dt - v, times time_step
  double time_step = 0.0;          ///< s
  std::span<const int> islands;    ///< groups of blocks joined by contacts: the least slot of each
  std::span<const double> pushed;  ///< work of moving supports by the impulses that attempt.end has
                                   ///< beyond the positions' forces, J
};

/// Coulomb's law has several solutions where friction jams, and impulses found beside the
/// positions' forces can give an island more energy than it had and was given. The positions'
/// velocities keep the balance exactly: from there those of attempt.end go only so far as energy
/// allows. What moving supports do is booked.
void bound_energy(const CompiledScene& compiled, const State& start, const VelocityBalance& balance,
                  Attempt& attempt);

}  // namespace quoin::solver
