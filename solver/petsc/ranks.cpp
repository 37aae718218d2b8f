#include <petscsys.h>

#include <chrono>
#include <cstdlib>
#include <quoin/solver/ranks.hpp>
#include <stdexcept>
#include <thread>

#include "petsc_call.hpp"

namespace quoin::solver {
namespace {

MPI_Comm ends = MPI_COMM_NULL;  // of all_come() alone: what else is under way does not matter there

}  // namespace

Ranks::Ranks() {
  int given = 0;
  if (MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &given) != MPI_SUCCESS)
    throw std::runtime_error("MPI does not start");
  MPI_Comm_dup(MPI_COMM_WORLD, &ends);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &count_);
  petsc(PetscOptionsSetValue(nullptr, "-no_signal_handler", "true"));  // signals are the program's
  petsc(PetscInitializeNoArguments());
  petsc(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr));
}

Ranks::~Ranks() {
  PetscPopErrorHandler();
  PetscFinalize();
  MPI_Comm_free(&ends);
  MPI_Finalize();
}

int Ranks::rank() const { return rank_; }
int Ranks::count() const { return count_; }

int Ranks::largest(int mine) const {
  int all = mine;
  MPI_Allreduce(&mine, &all, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  return all;
}

std::string Ranks::of_first(const std::string& mine) const {
  auto size = static_cast<int>(mine.size());
  MPI_Bcast(&size, 1, MPI_INT, 0, MPI_COMM_WORLD);
  std::string text = mine;
  text.resize(static_cast<std::size_t>(size));
  MPI_Bcast(text.data(), size, MPI_CHAR, 0, MPI_COMM_WORLD);
  return text;
}

bool Ranks::all_come(double seconds) const {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibarrier(ends, &request);
  int come = 0;
  while (MPI_Test(&request, &come, MPI_STATUS_IGNORE) == MPI_SUCCESS && come == 0) {
    if (Clock::now() >= end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

void Ranks::end_all(int exit_code) const {
  MPI_Abort(MPI_COMM_WORLD, exit_code);
  std::abort();
}

}  // namespace quoin::solver
