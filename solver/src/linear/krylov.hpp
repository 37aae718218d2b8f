#pragma once
/// Minimal residual iteration for any regular matrix, with a preconditioner.

#include "linear/rigid_multigrid.hpp"

namespace quoin::solver {

struct KrylovOptions {
  double tolerance = 1e-8;     ///< of the residual, by that of zero
  int most = 60;               ///< iterations, and vectors kept
  StepWatch* watch = nullptr;  ///< looked at in each iteration, where there is one
};

struct KrylovResult {
  bool converged = false;
  int iterations = 0;
  double residual = 1.0;  ///< by that of zero
};

/// GMRES, preconditioned from the right by a cycle of a multigrid, without restart. Keeps its
/// memory.   [Saad & Schultz 1986]
template <int n>
class MinimalResidual {
 public:
  /// From zero.
  KrylovResult solve(RigidMultigrid<n>& multigrid, const Blocks<n>& right,
                     const KrylovOptions& options, Blocks<n>& solution);

 private:
  std::vector<double> orthogonalise(const Threads& threads, std::size_t count);

  std::vector<Blocks<n>> basis_;
  Blocks<n> preconditioned_;
  std::vector<double> pieces_;
};

}  // namespace quoin::solver
