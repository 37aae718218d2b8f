/// Running-bond walls under sudden gravity, by each linear solver: time, iterations, memory.
///
/// bench_large [COLUMNS ROWS [elimination|multigrid|automatic [STEPS [THREADS [YOUNG]]]]]
/// bench_large beside COLUMNS ROWS STEPS
///
/// YOUNG: of bricks that deform, Pa; 0: rigid. `beside`: CPU time of a step in which one block
/// falls beside the wall at rest, and of the block alone.

#include <sys/resource.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

#include "wall_scene.hpp"

namespace {

namespace solver = quoin::solver;

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

/// Microseconds a step; a block falls from 400 m. `columns` 0: alone.
double falling_step(int columns, int rows, int steps) {
  constexpr int kUntilRest = 6;
  solver::Scene scene = quoin::bench::wall_scene(columns, rows);
  scene.add_rigid(quoin::geometry::make_box({-1.5, 0, 400}, {-1.1, 0.2, 400.2}), {.density = 2000});
  solver::Simulation simulation(scene, {.time_step = 5e-3});
  for (int step = 0; step < kUntilRest; ++step) static_cast<void>(simulation.advance());
  const double start = cpu_seconds();
  for (int step = 0; step < steps; ++step) static_cast<void>(simulation.advance());
  return 1e6 * (cpu_seconds() - start) / steps;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 5 && std::string(argv[1]) == "beside") {
    const int steps = std::atoi(argv[4]);
    std::printf("alone %.1f us a step, beside the wall %.1f us\n", falling_step(0, 0, steps),
                falling_step(std::atoi(argv[2]), std::atoi(argv[3]), steps));
    return 0;
  }
  const int columns = argc > 2 ? std::atoi(argv[1]) : 40, rows = argc > 2 ? std::atoi(argv[2]) : 25;
  const std::string wanted = argc > 3 ? argv[3] : "automatic";
  const int steps = argc > 4 ? std::atoi(argv[4]) : 4;
  solver::StepOptions options{.time_step = 0.01};
  options.threads = argc > 5 ? std::atoi(argv[5]) : 1;
  const double young = argc > 6 ? std::atof(argv[6]) : 0.0;
  for (const auto kind :
       {solver::LinearSolverKind::Elimination, solver::LinearSolverKind::Multigrid}) {
    if (wanted == name(kind)) options.linear_solver = kind;
  }
  solver::Simulation simulation(quoin::bench::wall_scene(columns, rows, young), options);
  const std::size_t bricks = simulation.state().blocks.size() - 1;
  std::printf("%zu bricks, %s\n", bricks, wanted.c_str());
  const double start = cpu_seconds();
  for (int step = 0; step < steps; ++step) {
    const solver::StepReport report = simulation.advance();
    std::printf(
        "step %d: CPU %.2f s since the start; detect %.2f assemble %.2f solve %.2f update %.2f s; "
        "%d solves, %ld eliminations, %ld set-ups, %ld iterations, %ld fallbacks, complexity %.2f, "
        "peak %.0f MB, %s\n",
        step + 1, cpu_seconds() - start, report.seconds.detect, report.seconds.assemble,
        report.seconds.solve, report.seconds.update, report.linear_solves,
        report.linear.eliminations, report.linear.set_ups, report.linear.iterations,
        report.linear.fallbacks, report.linear.complexity, peak_megabytes(),
        describe(report).c_str());
    std::fflush(stdout);
  }
}
