#pragma once
/// Contact forces of one linearised step in which much slides, rocks and opens at once.
///
/// Gauss–Seidel sweeps from the last forces, then the proximal Newton method on hard contacts;
/// where that does not end, contacts yield by a share of their own Delassus block, and a projection
/// closes the gaps that are left. See solver/README.md.

#include "iteration/open_close.hpp"
#include "iteration/projections.hpp"

namespace quoin::solver {

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
  Vector3 to_mend(std::size_t contact) const;
  std::span<const Vector3> all_to_mend();
  struct Work {
    double sum = 0.0, parts = 0.0;  ///< J
  };
  Work work() const;
  AddedForces guess(std::span<const Vector3> added);
  IterationCount stiffen(std::span<LinearContact> contacts);
  double closed_share() const;
  double within_limit(double share) const;
  IterationCount project(const AddedForces& start, double gap);
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
