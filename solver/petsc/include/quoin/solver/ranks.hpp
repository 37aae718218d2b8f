#pragma once
/// The processes of one `mpirun`, and linear systems that PETSc solves on all of them.

#include <memory>
#include <quoin/solver/simulation.hpp>
#include <string>
#include <vector>

namespace quoin::solver {

/// MPI and PETSc from here to the end of this object; one in a program. What is marked "all" waits
/// until every rank has called it.
class Ranks {
 public:
  /// All. Throws std::runtime_error when MPI or PETSc does not start.
  Ranks();
  ~Ranks();  ///< all
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  int rank() const;   ///< 0 … count() - 1
  int count() const;  ///< >= 1

  int largest(int mine) const;                          ///< all; the same everywhere
  std::string of_first(const std::string& mine) const;  ///< all; what rank 0 gave
  /// All, or some: true where every rank has called it, false after so many seconds.
  bool all_come(double seconds) const;
  /// Ends the processes of all ranks with this exit code.
  [[noreturn]] void end_all(int exit_code) const;

 private:
  int rank_ = 0, count_ = 1;
};

/// For StepOptions::distributed_solver. `rank_of_block`: by block of the scene, whose row each rank
/// gives (parts_of_blocks()). `ranks` must outlive it. All; and the last owner lets go of it on
/// all. Its matrices throw std::runtime_error with PETSc's own message when PETSc fails, and when
/// ranks no longer take the same steps.
std::shared_ptr<DistributedSolver> petsc_solver(const Ranks& ranks, std::vector<int> rank_of_block);

}  // namespace quoin::solver
