#pragma once
/// Open–close and multiplier iteration: the contact forces of one linearised step.
///
/// Find D and contact forces f with   K D = F + sum J^T f,   d = offset + J D   and, at each
/// contact, the law of joint_law.hpp. Source: [Alart & Curnier 1991] for the projected augmented
/// Lagrangian; see solver/README.md.

#include <optional>
#include <span>

#include "block/block_system.hpp"
#include "contact/linear_contact.hpp"
#include "iteration/contact_newton.hpp"

namespace quoin::solver {

/// How blocks move in a dynamic step by what acts on them but contacts, by slot.
struct FreeMotion {
  const SquareBlocks& compliance;  ///< inverse of K
  const BlockVector& coasting;     ///< v dt: without loads, too
};

/// Blocks that no contact has to push. Where gravity is switched off, or a support goes, the exact
/// contact forces are zero. Multipliers come to that by a share each update: relative to the forces
/// at a block, which are these and nothing else, they never get there.
///
/// Whether no contact has to push where the blocks move freely: each opens; or it lets blocks come
/// no nearer than rounding makes of where they are, loads do not press it, and it overlaps no more
/// than `overlap`, m. A bonded one and a held point keep where they were in all directions, springs
/// are never left alone.
bool is_unforced(const FreeMotion& free, const BlockVector& force,
                 std::span<const LinearContact> contacts, double overlap);

/// Of blocks that touch nothing. Where the increments are as good as a guess they stay. Largest
/// change of a motion, m.
double coast(const FreeMotion& free, const Slots& slots, const BlockVector& force,
             BlockVector& increment);

struct OpenCloseOptions {
  double force_tolerance = 1e-10;  ///< relative to the forces at a block
  double gap_tolerance = 1e-12;    ///< m
  double gap_rounding = 0.0;  ///< m: a smaller gap or slip is zero for all that doubles can tell
  /// Of the proximal Newton method, m: gaps of the start up to this count as closed, and overlaps
  /// and stretches are mended apart from the forces. 0: forces mend them, as those of velocities
  /// do.
  double mended_apart = 0.0;
  /// Of the proximal Newton method: another linearisation will follow. Forces to a thousandth do,
  /// and gaps are left.
  bool rough = false;
  int max_iterations = 200;
  bool raise = false;      ///< augmentation where the gap falls slowly
  bool predicted = false;  ///< the first guess is no solution yet: blocks may stand instead
  bool at_rest = false;    ///< of a static step: the interior point method may help
  /// Many rigid blocks move: contact forces are wanted to 1e4 times the force tolerance alone.
  bool moves = false;
  /// Joints hold without limit, and will be judged by the forces: whether these have one is asked.
  bool breaks = false;
  double softness = 1.0;  ///< of all contacts, to begin with: that of an earlier result
  /// Many blocks that deform, in a step that is no motion: slow updates share forces out between
  /// redundant contacts, and 1e-5 of the forces is enough. Where Newton's method fails contacts
  /// keep a tenth of their stiffness; with less the updates drift off.
  bool redundant = false;
  const FreeMotion* free = nullptr;  ///< of a dynamic step: contacts may have nothing to do
};

struct OpenCloseResult : SolveCount {
  bool converged = false;
  double residual = 0.0;  ///< relative force residual
  double condition = 0.0;
  bool closed = true;   ///< all gaps that should be, as well as the tolerance asks; of the proximal
                        ///< Newton method as far as contacts do no work by it
  double change = 0.0;  ///< largest motion of a block against the first guess, m
  double softness = 1.0;  ///< of all contacts, with which they were solved
  /// No forces meet the contact conditions: what is held without limit forbids them, and forces
  /// grow for ever, as long as they are let.
  bool infeasible = false;
};

/// Updates that have left the gaps as they are when forces are found to grow for ever.
inline constexpr int kFixedUpdates = 3;

/// Forces and gaps of crowds, relative: 1e4 times the tolerance, 1e-6 at most, or
/// the tolerance itself where that is coarser.
double crowd_tolerance(double tolerance);

/// Blocks: fewer are solved exactly, which costs little.
inline constexpr int kMany = 16;

/// Whether there are many blocks, and some deform.
bool many_deform(const Slots& slots);

/// Whether there are many rigid blocks, of which one moves by more than 1e-9 of itself.
bool is_moving(const Slots& slots, const BlockVector& increment);

/// Counts of both; the rest is that of the later one, its condition where it factorized.
void add(const OpenCloseResult& later, OpenCloseResult& total);

/// Pairs of slots that contacts couple, and which pair each contact belongs to.
void set_pairs(std::span<LinearContact> contacts, BlockSystem& base);

/// Keeps the memory between calls.
class OpenClose {
 public:
  /// `watch`: looked at in each iteration; solve() then throws StepStopped.
  explicit OpenClose(const Slots& slots, StepWatch* watch = nullptr)
      : slots_(&slots), newton_(slots, watch) {}

  /// An attempt begins: nothing is known of gaps.
  void begin();

  /// `base`: block terms (diagonal only) and the pairs that contacts couple. `increment`: in, the
  /// first guess; out, D. Contacts: multipliers in, forces and modes out.
  OpenCloseResult solve(const BlockSystem& base, const BlockVector& force,
                        std::span<LinearContact> contacts, const OpenCloseOptions& options,
                        BlockVector& increment);

  /// Nothing is left to solve where no contact has to push and those that overlap do by no more
  /// than `overlap`, m; unless what contacts bore holds the blocks where they are guessed.
  std::optional<OpenCloseResult> fly(const BlockEquations& blocks,
                                     std::span<LinearContact> contacts,
                                     const OpenCloseOptions& options, double overlap,
                                     BlockVector& increment);

  /// From the next solve() on.
  void use(const Threads& threads) { newton_.use(threads); }

  LinearSolver& linear_solver() { return newton_.linear_solver(); }

 private:
  /// How the iteration on the multipliers stands.
  struct Progress {
    double softness = 1.0;  ///< of all contacts: share of their stiffness
    int updates = 0;        ///< of the multipliers
    int raises = 0;         ///< of the augmentation
    /// Nothing is solved yet, the first guess says nothing of modes, and blocks are rigid: where
    /// they deform the assumed modes cost as often as they gain.
    bool assumes = false;
    bool slow = false;      ///< as Newton's method has been
    bool softened = false;  ///< since the last solution
    bool exact = false;     ///< there has been a solution to the tolerance
    double gap = 0.0;       ///< violation when last solved, m
    int fixed = 0;          ///< updates in a row that have left it
    bool infeasible = false;
  };
  struct GapLeft {
    double most;   // m
    double share;  // of the last update's
  };
  double violation(std::span<const LinearContact> contacts) const;
  double stand(const BlockEquations& blocks, std::span<LinearContact> contacts,
               const OpenCloseOptions& options, BlockVector& guess);
  std::optional<OpenCloseResult> rests(const BlockEquations& blocks,
                                       std::span<LinearContact> contacts,
                                       const OpenCloseOptions& options, BlockVector& guess);
  double wanted_residual(std::span<const LinearContact> contacts, const OpenCloseOptions& options,
                         const Progress& progress) const;
  void step_assumed(double softness, SolveCount& count);
  bool converge(std::span<LinearContact> contacts, const OpenCloseOptions& options,
                Progress& progress, SolveCount& count);
  bool settled(std::span<LinearContact> contacts, const OpenCloseOptions& options,
               Progress& progress);
  bool serves_motion(std::span<const LinearContact> contacts, const OpenCloseOptions& options,
                     const GapLeft& gap, bool stops);
  bool begins_to_move(std::span<const LinearContact> contacts, const OpenCloseOptions& options,
                      double gap);
  void note_loose(std::span<LinearContact> contacts, const OpenCloseOptions& options,
                  Progress& progress);
  void follow_gap(std::span<LinearContact> contacts, const OpenCloseOptions& options,
                  const GapLeft& gap, Progress& progress);
  double push_of_update(std::span<const LinearContact> contacts);
  bool infeasible(std::span<const LinearContact> contacts, const OpenCloseOptions& options,
                  Progress& progress) const;

  const Slots* slots_;
  ContactNewton newton_;
  BlockVector solved_;        ///< the last change that solved for its multipliers
  BlockVector still_;         ///< zeros
  BlockVector guess_;         ///< memory of fly()
  BlockVector push_;          ///< memory of push_of_update()
  std::vector<char> stands_;  ///< by slot
  /// Violations when last solved, also by the last linearisation, m: to the tolerance, loosely.
  /// What a loose solution leaves is no measure of how gaps fall from it to an exact one.
  double last_gap_ = 0.0, last_loose_gap_ = 0.0;
  double loose_gap_ = 0.0;     ///< m: above it solutions are loose
  double accepted_gap_ = 0.0;  ///< m: of what moves, by an earlier linearisation, and a little more
};

}  // namespace quoin::solver
