#pragma once
/// Ties: links of two material points. Elongation e = length - rest length - plastic, tension
/// positive; force f = clamp(stiffness e) between - yield force (tension_only: 0) and yield force.

#include "block/block_system.hpp"
#include "contact/contact_jacobian.hpp"
#include "contact/joint_law.hpp"

namespace quoin::solver {

struct TieModel {
  Tie tie;
  Vector3 arm_a = Vector3::Zero();  ///< reference arm, m; of the world a place relative to
  Vector3 arm_b = Vector3::Zero();  ///< State::origin
};

/// As it is put in where its blocks stand, with its pretension or rest length.
TieState laid_tie(const TieModel& model, std::span<const Pose> poses);

/// Energy in it, J.
double stored_energy(const Tie& tie, const TieState& state);

/// Its state at the end of a step that began with `before`; one that is broken stays so.
TieState tie_at_end(const TieModel& model, const TieState& before, std::span<const Pose> end);

/// Whether it bears more than it can.
bool is_overloaded(const Tie& tie, const TieState& state);

/// Of one that the length (m) at a step's end overloads: the mean force of the step, N, tension
/// positive, where it bears all up to the moment at which it breaks and nothing from then on, and
/// its length changes evenly.
double force_until_break(const Tie& tie, const TieState& before, double length);

/// d, and the law between the step's start and its present end. First row: length that it lacks to
/// its unstressed length, so that tension is f_n > 0; its discrete derivative is exact. The other
/// two let the tie's direction follow the increment in Newton's method, and vanish at the solution.
/// `end_share`: see StepScheme; below 1 the force is the mean that does exactly the stored and
/// plastic work. One that is broken pulls with `before.force` all the step.
void linearise_tie(const TieModel& model, const TieState& before, const StepPoses& poses,
                   double end_share, LinearContact& linear);

/// Of a tie that pulled with `force` (N) from one state to the next.
ContactWork tie_work(const Tie& tie, const TieState& before, const TieState& end, double force);

}  // namespace quoin::solver
