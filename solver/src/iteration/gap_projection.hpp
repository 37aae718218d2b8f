#pragma once
/// Gaps and stretches that contact forces leave are mended by forces of their own.

#include "iteration/proximal_newton.hpp"

namespace quoin::solver {

/// Contact forces that friction does not follow, x the forces found before, e = 1/1000:
///
///   min over D  1/2 Dᵀ K D + 1/(2 e) sum min(g + A_n D - e x_n, 0)² + 1/2 sum_stick |t + A_t D|²,
///
/// g and t gaps and stretches of the anchors as x leaves them, of open contacts, too. A contact
/// that bears forces is closed, from either side, as long as it is still pressed; a bond always is,
/// without the min. The function is convex: Newton's method with an exact search along each step.
class GapProjection {
 public:
  /// `motion`: A D + c of `x`, whose `modes` they are, and what is mended of the gaps and stretches
  /// that c leaves out. `guess`: where to start. Ends where gaps are
  /// within `limit.residual`, m.
  IterationCount solve(ConeProblem& problem, std::span<const Vector3> x,
                       std::span<const ContactMode> modes, std::span<const Vector3> motion,
                       const AddedForces& guess, const IterationLimit& limit);
  /// By contact, to be added to x.
  std::span<const Vector3> forces() const { return forces_; }

 private:
  void start(const ConeProblem& problem, std::span<const Vector3> x,
             std::span<const ContactMode> modes, std::span<const Vector3> motion);
  void start_from(const AddedForces& guess);
  double normal_force(std::size_t contact, double trial) const;
  bool pressed(std::size_t contact) const;
  double largest_stretch(const ConeProblem& problem) const;
  double largest_gap(const ConeProblem& problem) const;
  bool find_step(ConeProblem& problem);
  double slope(double share) const;
  void take_step();
  void update_multipliers();

  std::vector<Vector3> gap_, moved_, forces_;  ///< g and t, A D, and the forces that give D
  std::vector<Vector3> next_moved_, next_forces_;
  std::vector<Matrix3> tangents_;
  std::vector<double> borne_;       ///< x_n
  std::vector<double> multiplier_;  ///< of the normal forces
  std::span<const Admissible> admissible_;
  std::vector<char> sticks_, closed_;
  bool changed_ = false;  ///< what is closed, in the last step
};

}  // namespace quoin::solver
