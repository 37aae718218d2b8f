/// Linear systems by rigid-body multigrid: what elimination finds.

#include <quoin/geometry/build.hpp>
#include <quoin/geometry/worker_pool.hpp>
#include <quoin/solver/simulation.hpp>

#include "solver/src/linear/linear_solver.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"
#include "support/sanitized.hpp"

using namespace quoin::solver;
using quoin::tests::Random;
using quoin::tests::unless_sanitized;

namespace {

enum class Bricks { Rigid, Deformable };

/// A running-bond wall with half bricks at its ends, leaning by `tilt` (rad, gravity turns).
Scene wall(int columns, int rows, Bricks bricks, double tilt) {
  Scene scene{.joint = {.friction_angle = 0.6}};
  scene.gravity = VectorOfTime(Vector3(9.81 * Vector3(std::sin(tilt), 0, -std::cos(tilt))));
  scene.add_fixed(quoin::geometry::make_box({-1, -1, -1}, {columns * 0.4 + 1.0, 1.2, 0}));
  for (int row = 0; row < rows; ++row) {
    const double shift = row % 2 == 0 ? 0.0 : 0.2;
    for (double x = -shift; x < columns * 0.4 - 0.01; x += 0.4) {
      const double left = std::max(x, 0.0), right = std::min(x + 0.4, columns * 0.4);
      const auto shape =
          quoin::geometry::make_box({left, 0, 0.2 * row}, {right, 0.2, 0.2 * (row + 1)});
      if (bricks == Bricks::Rigid) {
        scene.add_rigid(shape, {.density = 2600});
      } else {
        scene.add_block(shape, {.density = 2600, .young = 1e10});
      }
    }
  }
  return scene;
}

struct Run {
  State state;
  LinearSolverCounts counts;
};

Run run(const Scene& scene, LinearSolverKind kind, int steps, int threads = 1) {
  StepOptions options{.time_step = 5e-3, .linear_solver = kind};
  options.threads = threads;
  Simulation simulation(scene, options);
  Run result;
  for (int step = 0; step < steps; ++step) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    result.counts.set_ups += report.linear.set_ups;
    result.counts.eliminations += report.linear.eliminations;
    result.counts.iterations += report.linear.iterations;
  }
  result.state = simulation.state();
  return result;
}

double largest_difference(const State& a, const State& b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.blocks.size(); ++i) {
    worst = std::max(worst, (a.blocks[i].centroid - b.blocks[i].centroid).norm());
  }
  return worst;
}

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Blocks 6 wide in a ring with random couplings, diagonally dominant or not.
BlockSystem ring(Random& random, int count, double dominance) {
  BlockSystem system;
  system.symmetric = false;
  const auto draw = [&] {
    Matrix6 block;
    for (int k = 0; k < 36; ++k) block(k % 6, k / 6) = random.uniform(-1, 1);
    return block;
  };
  const auto blocks = static_cast<std::size_t>(count);
  system.diagonal.resize(blocks, 6);
  system.off_diagonal.resize(blocks - 1, 6);
  system.mirrored.resize(blocks - 1, 6);
  for (int i = 0; i < count; ++i) {
    system.diagonal[static_cast<std::size_t>(i)] = draw() + dominance * Matrix6::Identity();
    system.frames.push_back({Vector3(i, 0, 0), Matrix3::Identity()});
    if (i + 1 < count) system.pairs.emplace_back(i, i + 1);
  }
  for (std::size_t p = 0; p < system.pairs.size(); ++p) {
    system.off_diagonal[p] = draw();
    system.mirrored[p] = draw();
  }
  return system;
}

/// The same matrix, with couplings that are zero to so many neighbours: elimination is then dear.
BlockSystem widened(const BlockSystem& narrow, int neighbours) {
  BlockSystem wide = narrow;
  wide.pairs.clear();
  const int count = static_cast<int>(narrow.diagonal.size());
  for (int i = 0; i < count; ++i) {
    for (int j = i + 1; j <= std::min(i + neighbours, count - 1); ++j)
      wide.pairs.emplace_back(i, j);
  }
  wide.off_diagonal = wide.mirrored = SquareBlocks();
  wide.off_diagonal.resize(wide.pairs.size(), 6);
  wide.mirrored.resize(wide.pairs.size(), 6);
  for (std::size_t p = 0; p < wide.pairs.size(); ++p) {
    const auto [i, j] = wide.pairs[p];
    if (j != i + 1) {  // too small to change a bit, but not zero
      wide.off_diagonal[p].diagonal().setConstant(1e-60);
      continue;
    }
    wide.off_diagonal[p] = narrow.off_diagonal[static_cast<std::size_t>(i)];
    wide.mirrored[p] = narrow.mirrored[static_cast<std::size_t>(i)];
  }
  return wide;
}

}  // namespace

TEST_CASE("A wall moves as with elimination: standing, and with joints that open and slide") {
  for (const Bricks bricks : {Bricks::Rigid, Bricks::Deformable}) {
    for (const double tilt : {0.0, 0.7}) {
      CAPTURE(bricks == Bricks::Rigid, tilt);
      if (bricks == Bricks::Deformable && tilt > 0.0) continue;  // it takes seconds
      const Scene scene = wall(10, 12, bricks, tilt);
      const int steps = bricks == Bricks::Rigid ? 2 : 1;
      const Run exact = run(scene, LinearSolverKind::Elimination, steps);
      const Run iterated = run(scene, LinearSolverKind::Multigrid, steps);
      CHECK(exact.counts.set_ups == 0);
      CHECK(iterated.counts.set_ups > 0);
      CHECK(iterated.counts.iterations > 0);
      CHECK(iterated.counts.eliminations == 0);
      CHECK(largest_difference(exact.state, iterated.state) < 1e-10);
    }
  }
}

TEST_CASE("One large island takes all threads, which change no bit") {
  const Scene scene = wall(16, 33, Bricks::Rigid, 0.0);  // more than 512 blocks: two have a share
  const Run one = run(scene, LinearSolverKind::Elimination, 1);
  const Run two = run(scene, LinearSolverKind::Elimination, 1, 2);
  CHECK(two.counts.eliminations == one.counts.eliminations);
  bool same = true;
  for (std::size_t i = 0; i < one.state.blocks.size(); ++i) {
    same = same && two.state.blocks[i].centroid == one.state.blocks[i].centroid &&
           two.state.blocks[i].rotation.coeffs() == one.state.blocks[i].rotation.coeffs();
  }
  CHECK(same);
}

TEST_CASE("Any number of threads iterates to the same bits") {
  Random random(3);
  constexpr int count = 900;
  const Slots slots = make_slots(std::vector<int>(count, 6), std::vector<double>(count, 1.0));
  const BlockSystem system = ring(random, count, 15.0);
  const auto solved = [&](int threads) {
    quoin::geometry::WorkerPool pool(threads);
    LinearSolver solver(slots);
    solver.choose(LinearSolverKind::Multigrid);
    solver.use(Threads(&pool));
    REQUIRE(solver.factorize(system));
    BlockVector solution(count, Vector12::Zero());
    REQUIRE(solver.solve(BlockVector(count, Vector12::Ones()), solution));
    CHECK(solver.counts().fallbacks == 0);
    return solution;
  };
  const BlockVector one = solved(1);
  CHECK(solved(2) == one);
  CHECK(solved(3) == one);
}

TEST_CASE("Small systems are eliminated unless multigrid is asked for") {
  const Run chosen = run(wall(4, 3, Bricks::Rigid, 0.0), LinearSolverKind::Automatic, 1);
  CHECK(chosen.counts.eliminations > 0);
  CHECK(chosen.counts.set_ups == 0);
}

TEST_CASE("Where iterations do not converge the matrix is eliminated") {
  Random random(1);
  constexpr int count = 300;
  const Slots slots = make_slots(std::vector<int>(count, 6), std::vector<double>(count, 1.0));
  for (const double dominance : {20.0, 0.0}) {
    const BlockSystem system = ring(random, count, dominance);
    LinearSolver solver(slots);
    solver.choose(LinearSolverKind::Multigrid);
    REQUIRE(solver.factorize(system));
    BlockVector right(count, Vector12::Zero()), solution = right;
    for (Vector12& block : right) block.head<6>().setRandom();
    REQUIRE(solver.solve(right, solution));
    CHECK((solver.counts().fallbacks == 1) == (dominance == 0.0));
    double worst = 0.0;
    for (int i = 0; i < count; ++i) {
      const auto s = static_cast<std::size_t>(i);
      Vector6 left = system.diagonal[s] * solution[s].head<6>();
      if (i > 0) left += system.mirrored[s - 1] * solution[s - 1].head<6>();
      if (i + 1 < count) left += system.off_diagonal[s] * solution[s + 1].head<6>();
      worst = std::max(worst, (left - right[s].head<6>()).norm());
    }
    CHECK(worst < 1e-6);
  }
}

TEST_CASE("Matrices after one that iterations do not solve are eliminated, for a while") {
  Random random(1);
  constexpr int count = unless_sanitized(300, 150);
  const Slots slots = make_slots(std::vector<int>(count, 6), std::vector<double>(count, 1.0));
  const BlockSystem hard = widened(ring(random, count, 0.0), 60);
  LinearSolver solver(slots);
  solver.choose(LinearSolverKind::Automatic);
  BlockVector solution(count, Vector12::Zero());
  const auto take = [&](int matrices) {
    for (int k = 0; k < matrices; ++k) {
      REQUIRE(solver.factorize(hard));
      REQUIRE(solver.solve(BlockVector(count, Vector12::Ones()), solution));
    }
  };
  take(1);
  const BlockVector first = solution;
  CHECK(solver.counts().fallbacks == 1);
  take(8);
  CHECK(solver.counts().fallbacks == 1);
  CHECK(solver.counts().eliminations == 8);
  double difference = 0.0;
  for (std::size_t s = 0; s < first.size(); ++s) {
    difference = std::max(difference, (solution[s] - first[s]).norm() / first[s].norm());
  }
  CHECK(difference < 1e-8);
  const long before = solver.counts().fallbacks;
  take(60);
  CHECK(solver.counts().fallbacks > before);
  CHECK(solver.counts().fallbacks <= before + 4);
  const long tried = solver.counts().fallbacks;
  solver.forget();
  take(1);
  CHECK(solver.counts().fallbacks == tried + 1);
}

TEST_CASE("What was solved before changes no bit once it is forgotten") {
  Random random(2);
  constexpr int count = 300;
  const Slots slots = make_slots(std::vector<int>(count, 6), std::vector<double>(count, 1.0));
  const BlockSystem first = ring(random, count, 20.0), second = ring(random, count, 18.0);
  const BlockVector right(count, Vector12::Ones());
  const auto solved = [&](bool both) {
    BlockVector solution(count, Vector12::Zero());
    LinearSolver solver(slots);
    solver.choose(LinearSolverKind::Multigrid);
    if (both) {
      REQUIRE(solver.factorize(first));
      REQUIRE(solver.solve(right, solution));
      solver.forget();
    }
    REQUIRE(solver.factorize(second));
    REQUIRE(solver.solve(right, solution));
    return solution;
  };
  CHECK(solved(true) == solved(false));
}
