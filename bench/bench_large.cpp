/// Running-bond walls under sudden gravity: time by phase, memory, and how far the answer is off.
///
/// bench_large rest COLUMNS ROWS [elimination|multigrid|automatic [STEPS [THREADS [YOUNG]]]]
/// bench_large peer COLUMNS ROWS CODE STEPS LIMIT
/// bench_large beside COLUMNS ROWS STEPS
///
/// `rest` and `peer` print one JSON object a step. `rest`: quoin with default options but for the
/// linear solver; YOUNG: of bricks that deform, Pa; 0: rigid. `peer`: CODE as in bench_moving;
/// LIMIT: CPU time of the steps, s. `beside`: CPU time of a step in which one block falls beside
/// the wall at rest, and of the block alone.

#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "guarded_main.hpp"
#include "scene_file/peak_memory.hpp"
#include "wall_scene.hpp"

namespace quoin::bench {
namespace {

constexpr double kTimeStep = 0.01;  // s

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Of a wall that has stood from the start: both are 0 of the exact answer.
struct Errors {
  double drift = 0.0;      ///< farthest way of a centroid, m
  double unbalance = 0.0;  ///< force on the base less the weight, by the weight
};

double weight_of(const RigidScene& scene) {
  double weight = 0.0;
  for (const RigidBody& body : scene.bodies) weight -= body.mass * scene.gravity.z();
  return weight;
}

Errors errors(const RigidScene& scene, const World& world) {
  Errors result;
  double reaction = 0.0;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Vector3d way = world.motion(static_cast<int>(b)).place - scene.bodies[b].place;
    if (!(way.norm() <= result.drift)) result.drift = way.norm();  // of NaN, too
  }
  for (const PairForce& pair : world.forces())
    if (pair.a == 0) reaction += pair.normal;
  result.unbalance = std::abs(reaction / weight_of(scene) - 1.0);
  return result;
}

Errors errors(const RigidScene& scene, const solver::State& state) {
  Errors result;
  double reaction = 0.0;
  for (std::size_t b = 1; b < scene.bodies.size(); ++b) {
    const Vector3d way = state.origin + state.blocks[b].centroid - scene.bodies[b].place;
    if (!(way.norm() <= result.drift)) result.drift = way.norm();  // of NaN, too
  }
  for (const solver::Contact& contact : state.contacts)
    if (contact.point.key.a == 0) reaction += contact.normal_force;
  result.unbalance = std::abs(reaction / weight_of(scene) - 1.0);
  return result;
}

/// Pairs of bricks that push each other.
std::size_t joints(const solver::State& state) {
  std::set<std::pair<int, int>> pairs;
  for (const solver::Contact& contact : state.contacts) {
    const auto& key = contact.point.key;
    if (key.a > 0 && contact.normal_force > 0.0) pairs.insert({key.a, key.b});
  }
  return pairs.size();
}

void print_start(const std::string& code, std::size_t bricks, int step, double cpu) {
  std::printf("{\"code\": \"%s\", \"bricks\": %zu, \"step\": %d, \"time\": %g, \"cpu_s\": %.4g, ",
              code.c_str(), bricks, step, step * kTimeStep, cpu);
}

/// JSON has no NaN and no infinity.
double finite(double error) {
  return std::isfinite(error) ? error : std::numeric_limits<double>::max();
}

void print_end(const Errors& errors, bool ended) {
  std::printf("\"drift\": %.4g, \"unbalance\": %.4g, \"ended\": %s}\n", finite(errors.drift),
              finite(errors.unbalance), ended ? "true" : "false");
  std::fflush(stdout);
}

void print_step(const solver::StepReport& report, const solver::State& state, int threads) {
  const solver::PhaseSeconds& s = report.seconds;
  std::printf(
      "\"threads\": %d, \"detect_s\": %.4g, \"assemble_s\": %.4g, \"solve_s\": %.4g, "
      "\"update_s\": %.4g, \"solves\": %d, \"eliminations\": %ld, \"set_ups\": %ld, "
      "\"iterations\": %ld, \"fallbacks\": %ld, \"joints\": %zu, "
      "\"peak_mb\": %.0f, ",
      threads, s.detect, s.assemble, s.solve, s.update, report.linear_solves,
      report.linear.eliminations, report.linear.set_ups, report.linear.iterations,
      report.linear.fallbacks, joints(state), scene_file::peak_memory_mb());
}

struct Rest {
  int columns = 0, rows = 0;
  std::string linear_solver = "automatic";
  int steps = 1, threads = 1;
  double young = 0.0;  // Pa
};

void rest(const Rest& wanted) {
  solver::StepOptions options{.time_step = kTimeStep};
  options.threads = wanted.threads;
  using enum solver::LinearSolverKind;
  bool known = false;
  for (const auto kind : {Automatic, Elimination, Multigrid}) {
    if (wanted.linear_solver != name(kind)) continue;
    options.linear_solver = kind;
    known = true;
  }
  if (!known) throw std::invalid_argument("no linear solver " + wanted.linear_solver);
  const RigidScene scene = wall(wanted.columns, wanted.rows);
  solver::Simulation simulation(wall_scene(wanted.columns, wanted.rows, wanted.young), options);
  double cpu = 0.0;
  for (int step = 1; step <= wanted.steps; ++step) {
    const double start = cpu_seconds();
    const solver::StepReport report = simulation.advance();
    cpu += cpu_seconds() - start;
    print_start("quoin", scene.bodies.size() - 1, step, cpu);
    print_step(report, simulation.state(), wanted.threads);
    print_end(errors(scene, simulation.state()), report.status == solver::StepStatus::Converged);
  }
}

void peer(int columns, int rows, const std::string& code, int steps, double limit) {
  const RigidScene scene = wall(columns, rows);
  const Contestant who = contestant(code);
  const std::unique_ptr<World> world = who.make(scene, kTimeStep, who.iterations);
  double cpu = 0.0;
  bool ended = true;
  for (int step = 1; step <= steps && ended && cpu < limit; ++step) {
    const double start = cpu_seconds();
    ended = world->step(kTimeStep);
    cpu += cpu_seconds() - start;
    print_start(who.name, scene.bodies.size() - 1, step, cpu);
    print_end(errors(scene, *world), ended);
  }
}

/// Microseconds a step; a block falls from 400 m. `columns` 0: alone.
double falling_step(int columns, int rows, int steps) {
  constexpr int kUntilRest = 6;
  solver::Scene scene = wall_scene(columns, rows);
  scene.add_rigid(geometry::make_box({-1.5, 0, 400}, {-1.1, 0.2, 400.2}), {.density = 2000});
  solver::Simulation simulation(scene, {.time_step = 5e-3});
  for (int step = 0; step < kUntilRest; ++step) static_cast<void>(simulation.advance());
  const double start = cpu_seconds();
  for (int step = 0; step < steps; ++step) static_cast<void>(simulation.advance());
  return 1e6 * (cpu_seconds() - start) / steps;
}

void run(const std::vector<std::string>& words) {
  const auto count = [&](std::size_t i) { return std::stoi(words.at(i)); };
  if (words.empty()) throw std::invalid_argument("which part: rest, peer or beside");
  const std::string& what = words[0];
  if (what == "peer")
    return peer(count(1), count(2), words.at(3), count(4), std::stod(words.at(5)));
  if (what == "beside") {
    std::printf("alone %.1f us a step, beside the wall %.1f us\n", falling_step(0, 0, count(3)),
                falling_step(count(1), count(2), count(3)));
    return;
  }
  if (what != "rest") throw std::invalid_argument("no part " + what);
  Rest wanted{.columns = count(1), .rows = count(2)};
  if (words.size() > 3) wanted.linear_solver = words[3];
  if (words.size() > 4) wanted.steps = count(4);
  if (words.size() > 5) wanted.threads = count(5);
  if (words.size() > 6) wanted.young = std::stod(words[6]);
  rest(wanted);
}

}  // namespace
}  // namespace quoin::bench

int main(int argc, char** argv) {
  return quoin::bench::guarded(argv[0], [&] { quoin::bench::run({argv + 1, argv + argc}); });
}
