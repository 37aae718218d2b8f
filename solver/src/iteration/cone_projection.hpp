#pragma once
/// Forces within their friction cones that bear what contacts which yield have left open.

#include "iteration/proximal_newton.hpp"

namespace quoin::solver {

/// With x the forces found before and y = A D + c + |u_t| n by Coulomb's law, |u_t| as x leave
/// it, frozen:
///
///   min over D  1/2 Dᵀ K D - Fᵀ D + r/2 sum |P(x/r - y)|²,
///
/// the convex problem of cones in an augmented Lagrangian; its forces P(x - r y) lie in the cones
/// whatever the error of |u_t| is, and lose energy: x·u = -x_n |u_t| where y is in its cone, too.
/// Newton's method with an exact search along each step.
class ConeProjection {
 public:
  /// `apart`: u as the blocks are with x, all that they start with counted. `guess`: where
  /// to start. `limit.residual`: of the forces, by the largest.
  IterationCount solve(ConeProblem& problem, std::span<const Vector3> x,
                       std::span<const Vector3> apart, const AddedForces& guess,
                       const IterationLimit& limit);
  /// x - r y by contact, and its projection: the forces.
  std::span<const Vector3> trials() const { return trial_; }
  std::span<const Vector3> forces() const { return pushed_; }

 private:
  void freeze(std::span<const Admissible> admissible);
  Vector3 trial(std::size_t contact, const Vector3& moved) const;
  double update_trials();
  bool find_step(ConeProblem& problem);
  double slope(double share) const;
  double find_share() const;

  std::span<const Vector3> x_;
  std::vector<Admissible> admissible_;           ///< limits of shear as x has them, frozen
  std::vector<Vector3> start_, moved_, change_;  ///< y of x, A D since, and the forces of that
  std::vector<Vector3> next_moved_, next_change_;
  std::vector<Vector3> trial_, pushed_;
  std::vector<Matrix3> tangents_;
};

}  // namespace quoin::solver
