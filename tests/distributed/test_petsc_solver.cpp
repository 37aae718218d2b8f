/// PETSc on all ranks against elimination on one. Run by mpirun with 1, 2 and 4 ranks.

#include <limits>
#include <quoin/solver/parts.hpp>
#include <quoin/solver/ranks.hpp>

#include "solver/src/linear/linear_solver.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"

using namespace quoin::solver;
using quoin::tests::Random;

namespace {

const Ranks& ranks() {
  static const Ranks all;
  return all;
}

std::vector<int> rank_of_block(const BlockSystem& system) {
  std::vector<Vector3> places;
  for (const Frame& frame : system.frames) places.push_back(frame.place);
  const std::vector<double> weights(places.size(), 1.0);
  return bisect(places, weights, ranks().count());
}

std::shared_ptr<DistributedSolver> solver_of(const BlockSystem& system) {
  return petsc_solver(ranks(), rank_of_block(system));
}

enum class MatrixShape { Symmetric, General };

struct Problem {
  Slots slots;
  BlockSystem system;
  BlockVector right;
};

/// A sheet of blocks, each coupled with the next in its row and above it. `sizes`: unknowns, taken
/// in turn.
Problem sheet(int width, int height, const std::vector<int>& sizes, MatrixShape shape) {
  Random random(7);
  Problem problem;
  const int count = width * height;
  std::vector<int> unknowns;
  for (int b = 0; b < count; ++b)
    unknowns.push_back(sizes[static_cast<std::size_t>(b) % sizes.size()]);
  problem.slots = make_slots(unknowns, std::vector<double>(unknowns.size(), 1.0));
  BlockSystem& system = problem.system;
  system.symmetric = shape == MatrixShape::Symmetric;
  const auto draw = [&] {
    Matrix12 block;
    for (double& x : block.reshaped()) x = random.uniform(-1, 1);
    return block;
  };
  const int n = problem.slots.width();
  system.diagonal.resize(static_cast<std::size_t>(count), n);
  for (int b = 0; b < count; ++b) {
    const Matrix12 block = draw();
    const Matrix12 diagonal = Matrix12(block + block.transpose()) + 60.0 * Matrix12::Identity();
    system.diagonal[static_cast<std::size_t>(b)] = diagonal.topLeftCorner(n, n);
    system.frames.push_back({Vector3(b % width, 0, b / width), Matrix3::Identity()});
    if (b % width + 1 < width) system.pairs.emplace_back(b, b + 1);
    if (b + width < count) system.pairs.emplace_back(b, b + width);
    Vector12 force = Vector12::Zero();
    for (int i = 0; i < unknowns[static_cast<std::size_t>(b)]; ++i)
      force[i] = random.uniform(-1, 1);
    problem.right.push_back(force);
  }
  system.off_diagonal.resize(system.pairs.size(), n);
  system.mirrored.resize(system.symmetric ? 0 : system.pairs.size(), n);
  for (std::size_t p = 0; p < system.pairs.size(); ++p) {
    system.off_diagonal[p] = draw().topLeftCorner(n, n);
    if (!system.symmetric) system.mirrored[p] = draw().topLeftCorner(n, n);
  }
  return problem;
}

BlockVector eliminated(const Problem& problem) {
  LinearSolver solver(problem.slots);
  BlockVector solution(problem.right.size(), Vector12::Zero());
  REQUIRE(solver.factorize(problem.system));
  REQUIRE(solver.solve(problem.right, solution));
  return solution;
}

double largest_difference(const BlockVector& a, const BlockVector& b) {
  double worst = 0.0;
  for (std::size_t s = 0; s < a.size(); ++s)
    worst = std::max(worst, (a[s] - b[s]).cwiseAbs().maxCoeff<Eigen::PropagateNaN>());
  return worst;
}

/// Without what is another rank's alone: what is read there is seen.
BlockSystem own_rows(const BlockSystem& system, const Slots& slots) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  BlockSystem own = system;
  const std::vector<int> owners = rank_of_block(system);
  const auto is_own = [&](int slot) {
    const int block = slots.block_of_slot[static_cast<std::size_t>(slot)];
    return owners[static_cast<std::size_t>(block)] == ranks().rank();
  };
  for (std::size_t s = 0; s < own.diagonal.size(); ++s)
    if (!is_own(static_cast<int>(s))) own.diagonal[s].setConstant(kNone);
  for (std::size_t p = 0; p < own.pairs.size(); ++p) {
    if (is_own(own.pairs[p].first) || is_own(own.pairs[p].second)) continue;
    own.off_diagonal[p].setConstant(kNone);
    if (!own.symmetric) own.mirrored[p].setConstant(kNone);
  }
  return own;
}

}  // namespace

TEST_CASE("All ranks find what elimination finds, from their own rows") {
  using enum LinearSolverKind;
  for (const MatrixShape shape : {MatrixShape::Symmetric, MatrixShape::General}) {
    for (const std::vector<int>& sizes :
         {std::vector{6}, std::vector{12}, std::vector{6, 12, 12}}) {
      const Problem problem = sheet(11, 7, sizes, shape);
      const auto solver = solver_of(problem.system);
      const BlockVector exact = eliminated(problem);
      for (const LinearSolverKind kind : {Elimination, Multigrid, Elimination}) {
        CAPTURE(shape == MatrixShape::Symmetric, sizes.size(), sizes[0], kind == Multigrid);
        LinearSolverCounts counts;
        BlockVector solution(exact.size(), Vector12::Zero());
        const BlockSystem own = own_rows(problem.system, problem.slots);
        REQUIRE(solver->factorize(own, problem.slots, kind));
        REQUIRE(solver->solve(problem.right, solution, counts));
        CHECK(counts.fallbacks == 0);
        CHECK((counts.iterations > 0) == (kind == Multigrid));
        CHECK(largest_difference(solution, exact) < (kind == Multigrid ? 1e-8 : 1e-14));
      }
    }
  }
}

TEST_CASE("Fewer blocks than ranks, and another matrix of other blocks") {
  for (const int width : {1, 5, 2}) {
    const Problem problem = sheet(width, 1, {6}, MatrixShape::General);
    const auto solver = solver_of(problem.system);
    LinearSolverCounts counts;
    BlockVector solution;
    REQUIRE(solver->factorize(problem.system, problem.slots, LinearSolverKind::Elimination));
    REQUIRE(solver->solve(problem.right, solution, counts));
    CHECK(largest_difference(solution, eliminated(problem)) < 1e-14);
  }
}

TEST_CASE("What cannot be factorized is said on all ranks") {
  Problem problem = sheet(5, 4, {6}, MatrixShape::Symmetric);
  problem.system.diagonal[13](2, 2) = -1000.0;
  const auto solver = solver_of(problem.system);
  CHECK_FALSE(solver->factorize(problem.system, problem.slots, LinearSolverKind::Elimination));
  Problem singular = sheet(5, 4, {6}, MatrixShape::General);
  singular.system.diagonal.set_zero();
  singular.system.off_diagonal.set_zero();
  singular.system.mirrored.set_zero();
  CHECK_FALSE(solver->factorize(singular.system, singular.slots, LinearSolverKind::Elimination));
}

TEST_CASE("Where iterations do not converge the matrix is eliminated") {
  Problem problem = sheet(40, 20, {6}, MatrixShape::General);
  for (std::size_t b = 0; b < problem.right.size(); ++b)
    problem.system.diagonal[b] -= 60.0 * Eigen::MatrixXd::Identity(6, 6);
  const auto solver = solver_of(problem.system);
  LinearSolverCounts counts;
  BlockVector solution;
  REQUIRE(solver->factorize(problem.system, problem.slots, LinearSolverKind::Multigrid));
  REQUIRE(solver->solve(problem.right, solution, counts));
  CHECK(counts.fallbacks == 1);
  const BlockVector exact = eliminated(problem);
  double size = 0.0;
  for (const Vector12& block : exact) size = std::max(size, block.cwiseAbs().maxCoeff());
  CHECK(largest_difference(solution, exact) < 1e-9 * size);
}

TEST_CASE("Ranks that no longer take the same steps are noticed") {
  Problem problem = sheet(4, 4, {6}, MatrixShape::General);
  const auto solver = solver_of(problem.system);
  REQUIRE(solver->factorize(problem.system, problem.slots, LinearSolverKind::Elimination));
  problem.right[3][1] += ranks().rank();
  LinearSolverCounts counts;
  BlockVector solution;
  if (ranks().count() > 1)
    CHECK_THROWS_AS(solver->solve(problem.right, solution, counts), std::runtime_error);
  else
    CHECK(solver->solve(problem.right, solution, counts));
}

TEST_CASE("Parts are as many as asked for, equal, and in one piece of space") {
  std::vector<Vector3> points;
  for (int i = 0; i < 700; ++i) points.emplace_back(i % 20, 0, i / 20);
  std::vector<double> weights(points.size(), 1.0);
  for (const int parts : {1, 2, 3, 7}) {
    const std::vector<int> part_of = bisect(points, weights, parts);
    std::vector<int> size(static_cast<std::size_t>(parts), 0);
    for (const int part : part_of) ++size[static_cast<std::size_t>(part)];
    for (const int count : size) CHECK(std::abs(count - 700.0 / parts) <= 2.0);
  }
  weights.assign(points.size(), 0.0);
  weights.front() = weights.back() = 1.0;
  const std::vector<int> two = bisect(points, weights, 2);
  CHECK(two.front() == 0);
  CHECK(two.back() == 1);
}
