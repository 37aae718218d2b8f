#pragma once
/// Contact forces of one linearised step in which much slides, rocks and opens at once.
///
/// Gauss–Seidel sweeps from the last forces, then the proximal Newton method on hard contacts;
/// where that does not end, contacts yield by a share of their own Delassus block, and a projection
/// closes the gaps that are left. See solver/README.md.

#include "iteration/open_close.hpp"
#include "iteration/proximal_newton.hpp"

namespace quoin::solver {

/// Forces that mend what contacts which yield have left open, each by a convex problem
///
///   min over D  1/2 Dᵀ K D + sum phi(A D)   with forces -phi' by contact:
///
/// Newton's method with an exact search along each step. A D of the problem, and the forces that
/// give it: the iterate of both projections.
class ConvexNewton {
 protected:
  void start(std::size_t contacts, const AddedForces& guess);
  /// By tangents_ and next_forces_, the forces at A D = 0 that go with these. `force(i, motion)`:
  /// of contact i at the motion A D. False: no step.
  template <class Force>
  bool step(ConeProblem& problem, const Force& force);

  std::vector<Vector3> moved_, forces_, next_moved_, next_forces_;
  std::vector<Matrix3> tangents_;
};

/// With x the forces found before and y = A D + c + |u_t| n by Coulomb's law, |u_t| as x leave
/// it, frozen:
///
///   min over D  1/2 Dᵀ K D - Fᵀ D + r/2 sum |P(x/r - y)|²,
///
/// the convex problem of cones in an augmented Lagrangian; its forces P(x - r y) lie in the cones
/// whatever the error of |u_t| is, and lose energy: x·u = -x_n |u_t| where y is in its cone, too.
class ConeProjection : ConvexNewton {
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
  bool take_step(ConeProblem& problem);

  std::span<const Vector3> x_;
  std::vector<Admissible> admissible_;           ///< limits of shear as x has them, frozen
  std::vector<Vector3> start_, trial_, pushed_;  ///< y of x, and as in trials() and forces()
};

/// Contact forces that friction does not follow, x the forces found before, e = 1/1000:
///
///   min over D  1/2 Dᵀ K D + 1/(2 e) sum min(g + A_n D - e x_n, 0)² + 1/2 sum_stick |t + A_t D|²,
///
/// g and t gaps and stretches of the anchors as x leaves them, of open contacts, too. A contact
/// that bears forces is closed, from either side, as long as it is still pressed; a bond always is,
/// without the min.
class GapProjection : ConvexNewton {
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
  void set_gaps(std::span<const Vector3> x, std::span<const ContactMode> modes,
                std::span<const Vector3> motion);
  Vector3 force(std::size_t contact, const Vector3& moved) const;
  double normal_force(std::size_t contact, double trial) const;
  bool pressed(std::size_t contact) const;
  double largest_gap(const ConeProblem& problem) const;
  double largest_stretch(const ConeProblem& problem) const;
  bool take_step(ConeProblem& problem, bool first);
  void update_multipliers();

  std::vector<Vector3> gap_;        ///< g and t
  std::vector<double> borne_;       ///< x_n
  std::vector<double> multiplier_;  ///< of the normal forces
  std::span<const Admissible> admissible_;
  std::vector<char> sticks_, closed_;
  bool changed_ = false;  ///< what is closed, in the last step
};

/// Keeps the memory between calls, and between linearisations of one step whether contacts yield.
class MovingContacts {
 public:
  explicit MovingContacts(const Slots& slots, StepWatch* watch = nullptr)
      : slots_(&slots), problem_(slots, watch) {}

  /// From the next solve() on.
  void use(const Threads& threads) { problem_.use(threads); }

  /// Other positions are next: none of theirs have yielded yet.
  void begin();

  /// As OpenClose::solve, for contacts that ConeProblem::suits. `options.force_tolerance`: of the
  /// natural map, by the largest force.
  OpenCloseResult solve(const BlockSystem& base, const BlockVector& force,
                        std::span<LinearContact> contacts, const OpenCloseOptions& options,
                        BlockVector& increment);

 private:
  const Admissible& admissible(std::size_t contact) const { return problem_.admissible()[contact]; }
  void start(std::span<const LinearContact> contacts, bool first);
  IterationCount iterate(double tolerance);
  IterationCount harden();
  IterationCount solve_soft(double tolerance);
  void record(std::span<LinearContact> contacts);
  bool apart() const;
  Vector3 to_mend(std::size_t contact, bool keeps_gaps) const;
  std::span<const Vector3> all_to_mend(bool keeps_gaps);
  struct Work {
    double sum = 0.0, parts = 0.0;  ///< J
  };
  Work work() const;
  AddedForces guess(std::span<const Vector3> added);
  IterationCount stiffen(std::span<LinearContact> contacts);
  double closed_share() const;
  double within_limit(double share) const;
  IterationCount project(const AddedForces& start, double gap, bool keeps_gaps);
  IterationCount close(std::span<LinearContact> contacts);
  IterationCount mend_yielded(std::span<LinearContact> contacts);
  IterationCount mend(std::span<LinearContact> contacts);

  const Slots* slots_;
  ConeProblem problem_;
  ProximalNewton newton_;
  ConeProjection cone_projection_;
  GapProjection projection_;
  std::vector<ContactMode> modes_;
  std::vector<Vector3> x_, bar_, motion_;
  std::vector<Vector3> added_, moved_;   ///< memory of guess(), close(), harden()
  std::vector<Vector3> apart_;           ///< of contacts, as they are to be mended
  std::vector<Vector3> yielded_forces_;  ///< x_ before it is mended
  // By contact, N, of the last linearisation; empty: it had none.
  std::vector<Vector3> bar_force_, stiffened_, closed_;
  double softness_ = 0.0;    ///< 0: contacts of this step do not yield
  bool yielded_ = false;     ///< contacts of the last positions did
  bool keeps_gaps_ = false;  ///< those that this step began with
  double gap_ = 0.0;         ///< m: what of gaps need not be mended
  double forces_ = 0.0;      ///< how good they are, of the largest
  int iterations_left_ = 0;  ///< of this solve()
};

}  // namespace quoin::solver
