#pragma once
/// Gap and slip of a contact as linear functions of the increments of its two blocks.

#include "block/block_system.hpp"
#include "contact/contact_history.hpp"
#include "contact/linear_contact.hpp"

namespace quoin::solver {

/// Start and current end of a step: what the discrete derivative of gap and slip is taken between.
struct StepPoses {
  std::vector<Pose> start, end;
  std::vector<Vector12> increment;  ///< by block: what leads from start to end
  std::vector<char> deforms;        ///< by block: its strain moves in this step
  std::vector<char> moves;          ///< by block: it may
};

/// d = offset + J_a D_a + J_b D_b with d exactly gap and slip at the end of the step when D is the
/// increment that `poses` was made with. Blocks without unknowns enter the offset; rows of fixed
/// ones say nothing. d_n of a vertex at P against a face with normal n carried by the face's block
/// (mean values over the step barred):  gap' - gap = n̄·(dx_b - dx_a) + (r × n̄)·m̄,   m = x_b - x_a,
/// the discrete form of [Beyabanaki 2009], equations (23)–(28), with the reaction at the projection
/// P0. Gaps and slips at the start within their rounding of zero are zero: the redundant contacts
/// of a face then agree exactly and no force builds up against rounding.
void linearise(const BodyContact& contact, const StepPoses& poses,
               std::span<const BlockModel> models, LinearContact& linear);

/// The same for velocities at the end of the step: d = J V, V = (v | W | strain rate) of each
/// block.
void linearise_velocity(const BodyContact& contact, const StepPoses& poses, LinearContact& linear);

/// Half the rotation vector of the block that carries the contact's normal, from start to end.
Vector3 half_turn(const BodyContact& contact, const StepPoses& poses);

/// Augmentation over the stiffness that the two blocks oppose to the contact. Chosen: 1e4, 1e5 and
/// 1e6 were tried on the inclines, towers and rocking blocks; higher needs fewer updates of the
/// multipliers and leaves fewer digits to the forces.
constexpr double kAugmentation = 1e5;

/// Augmentation of normal and shear from what the two blocks alone oppose to the contact;
/// compliance: inverse of each block's K, by slot.
void set_augmentation(const SquareBlocks& compliance, LinearContact& linear);

/// Displacement of the contact per unit force on it, blocks alone, m/N: along the normal, and along
/// the softest tangent, so that nothing hangs on how t1 and t2 lie.
double normal_compliance(const LinearContact& linear, const SquareBlocks& compliance);
double shear_compliance(const LinearContact& linear, const SquareBlocks& compliance);

/// Unit vectors t1, t2 that complete n to a right-handed frame, t1 normal to the contact's axis:
/// they turn smoothly with n through a step.
void tangent_frame(const BodyContact& contact, const Vector3& normal, Vector3& t1, Vector3& t2);

}  // namespace quoin::solver
