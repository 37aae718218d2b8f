#pragma once
/// Velocities at the end of a sub-step: restitution at closing contacts, rest at sticking ones.
/// [Moreau 1988]; the impulses replace the contact forces of the step, so that momentum is kept.

#include "base/joined_groups.hpp"
#include "contact/linear_contact.hpp"
#include "step/sub_step.hpp"

namespace quoin::solver {

/// Of the gap tolerance, of blocks that move: the next step closes what it leaves, and energy
/// changes by its square. Most steps of a shaken wall take a solution less, one in three.
inline constexpr double kVelocityGap = 100.0;

/// Contacts of velocities, and the blocks' equations: d is a relative velocity times dt, a force
/// 2/dt of an impulse.
struct VelocityProblem {
  /// What a solution changes of a contact, as it is before.
  struct Start {
    Vector3 multiplier = Vector3::Zero();
    double gap = 0.0, normal_stiffness = 0.0, shear_stiffness = 0.0;
    double bounce = 0.0;  ///< of d, with full restitution, m
    ContactMode assumed = ContactMode::Open;
  };
  /// A contact of a joint that dilates: how far it opens hangs on the velocities sought.
  struct Opening {
    std::size_t contact = 0;
    double slope = 0.0;   ///< opening per slip
    double opened = 0.0;  ///< of d, taken off its start, m
  };
  std::span<LinearContact> contacts;
  std::vector<Start> starts;      ///< by contact
  std::vector<Opening> openings;  ///< by the last solution
  BlockVector velocity, force;    ///< by slot: velocity times dt as the positions have it, F
  std::vector<std::pair<int, int>> pushed_before;  ///< slots joined by what pushed until the impact
  std::vector<double> work_before;                 ///< of moving supports by that, by slot, J
};

/// Work on blocks in a sub-step, by slot, J.
struct WorkOnBlocks {
  std::span<const double> forces;    ///< of all that the positions know
  std::span<const double> impulses;  ///< of moving supports, by the impulses beyond their forces
};

/// What velocities are solved to.
struct VelocityTolerance {
  double absolute = 0.0;  ///< m/s
  double relative = 0.0;  ///< of the energies that an impact's is made up of
};

/// Search for the largest share of a group's restitution that makes no energy. Energies in J.
struct BounceShare {
  double share = 0.0;                ///< 0 where nothing bounces
  double enough = 0.0, left = 0.0;   ///< the largest that made none, and the energy left
  double beyond = 0.0, lacks = 0.0;  ///< the least that made some, and how much
  int tries = 0;

  /// To the share to try next; false: the search is over. `excess`: energy that this share makes;
  /// `kinetic`: the group's.
  bool change(bool too_much, double excess, double kinetic);
};

/// Restitution of each group of blocks that closed contacts join, or joined until the first impact:
/// what is taken from a group's velocities leaves its momentum. Keeps the memory between steps.
class Restitution {
 public:
  /// No support moves, until begin() knows more.
  void forget() { driven_.clear(); }

  /// All of it. `compliance`: inverse of each block's K, by slot.
  void begin(const SubStep& step, const VelocityProblem& problem, const SquareBlocks& compliance,
             std::span<const BlockState> end);

  /// The contacts as they are before a solution, with their bounce, or what is left of it.
  void apply(const VelocityProblem& problem) const;

  /// For groups that have more energy than they had with the work done on them, where impulses gave
  /// it or bound_energy() could not take it off, as much of it as there is energy for; true when
  /// any has to be tried again. `end`: by block.
  bool lessen(const SubStep& step, const WorkOnBlocks& work, const VelocityTolerance& tolerance,
              std::span<const BlockState> end);

  /// By slot: the least slot of its group.
  std::span<const int> groups() const { return groups_; }
  /// By the slot of a group: contacts of it bounce, as the positions have it.
  std::span<const char> bouncing() const { return bouncing_; }
  /// Likewise: supports or held points take up momentum of it.
  std::span<const char> grounded() const { return grounded_; }
  /// Likewise: and one of these moves.
  std::span<const char> driven() const { return driven_; }

 private:
  std::size_t group_of(const LinearContact& contact) const;

  JoinedGroups joined_;
  std::vector<int> groups_;
  std::vector<BounceShare> shares_;  ///< by group
  std::vector<char> bouncing_, grounded_, driven_;
  std::vector<double> free_;  ///< by group, J: of what no contact has pushed
  std::vector<double> available_, now_, strained_, pushed_, noise_;  ///< of lessen(): by group, J
};

struct AttemptMemory;
struct Attempt;
struct BlocksAtEnd;

/// After positions were solved with `contacts`. Changes the velocities of blocks.end and what
/// `attempt` says of the solution and of the impact's loss.
void attempt_velocities(const SubStep& step, std::span<const BodyContact> contacts,
                        AttemptMemory& memory, BlocksAtEnd& blocks, Attempt& attempt);

}  // namespace quoin::solver
