#pragma once
/// Newton's method on the equations of one linearised step, with a search along each step.

#include "base/step_watch.hpp"
#include "iteration/contact_equations.hpp"

namespace quoin::solver {

/// What was spent.
struct NewtonCount {
  int iterations = 0;
  int solves = 0;
  int factorizations = 0;
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
  bool step(Law law, double softness, NewtonCount& count);
  /// Steps until the residual is small.
  Relaxed relax(const RelaxOptions& options, NewtonCount& count);

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
  void move(Law law, double softness, double share);
  bool reaches_on(double residual, double& least) const;
  void search_slope(Law law, double softness);
  void search_residual(Law law, double softness);

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
