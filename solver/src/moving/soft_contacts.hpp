#pragma once
/// What the iterations on a softened contact problem share: their options, measure and outcome.

#include "moving/cone_problem.hpp"

namespace quoin::solver {

/// The softness of the contacts: u = A D + c + share (x - bar).
struct Softness {
  double share = 0.03;           ///< eps, of each contact's own Delassus block
  std::span<const Vector3> bar;  ///< forces that are borne without yielding
};

/// How far an iteration came.
struct IterationCount {
  bool converged = false;
  int iterations = 0;
  int solves = 0;  ///< right-hand sides
  int factorizations = 0;
  double residual = 0.0;
};

struct IterationLimit {
  double residual = 1e-8;
  int iterations = 50;
};

/// y of x and u with |u_t| smoothed by k: sqrt(|u_t|² + k²) - k.
Vector3 corrected(const Vector3& u, double smoothing = 0.0);

/// I + n tᵀ, t = u_t / sqrt(|u_t|² + k²): the derivative of that.
Matrix3 correction_slope(const Vector3& u, double smoothing);

/// Largest |x - P(x - y)| over the largest |x|; the forces x are borne exactly by the blocks.
double relative_residual(std::span<const Vector3> x, std::span<const Vector3> u);

/// Largest |x|.
double largest(std::span<const Vector3> x);

/// u of x.
void respond_softly(ConeProblem& problem, const Softness& softness, std::span<const Vector3> x,
                    std::span<Vector3> u);

}  // namespace quoin::solver
