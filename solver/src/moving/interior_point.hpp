#pragma once
/// Primal–dual interior point on softened contacts with the friction correction inside its matrix.

#include "moving/soft_contacts.hpp"

namespace quoin::solver {

/// Follows the central path x ∘ y = mu e to `limit.residual`, from inside of the cone near x.
/// Directions of [Nesterov & Todd 1997], steps of [Mehrotra 1992]; the |u_t| of the correction is
/// differentiated with the rest, so that the matrix is unsymmetric.
class InteriorPoint {
 public:
  IterationCount solve(ConeProblem& problem, const Softness& softness, const IterationLimit& limit,
                       std::vector<Vector3>& x);

 private:
  struct Contact {
    Matrix3 scale, inverse, force_per_motion, force_per_rest;
    Vector3 product, rest;
  };
  void start(ConeProblem& problem, const Softness& softness, std::vector<Vector3>& x);
  bool linearise(ConeProblem& problem, const Softness& softness, std::span<const Vector3> x);
  void find_step(ConeProblem& problem, const Softness& softness, std::span<const Vector3> x);
  void centre(double centring, bool second_order);
  double share_inside(std::span<const Vector3> x) const;
  double complementarity(std::span<const Vector3> x, double share) const;

  std::vector<Vector3> y_, u_, right_, motion_, step_x_, step_y_;
  std::vector<Vector3> target_;  ///< q of W dy + W⁻¹ dx = q
  std::vector<Contact> contacts_;
  std::vector<Matrix3> tangents_, slopes_;
  double complementarity_ = 0.0;  ///< mean x·y
};

}  // namespace quoin::solver
