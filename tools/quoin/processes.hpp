#pragma once
/// The processes of a run: this one, or all of an mpirun.

#include <memory>
#include <string>
#include <vector>

#include "ending.hpp"

namespace quoin::solver {
class DistributedSolver;
class Ranks;
}  // namespace quoin::solver

namespace quoin::commands {

/// What is marked "all" waits until every process has called it.
class Processes {
 public:
  Processes() = default;    ///< this one alone
  static bool are_known();  ///< this program was built with PETSc
  /// All. Throws std::invalid_argument where they are not known.
  static Processes of_mpirun();

  int rank() const;
  int count() const;
  bool is_first() const { return rank() == 0; }
  bool of_mpi() const { return ranks_ != nullptr; }

  int largest(int mine) const;                          ///< all; the same everywhere
  std::string of_first(const std::string& mine) const;  ///< all; what the first gave

  /// All. Linear systems on all of them; none where this one is alone. Lives as long as this
  /// object.
  std::shared_ptr<solver::DistributedSolver> solver(const std::vector<int>& rank_of_block);

  /// All, and the last thing to be called: one of those that failed says why. Where not all come
  /// here, since one failed while others work, that one ends them. Returns this process's exit
  /// code: the run's for the first, so that its output is not lost, 0 for the others.
  int end_together(const Ending& ending) const;

 private:
  std::shared_ptr<solver::Ranks> ranks_;
  std::shared_ptr<solver::DistributedSolver> solver_;  // not destroyed while others work
};

}  // namespace quoin::commands
