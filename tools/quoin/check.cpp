/// quoin check SCENE.json

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <quoin/geometry/contact_finder.hpp>
#include <quoin/geometry/mass_properties.hpp>

#include "commands.hpp"
#include "in_range.hpp"
#include "marks.hpp"
#include "scene_file/peak_memory.hpp"
#include "scene_file/points_outside.hpp"
#include "scene_file/run_scene.hpp"
#include "stop.hpp"

namespace quoin::commands {
namespace {

using json = nlohmann::ordered_json;
using geometry::ContactPoint;
using geometry::Vector3;
using scene_file::SceneFile;
using solver::BlockKind;

struct CheckArguments {
  std::string scene;
  std::vector<std::string> changes;
  double max_seconds = 60.0;  // for the step that is tried, wall time
  bool json = false;
};

/// Of the diameter of the smaller block of a pair. Within the first it touches (as far as a face
/// may be off its plane, geometry::kFlatness); an overlap above the second is what the solver
/// refuses; a gap up to the third is worth a line.
constexpr double kTouching = 1e-6;
constexpr double kRefused = 1e-3;
constexpr double kNear = 1e-2;

double size(const solver::Block& block) {
  const geometry::Box box = block.body().box();
  return (box.max - box.min).norm();
}

bool is_there(const solver::Block& block) { return block.kind != BlockKind::Absent; }

bool is_free(const solver::Block& block) {
  return block.kind == BlockKind::Deformable || block.kind == BlockKind::Rigid;
}

/// Two blocks near each other at the start.
struct PairStart {
  int a = 0, b = 0;
  geometry::ContactType type = geometry::ContactType::VertexVertex;
  int points = 0;
  double gap = 0.0;   ///< least, m
  double area = 0.0;  ///< m2
  double size = 0.0;  ///< of the smaller block, m
  bool touches() const { return gap <= kTouching * size; }
  bool overlaps() const { return gap < -kTouching * size; }
};

std::vector<PairStart> pairs_at_start(const solver::Scene& scene) {
  double largest = 0.0;
  for (const solver::Block& block : scene.blocks)
    largest = std::max(largest, is_free(block) ? size(block) : 0.0);
  geometry::ContactFinder finder({.reach = kNear * largest});
  std::vector<int> owners;  // by handle
  for (const solver::Block& block : scene.blocks) {
    const auto motion = is_free(block) ? geometry::BodyMotion::Moving : geometry::BodyMotion::Idle;
    std::vector<geometry::CompoundPart> parts;
    for (const geometry::Shape& part : block.convex_parts())
      parts.push_back({std::shared_ptr<const geometry::Shape>(block.shape, &part)});
    const int body = block.parts ? finder.add_compound(parts, block.placement, {.motion = motion})
                                 : finder.add(block.shape, block.placement, {.motion = motion});
    owners.resize(owners.size() + parts.size(), static_cast<int>(&block - scene.blocks.data()));
    if (!is_there(block)) finder.remove(body);
  }
  std::vector<ContactPoint> points;
  finder.find(points);
  for (ContactPoint& point : points)
    for (int* name : {&point.key.a, &point.key.b}) *name = owners[static_cast<std::size_t>(*name)];
  std::ranges::sort(points, {}, &ContactPoint::key);
  std::vector<PairStart> pairs;
  for (const ContactPoint& point : points) {
    if (pairs.empty() || pairs.back().a != point.key.a || pairs.back().b != point.key.b) {
      const double smaller = std::min(size(scene.blocks[static_cast<std::size_t>(point.key.a)]),
                                      size(scene.blocks[static_cast<std::size_t>(point.key.b)]));
      pairs.push_back({point.key.a, point.key.b, point.type, 0, point.gap, 0.0, smaller});
    }
    PairStart& pair = pairs.back();
    ++pair.points;
    pair.gap = std::min(pair.gap, point.gap);
    pair.area += point.area;
  }
  std::erase_if(pairs, [](const PairStart& pair) { return pair.gap > kNear * pair.size; });
  return pairs;
}

/// Free blocks that no chain of touching blocks joins to a fixed or prescribed one or a fixed
/// point.
std::vector<int> without_support(const solver::Scene& scene, const std::vector<PairStart>& pairs) {
  std::vector<std::vector<int>> touching(scene.blocks.size());
  for (const PairStart& pair : pairs) {
    if (pair.touches()) {
      touching[static_cast<std::size_t>(pair.a)].push_back(pair.b);
      touching[static_cast<std::size_t>(pair.b)].push_back(pair.a);
    }
  }
  std::vector<char> held(scene.blocks.size(), 0);
  std::vector<int> open;
  const auto hold = [&](int block) {
    if (!held[static_cast<std::size_t>(block)]) {
      held[static_cast<std::size_t>(block)] = 1;
      open.push_back(block);
    }
  };
  for (int b = 0; b < std::ssize(scene.blocks); ++b)
    if (!is_free(scene.blocks[static_cast<std::size_t>(b)])) hold(b);
  for (const solver::FixedPoint& point : scene.fixed_points) hold(point.block);
  while (!open.empty()) {
    const int block = open.back();
    open.pop_back();
    std::ranges::for_each(touching[static_cast<std::size_t>(block)], hold);
  }
  std::vector<int> loose;
  for (int b = 0; b < std::ssize(held); ++b)
    if (!held[static_cast<std::size_t>(b)]) loose.push_back(b);
  return loose;
}

json outside_json(const SceneFile& file) {
  json outside = json::array();
  for (const scene_file::PointOutside& found : scene_file::points_outside(file)) {
    const Vector3& point = found.point;
    outside.push_back({{"what", found.what},
                       {"block", found.block},
                       {"point", {point.x(), point.y(), point.z()}}});
  }
  return outside;
}

json blocks_json(const solver::Scene& scene) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  int count[5] = {0, 0, 0, 0, 0};
  double mass = 0.0;
  geometry::Box box{Vector3::Constant(kInfinite), Vector3::Constant(-kInfinite)};
  for (const solver::Block& block : scene.blocks) {
    ++count[static_cast<int>(block.kind)];
    if (!is_there(block)) continue;
    mass += is_free(block) ? block.material.density * geometry::mass_properties(block.body()).volume
                           : 0.0;
    const geometry::Box own = block.body().box();
    box.min = box.min.cwiseMin(own.min);
    box.max = box.max.cwiseMax(own.max);
  }
  const Vector3 weight = mass * scene.gravity.at(0.0);
  return {{"deformable", count[0]},
          {"rigid", count[1]},
          {"fixed", count[2]},
          {"prescribed", count[3]},
          {"absent", count[4]},
          {"mass", mass},
          {"weight", {weight.x(), weight.y(), weight.z()}},
          {"min", {box.min.x(), box.min.y(), box.min.z()}},
          {"max", {box.max.x(), box.max.y(), box.max.z()}}};
}

json pair_json(const solver::Scene& scene, const PairStart& pair) {
  return {{"a", scene.blocks[static_cast<std::size_t>(pair.a)].name},
          {"b", scene.blocks[static_cast<std::size_t>(pair.b)].name},
          {"gap", pair.gap}};
}

json contacts_json(const solver::Scene& scene, std::vector<PairStart> pairs) {
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const PairStart& a, const PairStart& b) { return a.gap < b.gap; });
  json types = json::object();
  json overlaps = json::array(), gaps = json::array();
  double area = 0.0;
  int touching = 0, points = 0;
  for (const PairStart& pair : pairs) {
    if (pair.touches()) {
      const std::string type(name(pair.type));
      types[type] = types.value(type, 0) + 1;
      area += pair.area;
      ++touching;
      points += pair.points;
    }
    if (pair.overlaps())
      overlaps.push_back(pair_json(scene, pair));
    else if (!pair.touches())
      gaps.push_back(pair_json(scene, pair));
  }
  return {{"pairs", touching}, {"points", points},     {"area", area},
          {"types", types},    {"overlaps", overlaps}, {"gaps", gaps}};
}

/// First elastic frequency of the stiffest block by its time step: omega = pi c / size with c =
/// sqrt(E / rho), a bar held at neither end; damping ratio omega dt / 4 of the scheme that takes
/// forces at the end of the step. [Doolin & Sitar 2004]
json time_step_json(const SceneFile& file, const solver::Scene& scene,
                    const solver::StepReport& trial) {
  double omega = 0.0, smallest = std::numeric_limits<double>::infinity();
  for (const solver::Block& block : scene.blocks) {
    if (is_free(block)) smallest = std::min(smallest, size(block));
    if (block.kind == BlockKind::Deformable) {
      omega = std::max(omega, std::numbers::pi / size(block) *
                                  std::sqrt(block.material.young / block.material.density));
    }
  }
  const double dt = file.stages.at(0).time_step;
  const bool damps = file.options.scheme == solver::TimeScheme::ConstantAcceleration;
  const double fall = scene.gravity.at(0.0).norm() * dt * dt;
  return {{"time_step", dt},
          {"elastic_omega_dt", omega * dt},
          {"elastic_damping", damps ? 0.25 * omega * dt : 0.0},
          {"contact_omega_dt", trial.stiffest_omega_dt},
          {"contact_damping", trial.numerical_damping},
          {"fall_in_a_step_by_smallest_block", std::isfinite(smallest) ? fall / smallest : 0.0}};
}

/// Steps that the stages take, those until rest by their limit.
long most_steps(const SceneFile& file) {
  long steps = 0;
  double reached = 0.0;
  for (const scene_file::Stage& stage : file.stages) {
    if (stage.analysis == solver::Analysis::Dynamic) {
      const double seconds = stage.end_time > 0 ? stage.end_time - reached : stage.duration;
      const long taken =
          stage.steps.value_or(std::lround(std::ceil(seconds / stage.time_step - 1e-9)));
      steps += taken;
      reached += stage.steps ? static_cast<double>(taken) * stage.time_step : seconds;
    } else {
      steps += stage.steps.value_or(stage.max_steps);
    }
  }
  return steps;
}

/// The first step of a run, and what that says of it.
struct TriedStep {
  solver::StepReport step{.status = solver::StepStatus::Stopped};
  std::string message;
  std::vector<std::string> left_out;
};

TriedStep try_step(const SceneFile& file, double max_seconds) {
  TriedStep trial;
  const auto converged = [&] { return trial.step.status == solver::StepStatus::Converged; };
  scene_file::RunOptions options;
  options.after_step = [&](const scene_file::StepView& view, const scene_file::SaveRun&) {
    trial.step = view.report;
  };
  options.stop = [&converged, out_of_time = StopRequest(max_seconds)] {
    return converged() ? scene_file::RunStatus::Interrupted : out_of_time();
  };
  const scene_file::RunResult result = run_scene(file, options);
  trial.message = converged() ? describe(trial.step) : result.message;
  trial.left_out = result.left_out;
  return trial;
}

/// One step tried tells how long steps take, and the memory in use by then what the run needs.
json trial_json(const SceneFile& file, const TriedStep& tried) {
  const solver::StepReport& trial = tried.step;
  const solver::PhaseSeconds& seconds = trial.seconds;
  const double step = seconds.detect + seconds.assemble + seconds.solve + seconds.update;
  const long steps = most_steps(file);
  return {{"converged", trial.status == solver::StepStatus::Converged},
          {"message", tried.message},
          {"step_seconds", step},
          {"most_steps", steps},
          {"most_seconds", step * static_cast<double>(steps)},
          {"memory_mb", scene_file::peak_memory_mb()}};
}

/// What the solver refuses: the pair that overlaps most for its size, or null.
json refused_pair(const solver::Scene& scene, const std::vector<PairStart>& pairs) {
  if (scene.initial_overlap != solver::InitialOverlap::Refuse) return nullptr;
  const auto worst = std::ranges::min_element(
      pairs, {}, [](const PairStart& pair) { return pair.gap / pair.size; });
  if (worst == pairs.end() || !(-worst->gap > kRefused * worst->size)) return nullptr;
  return pair_json(scene, *worst);
}

json report_of(const SceneFile& file, const std::string& path, double max_seconds) {
  const solver::Scene& scene = file.scene_in(0);
  const std::vector<PairStart> pairs = pairs_at_start(scene);
  const json refused = refused_pair(scene, pairs);
  json loose = json::array();
  for (const int block : without_support(scene, pairs))
    loose.push_back(scene.blocks[static_cast<std::size_t>(block)].name);
  json report = {{"scene", path},
                 {"title", file.title},
                 {"blocks", blocks_json(scene)},
                 {"contacts", contacts_json(scene, pairs)},
                 {"without_support", loose},
                 {"points_outside", outside_json(file)},
                 {"notes", file.notes},
                 {"marks", marks_json(file)},
                 {"refused", !refused.is_null()}};
  if (!refused.is_null()) {
    report["refused_pair"] = refused;
    return report;
  }
  const TriedStep trial = try_step(file, max_seconds);
  report["time_step"] = time_step_json(file, scene, trial.step);
  report["trial_step"] = trial_json(file, trial);
  report["left_out"] = trial.left_out;
  return report;
}

/// The first lines of a list of pairs.
void print_pairs(const char* what, const json& pairs) {
  constexpr std::size_t kMost = 10;
  for (std::size_t i = 0; i < std::min(kMost, pairs.size()); ++i) {
    std::printf("  %s %.3g m: %s, %s\n", what, std::abs(pairs[i]["gap"].get<double>()),
                words(pairs[i]["a"]), words(pairs[i]["b"]));
  }
  if (pairs.size() > kMost) std::printf("  … %zu in all (--json lists them)\n", pairs.size());
}

void print_start(const json& report) {
  const json& blocks = report["blocks"];
  std::printf("%s\n", words(report[report["title"] == "" ? "scene" : "title"]));
  std::printf("  blocks: %d deformable, %d rigid, %d fixed, %d prescribed",
              blocks["deformable"].get<int>(), blocks["rigid"].get<int>(),
              blocks["fixed"].get<int>(), blocks["prescribed"].get<int>());
  if (const int absent = blocks["absent"].get<int>(); absent > 0)
    std::printf(", %d absent", absent);
  std::printf("; %.6g kg move\n", blocks["mass"].get<double>());
  const json& contacts = report["contacts"];
  std::printf("  touching pairs: %d, %d contact points, %.4g m2\n", contacts["pairs"].get<int>(),
              contacts["points"].get<int>(), contacts["area"].get<double>());
  for (const auto& [type, count] : contacts["types"].items())
    std::printf("    %-14s %d\n", type.c_str(), count.get<int>());
  print_pairs("overlap", contacts["overlaps"]);
  print_pairs("gap", contacts["gaps"]);
  const json& loose = report["without_support"];
  for (std::size_t i = 0; i < std::min<std::size_t>(10, loose.size()); ++i)
    std::printf("  without support: %s\n", words(loose[i]));
  if (loose.size() > 10) std::printf("  … %zu in all\n", loose.size());
  for (const json& note : report["notes"]) std::printf("  %s\n", words(note));
  for (const json& point : report["points_outside"]) {
    std::printf("  outside its block \"%s\": %s at (%g, %g, %g) m\n", words(point["block"]),
                words(point["what"]), point["point"][0].get<double>(),
                point["point"][1].get<double>(), point["point"][2].get<double>());
  }
}

void print_run(const json& report) {
  const json& step = report["time_step"];
  std::printf(
      "  time step %.3g s: elastic omega dt %.3g (damping %.3g), contact springs %.3g "
      "(damping %.3g), fall in a step %.2g of the smallest block\n",
      step["time_step"].get<double>(), step["elastic_omega_dt"].get<double>(),
      step["elastic_damping"].get<double>(), step["contact_omega_dt"].get<double>(),
      step["contact_damping"].get<double>(),
      step["fall_in_a_step_by_smallest_block"].get<double>());
  const json& trial = report["trial_step"];
  std::printf("  one step tried: %s\n", words(trial["message"]));
  const double seconds = trial["step_seconds"].get<double>();
  if (seconds > 0.0) {
    std::printf("  to expect: at most %ld steps of %.3g s: %.3g s, %.0f MB\n",
                trial["most_steps"].get<long>(), seconds, trial["most_seconds"].get<double>(),
                trial["memory_mb"].get<double>());
  }
  for (const json& line : report["left_out"]) std::printf("  left out: %s\n", words(line));
}

int check(const CheckArguments& arguments) {
  const SceneFile file = scene_file::read_scene(arguments.scene, arguments.changes);
  const json report = report_of(file, arguments.scene, arguments.max_seconds);
  const bool refused = report["refused"].get<bool>();
  if (arguments.json) {
    std::printf("%s\n", report.dump(2, ' ', false, json::error_handler_t::replace).c_str());
  } else {
    print_start(report);
    if (!refused) print_run(report);
  }
  if (refused) {
    const json& pair = report["refused_pair"];
    std::fprintf(stderr,
                 "%s: /blocks: %s and %s overlap by %.3g m, more than 1e-3 of the smaller one; "
                 "\"initial_overlap\" may say zero (they touch as they stand) or keep\n",
                 arguments.scene.c_str(), pair["a"].dump().c_str(), pair["b"].dump().c_str(),
                 -pair["gap"].get<double>());
    return kBadInput;
  }
  return report["trial_step"]["converged"].get<bool>() ? kDone : kFailed;
}

}  // namespace

void add_check_command(CLI::App& app, int& exit_code) {
  const auto [command, words] = add_command<CheckArguments>(
      app, exit_code, check, "check",
      "Tell what a scene would run: blocks, contacts, overlaps and gaps, loose blocks, time step, "
      "what it takes. One step is tried; nothing is written.\n"
      "Exit codes: 0 it runs, 1 the first step does not converge, 2 the scene is refused.");
  add_scene_options(command, words.scene, words.changes);
  command
      .add_option("--max-seconds", words.max_seconds,
                  "end the step that is tried after this wall time, s")
      ->check(in_range(0, kMostSeconds))
      ->capture_default_str();
  command.add_flag("--json", words.json, "the same as JSON, with all pairs");
}

}  // namespace quoin::commands
