#include <petscksp.h>

#include "wall_tangent.hpp"

namespace quoin::bench {
namespace {

using namespace quoin::solver;

constexpr int kMostIterations = 1000;
constexpr double kTolerance = 1e-8;  // as the solver asks of its own iterations

Mat matrix_of(const BlockSystem& system) {
  const auto rows = static_cast<PetscInt>(system.diagonal.size());
  std::vector<PetscInt> entries(system.diagonal.size(), 1);  // blocks a row
  for (const auto& [i, j] : system.pairs) {
    ++entries[static_cast<std::size_t>(i)];
    ++entries[static_cast<std::size_t>(j)];
  }
  Mat matrix = nullptr;
  MatCreate(PETSC_COMM_SELF, &matrix);
  MatSetSizes(matrix, 6 * rows, 6 * rows, 6 * rows, 6 * rows);
  MatSetType(matrix, MATSEQAIJ);  // GAMG takes no other
  MatSetBlockSize(matrix, 6);
  MatXAIJSetPreallocation(matrix, 6, entries.data(), nullptr, nullptr, nullptr);
  const auto put = [&](PetscInt i, PetscInt j, const Eigen::Matrix<double, 6, 6>& block) {
    const Eigen::Matrix<double, 6, 6, Eigen::RowMajor> by_rows = block;
    MatSetValuesBlocked(matrix, 1, &i, 1, &j, by_rows.data(), INSERT_VALUES);
  };
  for (PetscInt i = 0; i < rows; ++i)
    put(i, i, system.diagonal[static_cast<std::size_t>(i)].topLeftCorner<6, 6>());
  for (std::size_t p = 0; p < system.pairs.size(); ++p) {
    const auto [i, j] = system.pairs[p];
    const Eigen::Matrix<double, 6, 6> block = system.off_diagonal[p].topLeftCorner<6, 6>();
    put(i, j, block);
    put(j, i, block.transpose());
  }
  MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY);
  MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY);
  return matrix;
}

/// The wall as one rigid body, in six ways.
void set_rigid_motions(const BlockSystem& system, Mat matrix) {
  Vec motions[6];
  for (int k = 0; k < 6; ++k) {
    MatCreateVecs(matrix, &motions[k], nullptr);
    PetscScalar* values = nullptr;
    VecGetArray(motions[k], &values);
    for (std::size_t i = 0; i < system.frames.size(); ++i) {
      const Frame& frame = system.frames[i];
      const Vector3 turn = k < 3 ? Vector3(Vector3::Zero()) : Vector3(Vector3::Unit(k - 3));
      const Vector3 way = k < 3 ? Vector3(Vector3::Unit(k)) : Vector3(turn.cross(frame.place));
      const Vector3 own = frame.rotation.transpose() * turn;
      for (int d = 0; d < 3; ++d) {
        values[6 * i + static_cast<std::size_t>(d)] = way[d];
        values[6 * i + 3 + static_cast<std::size_t>(d)] = own[d];
      }
    }
    VecRestoreArray(motions[k], &values);
    for (int l = 0; l < k; ++l) {
      PetscScalar along = 0.0;
      VecDot(motions[k], motions[l], &along);
      VecAXPY(motions[k], -along, motions[l]);
    }
    VecNormalize(motions[k], nullptr);
  }
  MatNullSpace space = nullptr;
  MatNullSpaceCreate(PETSC_COMM_SELF, PETSC_FALSE, 6, motions, &space);
  MatSetNearNullSpace(matrix, space);
  MatNullSpaceDestroy(&space);
  for (Vec& motion : motions) VecDestroy(&motion);
}

KSP make_solver(Mat matrix, PetscPreconditioner preconditioner) {
  KSP solver = nullptr;
  KSPCreate(PETSC_COMM_SELF, &solver);
  KSPSetType(solver, KSPCG);
  KSPSetOperators(solver, matrix, matrix);
  KSPSetNormType(solver, KSP_NORM_UNPRECONDITIONED);
  KSPSetTolerances(solver, kTolerance, 0.0, 1e30, kMostIterations);
  PC pc = nullptr;
  KSPGetPC(solver, &pc);
  PCSetType(pc, preconditioner == PetscPreconditioner::Gamg ? PCGAMG : PCPBJACOBI);
  KSPSetFromOptions(solver);
  return solver;
}

}  // namespace

LinearRun run_petsc(const WallTangent& wall, PetscPreconditioner preconditioner) {
  PetscInitializeNoArguments();
  LinearRun run;
  const double start = cpu_seconds();
  Mat matrix = matrix_of(wall.system);
  set_rigid_motions(wall.system, matrix);
  KSP solver = make_solver(matrix, preconditioner);
  Vec right = nullptr, solution = nullptr;
  MatCreateVecs(matrix, &solution, &right);
  PetscScalar* values = nullptr;
  VecGetArray(right, &values);
  for (std::size_t i = 0; i < wall.right.size(); ++i)
    for (int d = 0; d < 6; ++d) values[6 * i + static_cast<std::size_t>(d)] = wall.right[i][d];
  VecRestoreArray(right, &values);
  KSPSetUp(solver);
  run.set_up = cpu_seconds() - start;
  KSPSolve(solver, right, solution);
  run.solve = cpu_seconds() - start - run.set_up;
  PetscInt iterations = 0;
  KSPGetIterationNumber(solver, &iterations);
  run.iterations = static_cast<int>(iterations);
  BlockVector answer(wall.right.size(), Vector12::Zero());
  VecGetArray(solution, &values);
  for (std::size_t i = 0; i < answer.size(); ++i)
    for (int d = 0; d < 6; ++d) answer[i][d] = values[6 * i + static_cast<std::size_t>(d)];
  VecRestoreArray(solution, &values);
  run.residual = relative_residual(wall, answer);
  VecDestroy(&right);
  VecDestroy(&solution);
  KSPDestroy(&solver);
  MatDestroy(&matrix);
  return run;
}

}  // namespace quoin::bench
