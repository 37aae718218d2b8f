#pragma once
/// Contact forces of a linearised step by the iteration that the options name.

#include <optional>

#include "iteration/moving_contacts.hpp"
#include "iteration/open_close.hpp"

namespace quoin::solver {

/// What an attempt at a sub-step came to.
struct AttemptOutcome {
  bool solved = false;
  bool closed = true;                 ///< all gaps that should be
  bool can_cut = false;               ///< a half is not too short
  double gains = 0.0, allowed = 0.0;  ///< of energy, and what a sub-step may gain, J
  double contact_work = 0.0;          ///< of contact forces, less what sliding loses, J
};

/// What becomes of an attempt at a sub-step.
enum class Fate {
  End,    ///< it is taken, or has failed
  Again,  ///< another iteration is to try it as it is: it was not solved, or contacts that yield
          ///< left gaps or gained energy
  Halved  ///< as Again, but none is left
};

/// Keeps the memory of both iterations, and what an attempt at a sub-step has spent.
class ContactSolver {
 public:
  ContactSolver(const Slots& slots, StepWatch* watch)
      : slots_(&slots), watch_(watch), open_close_(slots, watch), moving_contacts_(slots, watch) {}

  /// A step begins: nothing of it has failed yet.
  void begin();
  /// Iterations of all solve() until the next call.
  void allow(int iterations) { iterations_left_ = iterations; }
  /// An attempt at a sub-step begins. Of ContactIteration::Automatic: which iteration has it.
  /// `crowd`: of the last sub-step, 0: none.
  void start(int crowd);
  /// An attempt at a sub-step has ended. How long the next one is by this one, if it is not taken:
  /// a half; or as it was at first, with contacts that yield, but where these have not solved it.
  /// Infinity: all that is left of the step. `can_cut`: a half is not too short.
  double note(bool solved, bool can_cut);

  Fate judge(const AttemptOutcome& outcome);
  /// Another sub-step is next.
  void move_on();
  /// Of positions or velocities, as OpenClose::solve(); tuning.max_iterations is set here.
  OpenCloseResult solve(const StepOptions& options, const BlockEquations& blocks,
                        std::span<LinearContact> contacts, OpenCloseOptions tuning,
                        BlockVector& increment);

  /// From the next solve() on.
  void use(const Threads& threads) {
    threads_ = threads;
    open_close_.use(threads);
    moving_contacts_.use(threads);
  }

  /// From the next step on: linear systems as these options have them, and what several processes
  /// agree on.
  void choose(const StepOptions& options);

  /// Of the open–close iteration.
  LinearSolver& linear_solver() { return open_close_.linear_solver(); }

  /// For start() of the next sub-step, now that this one is solved; where islands meet the largest
  /// counts. 0: solved by the open-close iteration, as the one before.
  int crowd() const;

  /// The proximal Newton method is at work.
  bool yielding() const { return yielding_; }
  /// The last problem was left to the interior point method: its gaps are the next step's.
  bool inexact() const { return inexact_; }

 private:
  OpenCloseResult iterate(const StepOptions& options, const BlockEquations& blocks,
                          std::span<LinearContact> contacts, OpenCloseOptions tuning,
                          BlockVector& increment);
  OpenCloseResult yield(const BlockEquations& blocks, std::span<LinearContact> contacts,
                        const OpenCloseOptions& tuning, BlockVector& increment);
  bool may_go_inside(std::span<const LinearContact> contacts, const OpenCloseOptions& tuning) const;
  OpenCloseResult solve_static(Analysis analysis, const BlockEquations& blocks,
                               std::span<LinearContact> contacts, OpenCloseOptions tuning,
                               BlockVector& increment);
  bool asks_to_yield(const StepOptions& options, const BlockEquations& blocks,
                     std::span<const LinearContact> contacts);

  /// Of Automatic: who has the attempt.
  static constexpr int kSlow = 4;  ///< crowd() where slow_; others are stages
  enum class Stage {
    OpenClose,
    Again,   ///< the same, after a step that it has not solved
    Crowd,   ///< the proximal Newton method, whatever gaps are left
    Checked  ///< the same, as long as no gaps are left and no energy is gained
  };
  enum class Try : std::uint8_t { None, Now, Failed };
  bool is_loose(std::span<const LinearContact> contacts) const;
  /// What a block bears: a much heavier one, and the way in which that pushes it.
  struct Load {
    int heavy = kNone;
    Vector3 push = Vector3::Zero();
    static constexpr int kNone = -2;  // -1 is a block that has no unknowns
  };
  bool is_uneven(const BlockEquations& blocks, std::span<const LinearContact> contacts);
  bool is_steep(std::span<const LinearContact> contacts) const;
  bool can_check() const;
  int patience(std::span<const LinearContact> contacts) const;

  const Slots* slots_;
  StepWatch* watch_;
  Threads threads_;
  OpenClose open_close_;
  MovingContacts moving_contacts_;
  Stage stage_ = Stage::OpenClose;   ///< of the attempt: never Again
  std::optional<Stage> step_began_;  ///< with
  Try checked_ = Try::None;          ///< the checked stage, by this sub-step
  bool stays_hard_ = false;          ///< in this attempt contacts that yield would make energy
  bool suits_ = true;                ///< the proximal Newton method could have the problem
  std::vector<Load> loads_;          ///< memory of is_uneven(), by slot
  bool cannot_yield_ = false;        ///< the checked stage has not solved it
  bool automatic_ = false;
  bool yielding_ = false;
  int failures_ = 0;      ///< attempts that were not solved, in a row
  bool inexact_ = false;  ///< the last problem of the attempt was left to the interior point method
  bool slow_ = false;     ///< far from rest: those that follow are, too
  bool gave_up_ = false;  ///< the open-close iteration, for what is left of the step
  int iterations_left_ = 0;
};

}  // namespace quoin::solver
