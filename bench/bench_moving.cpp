/// bench_moving SCENE.json CODE [--dt S] [--limit S]: runs a scene in which many rigid bodies move,
/// by one code, and judges its motion (motion_judge.hpp) every 5 ms. One JSON object on standard
/// output.
///
/// CODE: quoin, bullet:SWEEPS, ode:SWEEPS, ode:0 (its direct solver). --limit: CPU time of the
/// steps, s; quoin's step that runs into it does not count. Where that is the first, the time is 0
/// and cpu_ms_per_step what it has taken by then.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "guarded_main.hpp"
#include "motion_judge.hpp"
#include "rigid_scene_of_file.hpp"
#include "scene_file/run_scene.hpp"
#include "scene_file/study_grid.hpp"

namespace quoin::bench {
namespace {

constexpr double kLookEvery = 5e-3;  // s: all codes are judged at the same times

struct Arguments {
  std::string scene, code = "quoin";
  double time_step = 0.0, limit = 60.0;  // s; time_step 0: that of the scene
};

nlohmann::ordered_json run(const Arguments& arguments) {
  const scene_file::SceneFile file = scene_file::read_scene(arguments.scene, {});
  const RigidScene scene = rigid_scene(file);
  const Contestant who = contestant(arguments.code);
  const double dt = arguments.time_step > 0.0 ? arguments.time_step : file.options.time_step;
  const long steps = std::lround(file.stages[0].end_time / dt);
  const long look_every = std::max(1L, std::lround(kLookEvery / dt));
  MotionJudge judge(scene);
  const std::unique_ptr<World> world = who.make(scene, dt, who.iterations);
  judge.look(*world);
  double seconds = 0.0;
  long done = 0;
  bool ended = true, cut = false;
  while (ended && !cut && done < steps && seconds < arguments.limit) {
    const double start = scene_file::thread_seconds();
    const auto taken = [&] { return scene_file::thread_seconds() - start; };
    world->watch([&] {
      cut = seconds + taken() >= arguments.limit;
      return !cut;
    });
    ended = world->step(dt) || cut;
    if (!cut || done == 0) seconds += taken();
    if (!cut && ++done % look_every == 0) judge.look(*world);
  }
  nlohmann::ordered_json row;
  row["scene"] = file.title;
  row["code"] = who.name;
  row["time_step"] = dt;
  row["gave_up"] = !ended;
  row["time"] = static_cast<double>(done) * dt;
  row["whole"] = ended && done == steps;
  row["cpu_ms_per_step"] = 1e3 * seconds / static_cast<double>(std::max(done, 1L));
  row["overlap"] = judge.largest_overlap();
  row["energy_growth"] = judge.energy_growth();
  if (scene.gravity.isZero(0.0)) row["momentum_error"] = judge.momentum_error();
  row["factorizations_per_step"] =
      static_cast<double>(world->factorizations()) / static_cast<double>(std::max(done, 1L));
  return row;
}

int main_program(int argc, char** argv) {
  Arguments arguments;
  std::vector<std::string> words;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--dt" && i + 1 < argc)
      arguments.time_step = std::atof(argv[++i]);
    else if (argument == "--limit" && i + 1 < argc)
      arguments.limit = std::atof(argv[++i]);
    else
      words.push_back(argument);
  }
  if (words.size() != 2) {
    std::fprintf(stderr, "usage: %s SCENE.json CODE [--dt S] [--limit S]\n", argv[0]);
    return 2;
  }
  arguments.scene = words[0];
  arguments.code = words[1];
  return guarded(argv[0], [&] { std::printf("%s\n", run(arguments).dump().c_str()); });
}

}  // namespace
}  // namespace quoin::bench

int main(int argc, char** argv) { return quoin::bench::main_program(argc, argv); }
