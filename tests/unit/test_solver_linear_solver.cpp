/// Elimination and linear solver against dense matrices of the same blocks.

#include <Eigen/Dense>
#include <quoin/geometry/worker_pool.hpp>
#include <set>

#include "solver/src/linear/linear_solver.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"

using namespace quoin::solver;
using namespace quoin::tests;

namespace {

enum class MatrixShape { Symmetric, General };

using Pairs = std::set<std::pair<int, int>>;

Pairs random_pairs(Random& random, int count, int couplings) {
  Pairs pairs;
  for (int c = 0; c < couplings; ++c) {
    const int i = static_cast<int>(random.uniform(0, count)),
              j = static_cast<int>(random.uniform(0, count));
    if (i != j) pairs.insert(std::minmax(i, j));
  }
  return pairs;
}

/// Neighbours in a square of `side` × `side`.
Pairs grid_pairs(int side) {
  Pairs pairs;
  for (int i = 0; i < side * side; ++i) {
    if (i % side + 1 < side) pairs.emplace(i, i + 1);
    if (i + side < side * side) pairs.emplace(i, i + side);
  }
  return pairs;
}

/// Blocks of 6 and 12 unknowns with random numbers; diagonally dominant.
struct Problem {
  Slots slots;
  BlockSystem system;

  Problem(Random& random, int count, int couplings, MatrixShape shape)
      : Problem(random, count, random_pairs(random, count, couplings), shape) {}

  Problem(Random& random, int count, const Pairs& pairs, MatrixShape shape) {
    std::vector<int> unknowns;
    for (int b = 0; b < count; ++b) unknowns.push_back(random.uniform(0, 1) < 0.5 ? 6 : 12);
    slots = make_slots(unknowns, std::vector<double>(unknowns.size(), 1.0));
    system.pairs.assign(pairs.begin(), pairs.end());
    system.symmetric = shape == MatrixShape::Symmetric;
    const auto draw = [&] {
      Matrix12 block;
      for (double& x : block.reshaped()) x = random.uniform(-1, 1);
      return block;
    };
    const int n = slots.width();
    system.diagonal.resize(slots.size.size(), n);
    system.off_diagonal.resize(pairs.size(), n);
    system.mirrored.resize(system.symmetric ? 0 : pairs.size(), n);
    for (std::size_t b = 0; b < slots.size.size(); ++b) {
      const Matrix12 block = draw();
      const Matrix12 symmetric = 0.5 * (block + block.transpose());
      const Matrix12 whole =
          (system.symmetric ? symmetric : block) +
          (12.0 * (static_cast<double>(pairs.size()) + 1.0)) * Matrix12::Identity();
      system.diagonal[b] = whole.topLeftCorner(n, n);
    }
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      system.off_diagonal[p] = draw().topLeftCorner(n, n);
      if (!system.symmetric) system.mirrored[p] = draw().topLeftCorner(n, n);
    }
  }

  Eigen::MatrixXd dense() const {
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(slots.unknowns(), slots.unknowns());
    for (std::size_t s = 0; s < slots.size.size(); ++s) {
      const int at = slots.start[s], size = slots.size[s];
      result.block(at, at, size, size) = system.diagonal[s].topLeftCorner(size, size);
    }
    for (std::size_t p = 0; p < system.pairs.size(); ++p) {
      const auto i = static_cast<std::size_t>(system.pairs[p].first);
      const auto j = static_cast<std::size_t>(system.pairs[p].second);
      const int rows = slots.size[i], columns = slots.size[j];
      const Eigen::MatrixXd upper = system.off_diagonal[p].topLeftCorner(rows, columns);
      result.block(slots.start[i], slots.start[j], rows, columns) = upper;
      result.block(slots.start[j], slots.start[i], columns, rows) =
          system.symmetric ? Eigen::MatrixXd(upper.transpose())
                           : Eigen::MatrixXd(system.mirrored[p].topLeftCorner(columns, rows));
    }
    return result;
  }

  BlockVector draw_right_side(Random& random) const {
    BlockVector right(slots.size.size(), Vector12::Zero());
    for (std::size_t s = 0; s < right.size(); ++s)
      for (int i = 0; i < slots.size[s]; ++i) right[s][i] = random.uniform(-1, 1);
    return right;
  }

  /// Largest residual of a solution, relative to the largest entry of the right-hand side.
  double error(Random& random, LinearSolver& solver) const {
    const BlockVector right = draw_right_side(random);
    BlockVector solution = right;
    Eigen::VectorXd b(slots.unknowns()), x(slots.unknowns());
    solver.solve(right, solution);
    for (std::size_t s = 0; s < right.size(); ++s) {
      b.segment(slots.start[s], slots.size[s]) = right[s].head(slots.size[s]);
      x.segment(slots.start[s], slots.size[s]) = solution[s].head(slots.size[s]);
    }
    return (dense() * x - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
  }
};

}  // namespace

TEST_CASE("Factors of random block matrices solve them") {
  Random random(1);
  for (const MatrixShape shape : {MatrixShape::Symmetric, MatrixShape::General}) {
    for (const auto& [count, couplings] : {std::pair{1, 0}, {2, 1}, {5, 3}, {30, 20}, {60, 150}}) {
      const Problem problem(random, count, couplings, shape);
      LinearSolver solver(problem.slots);
      REQUIRE(solver.factorize(problem.system));
      CHECK(problem.error(random, solver) < 1e-13);
      CHECK(solver.condition_estimate() >= 1.0);
    }
  }
}

TEST_CASE("One solver takes matrices of another pattern and another kind") {
  Random random(2);
  Problem first(random, 20, 30, MatrixShape::Symmetric),
      second(random, 20, 30, MatrixShape::General);
  second.slots = first.slots;  // the same blocks, coupled otherwise
  LinearSolver solver(first.slots);
  for (const Problem* problem : {&first, &second, &first}) {
    REQUIRE(solver.factorize(problem->system));
    CHECK(problem->error(random, solver) < 1e-13);
  }
}

TEST_CASE("Pairs that are zero take no part in an elimination") {
  Random random(6);
  for (const MatrixShape shape : {MatrixShape::Symmetric, MatrixShape::General}) {
    const Problem full(random, 60, 600, shape);
    Problem zeros = full, bare = full;
    bare.system.pairs.clear();
    std::size_t kept = 0;
    for (std::size_t p = 0; p < full.system.pairs.size(); ++p) {
      if (p % 3 != 0) {
        zeros.system.off_diagonal[p].setZero();
        if (!full.system.symmetric) zeros.system.mirrored[p].setZero();
        continue;
      }
      bare.system.pairs.push_back(full.system.pairs[p]);
      bare.system.off_diagonal[kept] = full.system.off_diagonal[p];
      if (!full.system.symmetric) bare.system.mirrored[kept] = full.system.mirrored[p];
      ++kept;
    }
    const BlockVector right = full.draw_right_side(random);
    BlockVector alone = right, beside = right;
    LinearSolver solver(full.slots);
    REQUIRE(solver.factorize(bare.system));
    REQUIRE(solver.solve(right, alone));
    for (const Problem* before : std::initializer_list<const Problem*>{&full, &bare, &zeros}) {
      LinearSolver again(full.slots);
      REQUIRE(again.factorize(before->system));
      CHECK(before->error(random, again) < 1e-13);
      REQUIRE(again.factorize(zeros.system));
      REQUIRE(again.solve(right, beside));
      CHECK(beside == alone);
    }
  }
}

TEST_CASE("Any number of threads eliminates to the same bits") {
  Random random(5);
  constexpr int kSide = 34;  // fronts that threads share
  for (const MatrixShape shape : {MatrixShape::Symmetric, MatrixShape::General}) {
    const Problem problem(random, kSide * kSide, grid_pairs(kSide), shape);
    const BlockVector right = problem.draw_right_side(random);
    const auto solved = [&](int threads) {
      quoin::geometry::WorkerPool pool(threads);
      LinearSolver solver(problem.slots);
      solver.use(Threads(&pool));
      BlockVector solution = right;
      for (int again = 0; again < 2; ++again) {
        REQUIRE(solver.factorize(problem.system));
        REQUIRE(solver.solve(right, solution));
      }
      CHECK(solver.condition_estimate() > 1.0);
      return std::pair(solution, solver.condition_estimate());
    };
    const auto one = solved(1);
    CHECK(solved(2) == one);
    CHECK(solved(3) == one);
  }
}

TEST_CASE("Threads say what cannot be factorized, and go on with what can") {
  Random random(7);
  constexpr int kSide = 34;
  Problem problem(random, kSide * kSide, grid_pairs(kSide), MatrixShape::Symmetric);
  quoin::geometry::WorkerPool pool(2);
  LinearSolver solver(problem.slots);
  solver.use(Threads(&pool));
  const BlockSystem sound = problem.system;
  for (const std::size_t block : {std::size_t{0}, std::size_t{kSide * kSide / 2 + kSide / 2}}) {
    problem.system = sound;
    problem.system.diagonal[block](2, 2) = -1.0;
    CHECK_FALSE(solver.factorize(problem.system));
  }
  problem.system = sound;
  REQUIRE(solver.factorize(problem.system));
  BlockVector right(problem.slots.size.size(), Vector12::Ones()), solution = right, again = right;
  REQUIRE(solver.solve(right, solution));
  LinearSolver alone(problem.slots);
  REQUIRE(alone.factorize(problem.system));
  REQUIRE(alone.solve(right, again));
  CHECK(solution == again);
}

TEST_CASE("Threads that are given after a factorization solve nothing before the next one") {
  Random random(8);
  constexpr int kSide = 40;
  const Problem problem(random, kSide * kSide, grid_pairs(kSide), MatrixShape::Symmetric);
  quoin::geometry::WorkerPool two(2), eight(8);
  LinearSolver solver(problem.slots);
  solver.use(Threads(&two));
  REQUIRE(solver.factorize(problem.system));
  BlockVector right(problem.slots.size.size(), Vector12::Ones()), solution = right, again = right;
  REQUIRE(solver.solve(right, solution));
  solver.use(Threads(&eight));
  REQUIRE(solver.solve(right, again));
  CHECK(again == solution);
}

TEST_CASE("What cannot be factorized is said") {
  Random random(3);
  Problem problem(random, 10, 12, MatrixShape::Symmetric);
  problem.system.diagonal[7](2, 2) = -1.0;
  CHECK_FALSE(LinearSolver(problem.slots).factorize(problem.system));
  Problem general(random, 1, 0, MatrixShape::General);
  general.system.diagonal[0].setZero();
  CHECK_FALSE(LinearSolver(general.slots).factorize(general.system));
}
