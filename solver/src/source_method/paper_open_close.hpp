#pragma once
/// Open–close iteration with the augmented Lagrangian inside, Algorithm 1 of [Beyabanaki 2009].
///
///   repeat                                        open–close iteration
///     lambda = 0 at every contact
///     repeat  solve K D = F,  lambda += Pn d_n    augmented Lagrangian iteration
///     until |Pn d_n| <= Tol1 and |K D_k - K D_k-1| <= Tol2 |K D_k-1|   (58)
///   until no tension, no penetration, and no contact that sticks beyond its strength or slides
///   back.

#include <span>

#include "iteration/open_close.hpp"
#include "linear/linear_solver.hpp"
#include "source_method/point_to_face.hpp"

namespace quoin::solver {

struct PaperContact {
  int slot_i = -1, slot_j = -1;      ///< of the point's block and of the face's; -1: no unknowns
  int pair = -1;                     ///< off-diagonal block of (slot_i, slot_j); -1: none
  PointToFace normal;                ///< the contact point and its projection
  PointToFace shear;                 ///< the anchors of the shear spring
  Vector3 driven = Vector3::Zero();  ///< of both `between`: what prescribed motion adds, m
  double friction = 0.0;             ///< tan of the friction angle
  double cohesion = 0.0;             ///< C of (49), N
  double tension = 0.0;              ///< N

  ContactMode mode = ContactMode::Open;  ///< in: assumed; out: found
  double compression = 0.0;  ///< N, normal force, >= 0 while closed; in: that of the last step
  Vector3 direction =
      Vector3::Zero();              ///< of sliding of i on j, unit, or zero; in: of the last step
  double multiplier = 0.0;          ///< lambda, N
  double gap = 0.0;                 ///< out: d_n at the end of the step, m
  Vector3 slide = Vector3::Zero();  ///< out: tangential part of P0'P1' of the anchors, m
};

struct PaperOptions {
  double normal_stiffness = 0.0;  ///< Pn, N/m
  double shear_stiffness = 0.0;   ///< Ps, N/m
  bool multipliers = true;        ///< false: the penalty method, lambda stays 0
  bool sliding = true;            ///< false: closed contacts stick
  double tolerance = 1e-10;       ///< Tol2; Tol1 is this share of the largest normal force
  double rounding = 0.0;          ///< m: no gap is known better
  int max_solves = 1000;
};

class PaperOpenClose {
 public:
  /// `watch`: looked at before each solve; solve() then throws StepStopped.
  explicit PaperOpenClose(const Slots& slots, StepWatch* watch = nullptr)
      : slots_(&slots), watch_(watch), solver_(slots, watch) {}

  /// `base`: K of the blocks alone, and the pairs that contacts couple; `force`: F of the blocks
  /// alone. `increment`: result, D by slot. Ends after max_solves solves at the latest, then not
  /// converged.
  OpenCloseResult solve(const BlockSystem& base, const BlockVector& force,
                        std::span<PaperContact> contacts, const PaperOptions& options,
                        BlockVector& increment);

 private:
  void assemble(const BlockSystem& base, const BlockVector& force,
                std::span<const PaperContact> contacts, const PaperOptions& options);
  void add(const PaperContact& contact, const ContactBlocks& blocks);
  void set_right(std::span<const PaperContact> contacts);
  struct Change {
    double change, size;  ///< N
  };
  Change change_of_right() const;
  void solve_refined(BlockVector& increment);
  bool augment(std::span<PaperContact> contacts, const PaperOptions& options,
               BlockVector& increment, OpenCloseResult& result);

  const Slots* slots_;
  StepWatch* watch_;
  LinearSolver solver_;
  BlockSystem system_;
  BlockVector constant_;      ///< F but for multipliers and friction
  BlockVector right_, last_;  ///< F of this augmented Lagrangian iteration and of the last
  BlockVector rest_, correction_;
};

}  // namespace quoin::solver
