#pragma once
/// The contacts of a sub-step as linear functions of the increments, each with its law.

#include "contact/contact_jacobian.hpp"
#include "step/sub_step.hpp"

namespace quoin::solver {

/// K D = F of an island's blocks alone, by its slots.
/// Where it changes from one linearisation to the next, that is F alone.
struct BlockTerms {
  BlockSystem base;                ///< K, and the pairs that contacts couple
  SquareBlocks compliance;         ///< inverse of each diagonal block
  std::vector<StepScheme> scheme;  ///< of each diagonal block: what it was made with
  BlockVector force;               ///< F
  BlockVector free_increment;      ///< of the first linearisation, where a contact may close
};

/// K and its inverse; blocks whose poses.deforms is 0 move rigidly. `terms`: of these blocks, made
/// anew where the scheme is another one.
void set_matrices(const SubStep& step, const StepPoses& poses, BlockTerms& terms);

/// F of inertia, stress, gravity and loads.
void set_force(const SubStep& step, const StepPoses& poses, BlockTerms& terms);

/// Spring of a contact, N/m: the user's, or one that fits the blocks; 0 where contact is exact.
double contact_spring(const CompiledScene& compiled, const StepOptions& options);

/// Laws and multipliers as the contacts stand at the start; sets BodyContact::opening. `linear`:
/// contacts first, then one entry per held point of the island, then one per tie, then one per
/// point of quiet faces.
void set_laws(const SubStep& step, std::span<BodyContact> contacts,
              std::vector<LinearContact>& linear);

/// How blocks would move in the step if contacts that were closed went on bearing what they bore,
/// and no other contact did anything: what a contact that closes in the step closes by. Left as it
/// is where no contact may close.
void set_free_increment(const SubStep& step, const StepPoses& poses,
                        std::span<const BodyContact> contacts, BlockTerms& terms);

/// Jacobians and offsets between the start and the present end; `linear` as from set_laws(). Edges
/// that turn past each other are crossed no more. `ties`: of the island, at the start.
void linearise(const SubStep& step, const BlockTerms& terms, const StepPoses& poses,
               std::span<const TieState> ties, std::span<BodyContact> contacts,
               std::span<LinearContact> linear);

/// Slips in the step, of joints whose law goes with them. A contact that has just opened counts,
/// too: were it closed it would have slid so far, and what it dilates by may be what closes it.
/// `opens`: solved with what it opens by these slips.
void measure_slips(const StepPoses& poses, std::span<const BodyContact> contacts, bool opens,
                   std::span<LinearContact> linear);

/// Rows: normal and two tangents of the face.
Matrix3 quiet_frame(const QuietPoint& quiet, const Pose& pose);

/// What a contact bore by the positions, in its frame with this normal, N.
Vector3 force_in_frame(const Contact& force, const BodyContact& contact, const Vector3& normal);

/// J D of the contact's two blocks, wherever they have unknowns or not.
Vector3 moved_by(const StepPoses& poses, const BodyContact& contact, const LinearContact& c);

/// Does a joint that slides have another strength, or its springs another normal force, by the slip
/// of the solution than those that this was found with, by more than `tolerance` of the force?
bool slip_lags(const StepOptions& options, std::span<const BodyContact> contacts,
               std::span<const LinearContact> linear, double tolerance);

/// The largest LinearContact::rounding, m.
double gap_rounding(std::span<const LinearContact> contacts);

/// Adds the energy in the springs of contacts as they lie to `stored`, by slot of the first block
/// of each contact that has one, J.
void store_at_rest(const CompiledScene& compiled, const StepOptions& options,
                   std::span<const Pose> poses, std::span<BodyContact> contacts,
                   std::vector<double>& stored);

}  // namespace quoin::solver
