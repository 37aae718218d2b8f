/// The one process of `quoin`, which leaves a run on several to `quoin-mpi`.

#include <stdexcept>

#include "processes.hpp"

namespace quoin::commands {

bool Processes::are_known() { return false; }

Processes Processes::of_mpirun() {
  throw std::invalid_argument("--mpi: this quoin was built without PETSc (QUOIN_BUILD_PETSC)");
}

int Processes::rank() const { return 0; }
int Processes::count() const { return 1; }
int Processes::largest(int mine) const { return mine; }
std::string Processes::of_first(const std::string& mine) const { return mine; }
std::shared_ptr<solver::DistributedSolver> Processes::solver(const std::vector<int>&) {
  return nullptr;
}
int Processes::end_together(const Ending& ending) const { return ending.exit_code; }

}  // namespace quoin::commands
