#pragma once
/// Newton's method on the cones of a contact problem, kept regular by a proximal term.

#include "iteration/cone_problem.hpp"

namespace quoin::solver {

/// How far an iteration came.
struct IterationCount : SolveCount {
  bool converged = false;
  double residual = 0.0;
};

/// Forces that are added to those of the contacts, and A D of them; empty: none.
struct AddedForces {
  std::span<const Vector3> x, motion;
};

struct IterationLimit {
  double residual = 1e-8;
  int iterations = 50;
  bool soon = false;  ///< of contacts that yield: what does not look like ending is given up
};

/// Largest |x - P(x - y)| over the largest |x|; the forces x are borne exactly by the blocks.
double relative_residual(std::span<const Admissible> admissible, std::span<const Vector3> x,
                         std::span<const Vector3> u);

/// Semismooth Newton's method on x = P(x - y), whole steps. Each solves
///
///   (I - P') dx + P' E (A dD + eps dx) = P(x - y) - x,   E = dy/du,
///
/// so that redundant contacts share forces as they were: the proximal point method with one step
/// of Newton's method each, exact where it converges. [Rockafellar 1976]
class ProximalNewton {
 public:
  /// Hard contacts: eps falls with the residual. `x`: the start; out, the best iterate.
  IterationCount solve_hard(ConeProblem& problem, const IterationLimit& limit,
                            std::vector<Vector3>& x);
  /// Contacts that yield by `softness` (x - bar), of each contact's own Delassus block.
  IterationCount solve_soft(ConeProblem& problem, double softness, std::span<const Vector3> bar,
                            const IterationLimit& limit, std::vector<Vector3>& x);

 private:
  /// dx by the motions u_, as right_ - tangents_ motion_.
  bool find_step(ConeProblem& problem, double share, double smoothing, std::span<const Vector3> x);
  void take_step(std::vector<Vector3>& x) const;

  std::vector<Vector3> u_, right_, motion_, best_;
  std::vector<Matrix3> tangents_;
};

}  // namespace quoin::solver
