#pragma once
/// Matrices of walls whose joints are closed, or partly open, hinged or without friction.

#include "block/block_system.hpp"

namespace quoin::bench {

struct WallTangent {
  solver::Slots slots;
  solver::BlockSystem system;
  solver::BlockVector right;  ///< what gravity and inertia push the bricks with
};

/// Stiffness of a running-bond wall of rigid bricks in a step of 0.01 s, contacts as stiff as the
/// solver's augmentation makes them. Of its joints the share `weak` is, by chance, a third each
/// open, a hinge (two contacts are left) or without friction.
WallTangent wall_tangent(int columns, int rows, double weak);

/// What a linear solver took, and what it left.
struct LinearRun {
  double set_up = 0.0, solve = 0.0;  ///< s of CPU
  int iterations = 0;
  double residual = 1.0;  ///< by that of zero
};

double cpu_seconds();
double relative_residual(const WallTangent& wall, const solver::BlockVector& solution);

/// Conjugate gradients with PETSc's GAMG, the six rigid motions of the wall as its near null space,
/// or with its point-block Jacobi.
enum class PetscPreconditioner { Gamg, BlockJacobi };
LinearRun run_petsc(const WallTangent& wall, PetscPreconditioner preconditioner);

}  // namespace quoin::bench
