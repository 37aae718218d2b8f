#pragma once
/// One attempt at one sub-step of one island: equilibrium of positions, then the velocity law.

#include "base/phase_clock.hpp"
#include "iteration/contact_solver.hpp"
#include "step/energy_bound.hpp"
#include "step/impact_law.hpp"
#include "step/linearise.hpp"
#include "step/predict.hpp"

namespace quoin::solver {

/// What the positions made of a contact.
struct SolvedContact {
  double gap = 0.0;     ///< m, beyond the joint's opening
  double change = 0.0;  ///< N: what the next iteration would change its force by, where not solved
  ContactMode mode = ContactMode::Open;
  bool compliant = false;
  bool was_closed = false;
  bool struck = false;  ///< touches, both blocks hit: it may be open by rounding
  bool closes = false;  ///< in the sub-step, by free flight
  double start = 0.0;   ///< gap at its start, m
};

/// What an attempt came to.
struct Attempt {
  OpenCloseResult solved;
  StepEnergy energy;
  double displacement = 0.0;  ///< largest of a vertex, relative to its block's size
  double unbalance = 0.0;
  double stiffest_omega_dt = 0.0;  ///< of the springs
  double first_impact = 0.0;       ///< share of the sub-step before it; 0: none
  std::vector<char> hit;           ///< by slot: an impact passes through it
  double shift = 0.0;              ///< of supports, while the strain of hit blocks waits, m
  bool squeezed = false;           ///< moving rigidly, these are in the way of supports
  double rounding = 0.0;           ///< of a gap, m
  /// Contacts, then held points, then ties, then quiet points; the velocity law takes it for its
  /// own contacts.
  std::vector<LinearContact> linear;
  std::vector<SolvedContact> positions;  ///< of all of them, as solved
  std::vector<Vector3> held_forces;      ///< on the blocks, of IslandBlocks::held, N
  std::vector<TieState> ties;            ///< as they end, of IslandBlocks::ties
  std::vector<Vector3> quiet_forces;     ///< likewise, of IslandBlocks::quiet, N
  std::vector<Contact> contacts;         ///< as they end; sorted by key when the attempt is done
};

/// Memory of the velocity law.
struct ImpactMemory {
  VelocityProblem problem;
  Restitution restitution;
  BlockVector solution;        ///< by slot
  BlockVector free_gain;       ///< by slot, where a contact closes
  std::vector<double> pushed;  ///< by slot
  std::vector<GroupEnergy> of_group;
};

/// Memory of an island's attempts, and the numbers that its stages hand on.
struct AttemptMemory {
  AttemptMemory(const Slots& slots, StepWatch* watch) : solver(slots, watch) {}
  BlockTerms terms;
  BlockVector increment;           ///< by slot
  BlockVector coasting;            ///< likewise, v dt
  std::vector<char> expected_hit;  ///< by slot
  bool strain_waits = true;        ///< of blocks that are hit
  std::vector<TieState> ties;      ///< of the island, at the start but for those that break
  ImpactMemory impact;
  ContactSolver solver;
  PhaseClock clock;
};

/// What an island's attempt writes of its own blocks, by block.
struct BlocksAtEnd {
  StepPoses& poses;
  std::vector<BlockState>& end;
};

/// Attempts by a method other than the default; contacts are those of the start of the step.
class AttemptMethod {
 public:
  virtual ~AttemptMethod() = default;
  virtual void attempt(const SubStep& step, std::span<const BodyContact> contacts,
                       PhaseClock& clock, BlocksAtEnd& blocks, Attempt& attempt) = 0;
};

/// Whether contacts leave overlaps that the shift of supports makes, for blocks move rigidly.
bool is_squeezed(double shift, std::span<const LinearContact> linear);

/// Solves for the increments of the sub-step with these contacts, whose joints it may find to fail.
void attempt_positions(const SubStep& step, const LastSubStep& last,
                       std::vector<BodyContact>& contacts, AttemptMemory& memory,
                       BlocksAtEnd& blocks, Attempt& attempt);

}  // namespace quoin::solver
