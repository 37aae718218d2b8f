/// Linear solvers on matrices of walls: elimination, and PETSc's GAMG and block Jacobi
/// where PETSc is installed.
///
/// bench_linear_solvers [COLUMNS ROWS [WEAK]]: WEAK: share of the joints that are open, hinged or
/// without friction

#include <cstdio>
#include <cstdlib>

#include "linear/linear_solver.hpp"
#include "wall_tangent.hpp"

namespace {

using namespace quoin::solver;
using quoin::bench::LinearRun;
using quoin::bench::WallTangent;

LinearRun run(const WallTangent& wall) {
  LinearRun result;
  LinearSolver solver(wall.slots);
  const double start = quoin::bench::cpu_seconds();
  if (!solver.factorize(wall.system)) return result;
  result.set_up = quoin::bench::cpu_seconds() - start;
  BlockVector solution(wall.right.size(), Vector12::Zero());
  solver.solve(wall.right, solution);
  result.solve = quoin::bench::cpu_seconds() - start - result.set_up;
  result.residual = quoin::bench::relative_residual(wall, solution);
  return result;
}

void print(const char* name, const LinearRun& run) {
  std::printf("%-28s set-up %7.3f s, solution %7.3f s, %4d iterations, residual %.1e\n", name,
              run.set_up, run.solve, run.iterations, run.residual);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int columns = argc > 2 ? std::atoi(argv[1]) : 100,
            rows = argc > 2 ? std::atoi(argv[2]) : 100;
  const double weak = argc > 3 ? std::atof(argv[3]) : 0.0;
  const WallTangent wall = quoin::bench::wall_tangent(columns, rows, weak);
  const double work = quoin::solver::Multifrontal(wall.slots).work(wall.system);
  std::printf("%d bricks, %.0f %% of %zu joints weak, elimination: %.2g multiplications a brick\n",
              wall.slots.count(), 100.0 * weak, wall.system.pairs.size(),
              work / wall.slots.count());
  std::puts("CPU time");
  print("elimination", run(wall));
#ifdef QUOIN_BENCH_PETSC
  using quoin::bench::PetscPreconditioner;
  print("PETSc GAMG, CG", run_petsc(wall, PetscPreconditioner::Gamg));
  print("PETSc block Jacobi, CG", run_petsc(wall, PetscPreconditioner::BlockJacobi));
#endif
}
