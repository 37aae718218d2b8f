#include <petscksp.h>

#include <algorithm>
#include <cstring>
#include <quoin/solver/ranks.hpp>

#include "base/index.hpp"
#include "linear/distributed_solver.hpp"
#include "petsc_call.hpp"

namespace quoin::solver {
namespace {

constexpr double kTolerance = 1e-8;  // of the residual
// GAMG takes up to 71 on walls of which 30 % of the joints are weak (bench/large.md).
constexpr int kMostIterations = 200;
constexpr int kMumpsRoom = 14;       // ICNTL: per cent of memory beyond what the analysis expects,
constexpr int kMumpsMoreRoom = 100;  // for rows that are exchanged
constexpr int kMumpsNegative = 12;   // INFOG: negative pivots of a symmetric matrix

/// Where the rows of a matrix stand: those of rank 0 first, of each rank as their slots.
struct RowPlaces {
  int width = 0;  ///< unknowns of a row, 6 or 12
  std::vector<int> block_of_slot;
  std::vector<int> row_of_slot;
  std::vector<int> own;                    ///< slots of this rank, ascending
  std::vector<std::pair<int, int>> pairs;  ///< of slots, that are coupled
  bool operator==(const RowPlaces&) const = default;
};

/// The same on all ranks where they have taken the same steps.
std::uint64_t fingerprint(const BlockVector& vector) {
  std::uint64_t hash = 14695981039346656037U;  // FNV-1a, by words
  for (const Vector12& block : vector) {
    for (const double value : block) {
      std::uint64_t bits = 0;
      std::memcpy(&bits, &value, sizeof bits);
      hash = (hash ^ bits) * 1099511628211U;
    }
  }
  return hash;
}

class PetscSolver : public DistributedSolver {
 public:
  PetscSolver(const Ranks& ranks, std::vector<int> rank_of_block)
      : ranks_(ranks), rank_of_block_(std::move(rank_of_block)) {
    // Point blocks are bodies. What PETSC_OPTIONS says comes first.
    PetscBool given = PETSC_FALSE;
    petsc(PetscOptionsHasName(nullptr, nullptr, "-quoin_mg_levels_pc_type", &given));
    if (given) return;
    petsc(PetscOptionsSetValue(nullptr, "-quoin_mg_levels_pc_type", "pbjacobi"));
  }

  bool factorize(const BlockSystem& system, const Slots& slots, LinearSolverKind kind) override;
  bool solve(const BlockVector& right, BlockVector& solution, LinearSolverCounts& counts) override;

 private:
  void set_matrix(const BlockSystem& system, const Slots& slots);
  void set_block(int row, int column, const Eigen::Ref<const Eigen::MatrixXd>& block);
  RowPlaces places(const BlockSystem& system, const Slots& slots) const;
  void make_matrix();
  void set_rigid_motions(std::span<const Frame> frames);
  void set_up_iterations();
  bool eliminate();
  bool converged(KSP solver, LinearSolverCounts& counts);
  void gather(BlockVector& solution);

  const Ranks& ranks_;
  std::vector<int> rank_of_block_;
  RowPlaces places_;
  bool symmetric_ = true, iterates_ = false;
  std::vector<int> size_;  ///< by slot: unknowns
  Petsc<Mat, MatDestroy> matrix_;
  Petsc<Vec, VecDestroy> right_, solution_, everything_;
  Petsc<VecScatter, VecScatterDestroy> to_all_;
  Petsc<KSP, KSPDestroy> iterations_, factors_;
};

/// Pairs of slots that are coupled; the others have no entry.
std::vector<std::size_t> coupled(const BlockSystem& system) {
  std::vector<std::size_t> result;
  for (std::size_t p = 0; p < system.pairs.size(); ++p) {
    const bool none =
        system.off_diagonal[p].isZero(0.0) && (system.symmetric || system.mirrored[p].isZero(0.0));
    if (!none) result.push_back(p);
  }
  return result;
}

RowPlaces PetscSolver::places(const BlockSystem& system, const Slots& slots) const {
  RowPlaces result{slots.width(), slots.block_of_slot, {}, {}, {}};
  std::vector<int> next(index(ranks_.count()) + 1, 0);  // first row of each rank
  for (const int block : slots.block_of_slot) ++next[index(rank_of_block_[index(block)]) + 1];
  for (std::size_t r = 1; r < next.size(); ++r) next[r] += next[r - 1];
  for (std::size_t s = 0; s < slots.block_of_slot.size(); ++s) {
    const int block = slots.block_of_slot[s];
    result.row_of_slot.push_back(next[index(rank_of_block_[index(block)])]++);
    if (rank_of_block_[index(block)] == ranks_.rank()) result.own.push_back(static_cast<int>(s));
  }
  for (const std::size_t p : coupled(system)) result.pairs.push_back(system.pairs[p]);
  return result;
}

/// An empty matrix with room for the entries of places_, and the vectors that go with it.
void PetscSolver::make_matrix() {
  const int own = static_cast<int>(places_.own.size());
  const int first = own > 0 ? places_.row_of_slot[index(places_.own.front())] : 0;
  std::vector<PetscInt> inside(index(own), 1), outside(index(own), 0);  // blocks of each own row
  const auto owns = [&](int row) { return row >= first && row < first + own; };
  for (const auto& [a, b] : places_.pairs) {
    const int i = places_.row_of_slot[index(a)], j = places_.row_of_slot[index(b)];
    if (owns(i)) ++(owns(j) ? inside : outside)[index(i - first)];
    if (owns(j)) ++(owns(i) ? inside : outside)[index(j - first)];
  }
  iterations_.reset();
  factors_.reset();
  petsc(MatCreate(PETSC_COMM_WORLD, matrix_.fresh()));
  petsc(MatSetSizes(matrix_.get(), own * places_.width, own * places_.width, PETSC_DETERMINE,
                    PETSC_DETERMINE));
  petsc(MatSetBlockSize(matrix_.get(), places_.width));
  petsc(MatSetType(matrix_.get(), MATAIJ));  // GAMG takes no other
  petsc(MatXAIJSetPreallocation(matrix_.get(), places_.width, inside.data(), outside.data(),
                                nullptr, nullptr));
  petsc(MatSetOption(matrix_.get(), MAT_ROW_ORIENTED, PETSC_FALSE));
  petsc(MatCreateVecs(matrix_.get(), solution_.fresh(), right_.fresh()));
  petsc(VecScatterCreateToAll(solution_.get(), to_all_.fresh(), everything_.fresh()));
}

/// `block`: of the slots `row` and `column`; unknowns that they lack have 1 on the diagonal.
void PetscSolver::set_block(int row, int column, const Eigen::Ref<const Eigen::MatrixXd>& block) {
  const int height = size_[index(row)], width = size_[index(column)];
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(places_.width, places_.width);
  values.topLeftCorner(height, width) = block.topLeftCorner(height, width);
  if (row == column) values.diagonal().tail(places_.width - height).setOnes();
  const PetscInt i = places_.row_of_slot[index(row)], j = places_.row_of_slot[index(column)];
  petsc(MatSetValuesBlocked(matrix_.get(), 1, &i, 1, &j, values.data(), INSERT_VALUES));
}

void PetscSolver::set_matrix(const BlockSystem& system, const Slots& slots) {
  RowPlaces next = places(system, slots);
  if (ranks_.largest(next == places_ ? 0 : 1) != 0) {
    places_ = std::move(next);
    make_matrix();
  }
  for (const int slot : places_.own) set_block(slot, slot, system.diagonal[index(slot)]);
  const auto owns = [&](int slot) {
    return rank_of_block_[index(places_.block_of_slot[index(slot)])] == ranks_.rank();
  };
  for (const std::size_t p : coupled(system)) {
    const auto [a, b] = system.pairs[p];
    if (owns(a)) set_block(a, b, system.off_diagonal[p]);
    if (!owns(b)) continue;
    system.symmetric ? set_block(b, a, system.off_diagonal[p].transpose())
                     : set_block(b, a, system.mirrored[p]);
  }
  petsc(MatAssemblyBegin(matrix_.get(), MAT_FINAL_ASSEMBLY));
  petsc(MatAssemblyEnd(matrix_.get(), MAT_FINAL_ASSEMBLY));
}

bool PetscSolver::factorize(const BlockSystem& system, const Slots& slots, LinearSolverKind kind) {
  size_ = slots.size;
  symmetric_ = system.symmetric;
  set_matrix(system, slots);
  petsc(MatSetOption(matrix_.get(), MAT_SYMMETRIC, symmetric_ ? PETSC_TRUE : PETSC_FALSE));
  iterates_ = kind == LinearSolverKind::Multigrid;
  if (!iterates_) return eliminate();
  set_rigid_motions(system.frames);
  set_up_iterations();
  return true;
}

/// All blocks as one rigid body, in six ways: what GAMG keeps in its coarse matrices.
void PetscSolver::set_rigid_motions(std::span<const Frame> frames) {
  Vector3 middle = Vector3::Zero();
  for (const Frame& frame : frames) middle += frame.place / static_cast<double>(frames.size());
  Vec* motions = nullptr;
  petsc(VecDuplicateVecs(solution_.get(), 6, &motions));
  for (int k = 0; k < 6; ++k) {
    petsc(VecZeroEntries(motions[k]));
    PetscScalar* values = nullptr;
    petsc(VecGetArray(motions[k], &values));
    for (std::size_t i = 0; i < places_.own.size(); ++i) {
      const Frame& frame = frames[index(places_.own[i])];
      const Vector3 turn = k < 3 ? Vector3(Vector3::Zero()) : Vector3(Vector3::Unit(k - 3));
      const Vector3 way =
          k < 3 ? Vector3(Vector3::Unit(k)) : Vector3(turn.cross(frame.place - middle));
      Eigen::Map<Eigen::Matrix<double, 6, 1>> row(values + i * index(places_.width));
      row << way, frame.rotation.transpose() * turn;
    }
    petsc(VecRestoreArray(motions[k], &values));
    for (int l = 0; l < k; ++l) {
      PetscScalar along = 0.0;
      petsc(VecDot(motions[k], motions[l], &along));
      petsc(VecAXPY(motions[k], -along, motions[l]));
    }
    petsc(VecNormalize(motions[k], nullptr));
  }
  MatNullSpace space = nullptr;
  petsc(MatNullSpaceCreate(PETSC_COMM_WORLD, PETSC_FALSE, 6, motions, &space));
  petsc(MatSetNearNullSpace(matrix_.get(), space));
  petsc(MatNullSpaceDestroy(&space));
  petsc(VecDestroyVecs(6, &motions));
}

/// Minimal residuals, for tangents with sliding contacts are unsymmetric, with GAMG from the right.
void PetscSolver::set_up_iterations() {
  if (iterations_.get() == nullptr) {
    petsc(KSPCreate(PETSC_COMM_WORLD, iterations_.fresh()));
    KSP solver = iterations_.get();
    petsc(KSPSetOptionsPrefix(solver, "quoin_"));
    petsc(KSPSetType(solver, KSPGMRES));
    petsc(KSPGMRESSetRestart(solver, kMostIterations));
    petsc(KSPSetPCSide(solver, PC_RIGHT));
    petsc(KSPSetNormType(solver, KSP_NORM_UNPRECONDITIONED));
    petsc(KSPSetTolerances(solver, kTolerance, 0.0, PETSC_DEFAULT, kMostIterations));
    PC preconditioner = nullptr;
    petsc(KSPGetPC(solver, &preconditioner));
    petsc(PCSetType(preconditioner, PCGAMG));
    petsc(KSPSetFromOptions(solver));
  }
  petsc(KSPSetOperators(iterations_.get(), matrix_.get(), matrix_.get()));
  petsc(KSPSetUp(iterations_.get()));
}

/// Factors of MUMPS: L D Lᵀ of a symmetric matrix, L U of another.
bool PetscSolver::eliminate() {
  petsc(KSPCreate(PETSC_COMM_WORLD, factors_.fresh()));
  KSP solver = factors_.get();
  petsc(KSPSetType(solver, KSPPREONLY));
  petsc(KSPSetOperators(solver, matrix_.get(), matrix_.get()));
  PC preconditioner = nullptr;
  petsc(KSPGetPC(solver, &preconditioner));
  petsc(PCSetType(preconditioner, symmetric_ ? PCCHOLESKY : PCLU));
  petsc(PCFactorSetMatSolverType(preconditioner, MATSOLVERMUMPS));
  petsc(PCFactorSetUpMatSolverType(preconditioner));
  Mat factors = nullptr;
  petsc(PCFactorGetMatrix(preconditioner, &factors));
  petsc(MatMumpsSetIcntl(factors, kMumpsRoom, kMumpsMoreRoom));
  petsc(KSPSetUp(solver));
  PCFailedReason failed = PC_NOERROR;
  petsc(PCGetFailedReason(preconditioner, &failed));
  PetscInt negative = 0;
  if (symmetric_) petsc(MatMumpsGetInfog(factors, kMumpsNegative, &negative));
  return ranks_.largest(failed != PC_NOERROR || negative > 0 ? 1 : 0) == 0;
}

/// The solution of right_ in solution_: is it one?
bool PetscSolver::converged(KSP solver, LinearSolverCounts& counts) {
  petsc(KSPSolve(solver, right_.get(), solution_.get()));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  petsc(KSPGetConvergedReason(solver, &reason));
  PetscInt iterations = 0;
  petsc(KSPGetIterationNumber(solver, &iterations));
  if (iterates_) counts.iterations += iterations;
  return ranks_.largest(reason > 0 ? 0 : 1) == 0;
}

bool PetscSolver::solve(const BlockVector& right, BlockVector& solution,
                        LinearSolverCounts& counts) {
  const auto print = static_cast<int>(fingerprint(right) & 0x3fffffff);
  if (ranks_.largest(print) != -ranks_.largest(-print))
    throw std::runtime_error("the ranks no longer take the same steps: are they of one build?");
  PetscScalar* values = nullptr;
  petsc(VecGetArray(right_.get(), &values));
  for (std::size_t i = 0; i < places_.own.size(); ++i) {
    const std::size_t slot = index(places_.own[i]);
    Eigen::Map<Eigen::VectorXd> row(values + i * index(places_.width), places_.width);
    row.setZero();
    row.head(size_[slot]) = right[slot].head(size_[slot]);
  }
  petsc(VecRestoreArray(right_.get(), &values));
  bool solved = converged(iterates_ ? iterations_.get() : factors_.get(), counts);
  if (!solved && iterates_) {
    ++counts.fallbacks;
    iterates_ = false;
    solved = eliminate() && converged(factors_.get(), counts);
  }
  solved ? gather(solution) : solution.assign(right.size(), Vector12::Zero());
  return solved;
}

/// All ranks get all of it.
void PetscSolver::gather(BlockVector& solution) {
  petsc(VecScatterBegin(to_all_.get(), solution_.get(), everything_.get(), INSERT_VALUES,
                        SCATTER_FORWARD));
  petsc(VecScatterEnd(to_all_.get(), solution_.get(), everything_.get(), INSERT_VALUES,
                      SCATTER_FORWARD));
  const PetscScalar* values = nullptr;
  petsc(VecGetArrayRead(everything_.get(), &values));
  solution.assign(size_.size(), Vector12::Zero());
  for (std::size_t s = 0; s < size_.size(); ++s) {
    const PetscScalar* row = values + index(places_.row_of_slot[s]) * index(places_.width);
    solution[s].head(size_[s]) = Eigen::Map<const Eigen::VectorXd>(row, size_[s]);
  }
  petsc(VecRestoreArrayRead(everything_.get(), &values));
}

}  // namespace

std::shared_ptr<DistributedSolver> petsc_solver(const Ranks& ranks,
                                                std::vector<int> rank_of_block) {
  return std::make_shared<PetscSolver>(ranks, std::move(rank_of_block));
}

}  // namespace quoin::solver
