#pragma once
/// One (sub-)step by the source's own method: Algorithm 1 of [Beyabanaki 2009], or its penalty
/// method.

#include <span>

#include "block/displacement.hpp"
#include "iteration/open_close.hpp"
#include "linear/linear_solver.hpp"
#include "step/step_attempt.hpp"

namespace quoin::solver {

/// The point-to-face contact of [Beyabanaki 2009], section 4: what its springs and its friction add
/// to the equations of the two blocks. A material point P1 of block i before a material point P0 of
/// the face of block j. After the increments D_i, D_j:   P0'P1' = between + T_i D_i - T_j D_j, d_n
/// = normal · P0'P1' (28).
struct PointToFace {
  Vector3 normal = Vector3::UnitZ();         ///< unit, out of block j; frozen over the step (23)
  Vector3 between = Vector3::Zero();         ///< P1 - P0 at the start of the step, m
  Matrix3x12 motion_i = Matrix3x12::Zero();  ///< T_i(P1)
  Matrix3x12 motion_j = Matrix3x12::Zero();  ///< T_j(P0), not T_j(P2): see solver/README.md
};

/// Forces on the two blocks, 12×1 each, N and N m.
struct ContactForces {
  Vector12 i = Vector12::Zero(), j = Vector12::Zero();
};

/// Second derivatives and, at D = 0, minus the first derivatives of an energy. K_ji = K_ijᵀ.
struct ContactBlocks {
  Matrix12 ii = Matrix12::Zero(), ij = Matrix12::Zero(), jj = Matrix12::Zero();
  ContactForces force;
};

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

/// Open–close iteration with the augmented Lagrangian inside, Algorithm 1 of [Beyabanaki 2009].
///
///   repeat                                        open–close iteration
///     lambda = 0 at every contact
///     repeat  solve K D = F,  lambda += Pn d_n    augmented Lagrangian iteration
///     until |Pn d_n| <= Tol1 and |K D_k - K D_k-1| <= Tol2 |K D_k-1|   (58)
///   until no tension, no penetration, and no contact that sticks beyond its strength or slides
///   back.
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

/// Attempts on all blocks of a scene, which have these slots. Normals and T(x) are those of the
/// start of the step, v' = 2D/dt - v.
class PaperMethod : public AttemptMethod {
 public:
  PaperMethod(const Slots& slots, StepWatch* watch) : open_close_(slots, watch) {}
  void attempt(const SubStep& step, std::span<const BodyContact> contacts, PhaseClock& clock,
               BlocksAtEnd& blocks, Attempt& attempt) override;

 private:
  BlockSystem base_;
  BlockVector force_;
  PaperOpenClose open_close_;
};

}  // namespace quoin::solver
