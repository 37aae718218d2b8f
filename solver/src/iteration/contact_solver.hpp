#pragma once
/// Contact forces of a linearised step by the iteration that the options name.

#include "iteration/open_close.hpp"
#include "moving/moving_contacts.hpp"

namespace quoin::solver {

/// Keeps the memory of both iterations, and what an attempt at a sub-step has spent.
class ContactSolver {
 public:
  ContactSolver(const Slots& slots, StepWatch* watch)
      : open_close_(slots, watch), moving_contacts_(slots, watch) {}

  /// A step begins: nothing of it has failed yet.
  void begin() { failures_ = 0; }
  /// Iterations of all solve() until the next call.
  void allow(int iterations) { iterations_left_ = iterations; }
  /// Of ContactIteration::Automatic: what a crowd does is left to the proximal Newton method, and
  /// so is what is left of a step of which attempts in a row were not solved. `crowd`: of the last
  /// sub-step.
  void start(int crowd);
  /// An attempt at a sub-step has ended. True where the next ones are left to that method, and
  /// this one was not.
  bool note(bool solved);

  /// The attempt at a sub-step gained energy where contacts yield: true where the open-close
  /// iteration is to try it next.
  bool try_hard();
  /// The attempt was not solved: true where it was such a try, and the other method is next.
  bool leave_hard();
  /// Another sub-step is next.
  void move_on() { hard_ = Hard::Untried; }

  /// Of positions or velocities, as OpenClose::solve(); tuning.max_iterations is set here.
  OpenCloseResult solve(const StepOptions& options, const BlockEquations& blocks,
                        std::span<LinearContact> contacts, OpenCloseOptions tuning,
                        BlockVector& increment);

  /// Of the open–close iteration, from the next solve() on.
  void use(const Threads& threads) { open_close_.use(threads); }

  /// Of the open–close iteration.
  LinearSolver& linear_solver() { return open_close_.linear_solver(); }

  /// 0: the open-close iteration solved the attempt; else one more than the sub-steps in which it
  /// is not to try it for the sake of energy.
  int crowd() const;

  /// The proximal Newton method is at work.
  bool yielding() const { return yielding_; }

 private:
  OpenCloseResult iterate(const StepOptions& options, const BlockEquations& blocks,
                          std::span<LinearContact> contacts, OpenCloseOptions tuning,
                          BlockVector& increment);

  OpenClose open_close_;
  MovingContacts moving_contacts_;
  /// Whether the open-close iteration tries a crowd's sub-step.
  enum class Hard { Untried, Now, Failed };

  Hard hard_ = Hard::Untried;
  int sub_steps_left_ = 0;  ///< without a try
  bool crowd_ = false;
  bool automatic_ = false;
  bool yielding_ = false;
  int failures_ = 0;  ///< attempts in a row that were not solved
  int iterations_left_ = 0;
};

}  // namespace quoin::solver
