#pragma once
/// Contact forces of one linearised step in which much slides, rocks and opens at once.
///
/// Gauss–Seidel sweeps from the last forces; contacts then yield by a share of their own Delassus
/// block where forces leave those of the sweeps; an interior point brings these soft contacts near
/// their solution, and a smoothed Newton method to the tolerance. See solver/README.md.

#include "moving/interior_point.hpp"
#include "moving/smoothed_newton.hpp"
#include "iteration/open_close.hpp"

namespace quoin::solver {

/// Keeps the memory between calls, and between linearisations of one step the forces about which
/// contacts yield.
class MovingContacts {
 public:
  explicit MovingContacts(const Slots& slots, StepWatch* watch = nullptr)
      : slots_(&slots), problem_(slots, watch) {}

  /// As OpenClose::solve, for contacts that ConeProblem::suits. `options.force_tolerance`: of the
  /// natural map, by the largest force.
  OpenCloseResult solve(const BlockSystem& base, const BlockVector& force,
                        std::span<LinearContact> contacts, const OpenCloseOptions& options,
                        BlockVector& increment);

 private:
  void start(std::span<const LinearContact> contacts, bool first);
  IterationCount solve_soft(double tolerance);
  double largest_yield() const;
  IterationCount iterate(double tolerance, double allowed_yield);
  void record(std::span<LinearContact> contacts);

  const Slots* slots_;
  ConeProblem problem_;
  InteriorPoint interior_point_;
  SmoothedNewton smoothed_newton_;
  std::vector<Vector3> x_, bar_, motion_, last_x_, last_bar_;
  std::vector<Vector3> bar_force_;  ///< N, by contact
  int iterations_left_ = 0;         ///< of this solve()
};

}  // namespace quoin::solver
