#pragma once
/// Open–close and multiplier iteration: the contact forces of one linearised step.
///
/// Find D and contact forces f with   K D = F + sum J^T f,   d = offset + J D   and, at each
/// contact, the law of joint_law.hpp. Source: [Alart & Curnier 1991] for the projected augmented
/// Lagrangian; see solver/README.md.

#include <algorithm>
#include <span>

#include "contact/linear_contact.hpp"
#include "linear_solver.hpp"

namespace quoin::solver {

struct OpenCloseOptions {
  double force_tolerance = 1e-10;  ///< relative to the forces at a block
  double gap_tolerance = 1e-12;    ///< m
  double gap_rounding = 0.0;  ///< m: a smaller gap or slip is zero for all that doubles can tell
  int max_iterations = 200;
  bool raise = false;      ///< augmentation where the gap falls slowly
  bool predicted = false;  ///< the first guess is no solution yet: blocks may stand instead
};

struct OpenCloseResult {
  bool converged = false;
  int iterations = 0;
  int solves = 0;
  int factorizations = 0;
  double residual = 0.0;  ///< relative force residual
  double condition = 0.0;
  double change = 0.0;  ///< largest motion of a block against the first guess, m
};

/// Pairs of slots that contacts couple, and which pair each contact belongs to.
void set_pairs(std::span<LinearContact> contacts, BlockSystem& base);

/// Keeps the memory between calls.
class OpenClose {
 public:
  /// `watch`: looked at in each iteration; solve() then throws StepStopped.
  explicit OpenClose(const Slots& slots, StepWatch* watch = nullptr)
      : slots_(&slots),
        rigid_(std::ranges::all_of(slots.size, [](int n) { return n == 6; })),
        watch_(watch),
        solver_(slots, watch) {}

  LinearSolver& linear_solver() { return solver_; }

  /// `base`: block terms (diagonal only) and the pairs that contacts couple. `increment`: in, the
  /// first guess; out, D. Contacts: multipliers in, forces and modes out.
  OpenCloseResult solve(const BlockSystem& base, const BlockVector& force,
                        std::span<LinearContact> contacts, const OpenCloseOptions& options,
                        BlockVector& increment);

 private:
  /// What a contact follows: the mode assumed at the start (no conditions are checked), or its law.
  enum class Law { Assumed, True };
  double stand(const BlockSystem& base, const BlockVector& force, std::span<LinearContact> contacts,
               double tolerance, BlockVector& guess);
  void shift(const BlockSystem& base, const BlockVector& force, std::span<LinearContact> contacts,
             const BlockVector& guess);
  template <int n>
  void shift_in(const BlockSystem& base, const BlockVector& force,
                std::span<LinearContact> contacts, const BlockVector& guess);
  void evaluate(const BlockSystem& base, std::span<LinearContact> contacts,
                const BlockVector& change, Law law);
  template <int n>
  void evaluate_in(const BlockSystem& base, std::span<LinearContact> contacts,
                   const BlockVector& change, Law law);
  double relative_residual() const;
  bool balanced(std::size_t slot, double tolerance) const;
  double slope(const BlockVector& direction) const;
  bool same_tangent(std::span<const LinearContact> contacts, Law law);
  void assemble(const BlockSystem& base, std::span<const LinearContact> contacts);
  template <int n>
  void add_contact(const LinearContact& contact, const Matrix3& tangent);
  bool newton_step(const BlockSystem& base, std::span<LinearContact> contacts, Law law,
                   OpenCloseResult& result);
  void move(const BlockSystem& base, std::span<LinearContact> contacts, Law law, double share);
  double squared_residual() const;
  void search_slope(const BlockSystem& base, std::span<LinearContact> contacts, Law law);
  void search_residual(const BlockSystem& base, std::span<LinearContact> contacts, Law law);
  bool relax(const BlockSystem& base, std::span<LinearContact> contacts, double tolerance,
             OpenCloseResult& result);
  double wanted_residual(std::span<const LinearContact> contacts,
                         const OpenCloseOptions& options) const;
  bool converge(const BlockSystem& base, std::span<LinearContact> contacts,
                const OpenCloseOptions& options, OpenCloseResult& result);
  bool settled(std::span<LinearContact> contacts, const OpenCloseOptions& options);
  static void raise_augmentation(std::span<LinearContact> contacts, double gap);
  double push_of_update(std::span<const LinearContact> contacts);
  static void update_multipliers(std::span<LinearContact> contacts);

  const Slots* slots_;
  bool rigid_;  ///< all blocks: 6 unknowns each
  StepWatch* watch_;
  LinearSolver solver_;
  BlockSystem system_;
  BlockVector right_;           ///< F - K0 guess
  BlockVector still_;           ///< zeros
  std::vector<char> stands_;    ///< by slot
  BlockVector change_, trial_;  ///< of the increment against the first guess
  BlockVector solved_;          ///< the last change that solved for its multipliers
  BlockVector residual_, step_;
  std::vector<double> scale_;  ///< force scale, per slot, N
  std::vector<double> floor_;  ///< what rounding makes of a residual, per slot, N
  std::vector<Matrix3> tangent_, next_tangent_;
  bool factorized_ = false;
  double last_gap_ = 0.0;  ///< violation when last solved, also by the last linearisation, m
  int most_ = 0;           ///< iterations of this solve()
  int updates_ = 0;        ///< of the multipliers, since the start of solve()
  int raises_ = 0;         ///< of the augmentation, since the start of solve()
  double softness_ = 1.0;  ///< of all contacts: share of their stiffness
  double rounding_ = 0.0;  ///< of gaps, m
};

}  // namespace quoin::solver
