#pragma once
/// Newton's method on the equations of one linearised step, with a search along unsymmetric steps.
/// They are counted from a first guess D0:
///
///   residual(D) = (F - K D0) - K D + sum J^T f(d),   d = (offset + J D0) + J D.
///
/// Forces and gaps are then rounded like the change D and not like the whole motion of the step.

#include <span>

#include "base/step_watch.hpp"
#include "contact/linear_contact.hpp"
#include "linear/linear_solver.hpp"

namespace quoin::solver {

/// K (diagonal) and F of the blocks alone, and the pairs that contacts couple.
struct BlockEquations {
  const BlockSystem& base;
  const BlockVector& force;
};

/// What a contact follows: the mode assumed at the start (no conditions are checked), or its law.
enum class Law { Assumed, True };

/// Keeps the memory between calls.
class ContactEquations {
 public:
  explicit ContactEquations(const Slots& slots);

  /// From here on.
  void use(const Threads& threads) { threads_ = threads; }

  /// Takes `guess` as D0. Sets LinearContact::guess. `gap_rounding`, m: between blocks that stand a
  /// smaller gap or slip is zero.
  void shift(const BlockEquations& blocks, std::span<LinearContact> contacts,
             const BlockVector& guess, double gap_rounding);

  /// The residual of the change D. Sets d, forces and modes of the contacts. `softness`: of all
  /// contacts, share of their stiffness.
  void evaluate(const BlockSystem& base, std::span<LinearContact> contacts,
                const BlockVector& change, Law law, double softness);

  const BlockVector& residual() const { return residual_; }  ///< by slot
  /// The largest residual by the forces at its block, less what rounding makes of it.
  double relative_residual() const { return worst_residual(floor_); }
  /// The same, less what rounding of `change`, which was evaluated, makes of it, too.
  double residual_beyond_rounding(const BlockSystem& base, std::span<const LinearContact> contacts,
                                  const BlockVector& change, double softness) const;
  bool balanced(std::size_t slot, double tolerance) const;
  /// Moments and strain moments by block length, N2.
  double squared_residual() const;
  /// The largest of forces on blocks, by the forces at them.
  double relative_push(const BlockVector& push) const;

 private:
  /// Of a block's residual what is above `floor`, N.
  double unbalanced(std::size_t slot, double floor) const;
  void evaluate_contact(const BlockVector& change, Law law, double softness,
                        LinearContact& c) const;
  void evaluate_blocks(const BlockSystem& base, const BlockVector& change, std::size_t first,
                       std::size_t end);
  void push_blocks(std::span<const LinearContact> contacts, std::size_t first, std::size_t end);
  void add_rounding(const BlockSystem& base, std::span<const LinearContact> contacts,
                    const BlockVector& change, double softness, std::vector<double>& floor) const;
  double floor_beside(std::size_t slot) const;
  double worst_residual(std::span<const double> floor) const;

  Threads threads_;
  const Slots* slots_;
  BlockVector right_;  ///< F - K D0
  BlockVector residual_;
  std::vector<double> scale_;  ///< force scale, per slot, N
  /// What rounding of the guess makes of a residual, N: per slot; of it, of the blocks alone, of
  /// all contacts as if closed; and of each contact's force.
  std::vector<double> floor_, block_floor_, all_noise_, noise_;
};

/// How far, with what and how long to relax.
struct RelaxOptions {
  double tolerance = 1e-10;  ///< relative residual
  double softness = 1.0;     ///< of all contacts, share of their stiffness
  int most_iterations = 0;   ///< in all
};

enum class Relaxed {
  No,           ///< the residual does not fall any more, or the matrix can't be solved
  ToTolerance,  ///< it is within the tolerance
  ToRounding,   ///< it does not fall any more, and what exceeds the tolerance is rounding
};

/// Keeps the memory between calls. The unknown is the change of the increments against a guess.
class ContactNewton {
 public:
  /// `watch`: looked at in each step, which then throws StepStopped.
  ContactNewton(const Slots& slots, StepWatch* watch)
      : slots_(&slots), watch_(watch), equations_(slots), solver_(slots, watch) {}

  /// From now on these equations, no change yet. The arguments must outlive the use of this object.
  /// `gap_rounding`: see ContactEquations::shift().
  void set(const BlockEquations& blocks, std::span<LinearContact> contacts,
           const BlockVector& guess, double gap_rounding);
  /// Residual, forces and modes at the present change; `softness`: of all contacts, share of their
  /// stiffness.
  void evaluate(Law law, double softness);
  /// One step. False, and nothing moved, when the matrix can't be solved.
  bool step(Law law, double softness, SolveCount& count);
  /// Steps until the residual is small.
  Relaxed relax(const RelaxOptions& options, SolveCount& count);

  /// From the next set() on.
  void use(const Threads& threads) {
    threads_ = threads;
    equations_.use(threads);
    solver_.use(threads);
  }

  LinearSolver& linear_solver() { return solver_; }
  const ContactEquations& equations() const { return equations_; }
  const BlockVector& change() const { return change_; }
  void set_change(const BlockVector& change) { change_ = change; }
  bool factorized() const { return factorized_; }
  double condition_estimate() const { return solver_.condition_estimate(); }

 private:
  bool same_tangent(Law law, double softness);
  void assemble();
  template <int n>
  void add_contacts(std::size_t first, std::size_t end);
  void move(double softness, double share);
  bool reaches_on(double residual, double& least) const;
  void search(double softness);

  const Slots* slots_;
  StepWatch* watch_;
  Threads threads_;
  ContactEquations equations_;
  LinearSolver solver_;
  const BlockSystem* base_ = nullptr;
  std::span<LinearContact> contacts_;
  BlockSystem system_;
  BlockVector change_, trial_, step_;
  std::vector<Matrix3> tangent_;  ///< of each contact, of the last factorization
  bool factorized_ = false;
};

}  // namespace quoin::solver
