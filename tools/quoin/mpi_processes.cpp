/// Processes of `quoin-mpi`.

#include <cstdio>
#include <limits>
#include <quoin/solver/ranks.hpp>

#include "processes.hpp"

namespace quoin::commands {

namespace {

// What processes that fail alike, by what a file says, may be apart, s.
constexpr double kPatience = 3.0;

}  // namespace

bool Processes::are_known() { return true; }

Processes Processes::of_mpirun() {
  Processes all;
  all.ranks_ = std::make_shared<solver::Ranks>();
  return all;
}

int Processes::rank() const { return ranks_ ? ranks_->rank() : 0; }
int Processes::count() const { return ranks_ ? ranks_->count() : 1; }
int Processes::largest(int mine) const { return ranks_ ? ranks_->largest(mine) : mine; }

std::string Processes::of_first(const std::string& mine) const {
  return ranks_ ? ranks_->of_first(mine) : mine;
}

std::shared_ptr<solver::DistributedSolver> Processes::solver(
    const std::vector<int>& rank_of_block) {
  if (ranks_) solver_ = solver::petsc_solver(*ranks_, rank_of_block);
  return solver_;
}

int Processes::end_together(const Ending& ending) const {
  const bool failed = !ending.message.empty();
  constexpr double kForEver = std::numeric_limits<float>::max();
  if (!ranks_->all_come(failed ? kPatience : kForEver)) {
    complain(
        "rank " + std::to_string(rank()) + " of " + std::to_string(count()) + ": " + ending.message,
        ending.subject);
    ranks_->end_all(ending.exit_code);
  }
  const int speaker = count() - largest(failed ? count() - rank() : 0);
  if (rank() == speaker) complain(ending.message, ending.subject);
  std::fflush(stdout);
  const int exit_code = largest(ending.exit_code);
  return is_first() ? exit_code : kDone;
}

}  // namespace quoin::commands
