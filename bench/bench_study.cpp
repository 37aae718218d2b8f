/// The peers' part of a study: Bullet and ODE on a scene file, measured by its own references, in
/// the form of `quoin study` (tools/plot_study.py draws both into one picture).

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <stdexcept>

#include "guarded_main.hpp"
#include "rigid_scene_of_file.hpp"
#include "scene_file/run_scene.hpp"
#include "scene_file/study_grid.hpp"

namespace quoin::bench {
namespace {

using scene_file::SceneFile;
using scene_file::StudyAxis;
using scene_file::StudyPoint;

// --- what the monitors show
// ---------------------------------------------------------------------------

class Watch {
 public:
  Watch(const SceneFile& file, const World& world) : file_(file) {
    for (const scene_file::Monitor& monitor : file.monitors) {
      start_.push_back(world.motion(monitor.blocks[0]));
      arms_.push_back(monitor.point ? Vector3d(start_.back().turn.conjugate() *
                                               (*monitor.point - start_.back().place))
                                    : Vector3d(Vector3d::Zero()));
    }
  }

  scene_file::MonitorValue value(std::size_t m, const World& world) const {
    const scene_file::Monitor& monitor = file_.monitors[m];
    scene_file::MonitorValue value;
    if (monitor.kind == scene_file::Monitor::Kind::Contact) {
      for (const PairForce& pair : world.forces()) {
        const bool on_b = pair.a == monitor.others[0] && pair.b == monitor.blocks[0];
        const bool on_a = pair.b == monitor.others[0] && pair.a == monitor.blocks[0];
        if (on_a || on_b) value.force += on_b ? pair.on_b : Vector3d(-pair.on_b);
      }
      return value;
    }
    const BodyMotion now = world.motion(monitor.blocks[0]);
    const Vector3d arm = now.turn * arms_[m];
    value.displacement = now.place + arm - start_[m].place - start_[m].turn * arms_[m];
    value.velocity = now.velocity + now.spin.cross(arm);
    value.angular_velocity = now.spin;
    const Eigen::AngleAxisd turned(now.turn * start_[m].turn.conjugate());
    value.rotation = turned.angle() * turned.axis();
    return value;
  }

 private:
  const SceneFile& file_;
  std::vector<BodyMotion> start_;
  std::vector<Vector3d> arms_;
};

// --- the study
// ----------------------------------------------------------------------------------------

struct Arguments {
  std::string scene, out, against, who = ".*";
  std::vector<std::string> changes;
  std::vector<StudyAxis> axes{{"code", "", {}}};
};

const Contestant& peer_named(const std::vector<Contestant>& all, const std::string& name) {
  for (const Contestant& peer : all)
    if (peer.name == name) return peer;
  throw std::invalid_argument("no peer " + name);
}

void run_point(const Arguments& arguments, const Contestant& peer, StudyPoint& point) {
  std::vector<std::string> changes = arguments.changes;
  for (const std::string& change : changes_of(arguments.axes, point)) changes.push_back(change);
  const SceneFile file = scene_file::read_scene(arguments.scene, changes);
  const RigidScene scene = rigid_scene(file);
  for (const RigidBody& body : scene.bodies)
    if (body.half_size.x() <= 0.0 && peer.name.starts_with("ODE"))
      throw std::invalid_argument("ODE's general convex bodies abort");
  const double dt = point.time_step = file.options.time_step;
  const long steps = std::lround(file.stages[0].end_time / dt);
  const double start = scene_file::thread_seconds();
  const std::unique_ptr<World> world = peer.make(scene, dt, peer.iterations);
  const Watch watch(file, *world);
  std::vector<scene_file::Comparison> comparisons(file.references.begin(), file.references.end());
  for (long i = 1; i <= steps; ++i) {
    if (!world->step(dt)) throw std::runtime_error("gave up at step " + std::to_string(i));
    for (std::size_t r = 0; r < comparisons.size(); ++r) {
      const auto monitor = static_cast<std::size_t>(file.references[r].monitor);
      comparisons[r].compare(static_cast<double>(i) * dt, watch.value(monitor, *world));
    }
  }
  point.cpu_seconds = scene_file::thread_seconds() - start;
  std::vector<scene_file::ReferenceResult> results;
  for (const scene_file::Comparison& comparison : comparisons)
    results.push_back(comparison.result());
  point.error = scene_file::largest_error(results);
  for (std::size_t m = 0; m < file.monitors.size(); ++m)
    point.ends.push_back(watch.value(m, *world).displacement);
}

/// Ends of the finest run of a study of `quoin study` on the same scene.
std::vector<Vector3d> ends_of_study(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error("can't read " + path);
  const nlohmann::json study = nlohmann::json::parse(in);
  std::vector<StudyPoint> points;
  for (const nlohmann::json& entry : study.at("points")) {
    StudyPoint point;
    point.failure = entry.at("failure");
    point.time_step = entry.at("time_step");
    for (const nlohmann::json& end : entry.at("ends"))
      if (!end[0].is_null()) point.ends.emplace_back(end[0], end[1], end[2]);
    points.push_back(point);
  }
  return scene_file::finest_ends(points);
}

void run(Arguments& arguments) {
  const std::vector<Contestant> all = peers();
  for (const Contestant& peer : all)
    if (std::regex_search(peer.name, std::regex(arguments.who)))
      arguments.axes[0].values.push_back(peer.name);
  std::vector<StudyPoint> points = grid(arguments.axes);
  run_points(
      points, 1,
      [&](StudyPoint& point) { run_point(arguments, peer_named(all, point.values[0]), point); },
      [](std::size_t) {});
  const bool referenced = std::any_of(points.begin(), points.end(), [](const StudyPoint& point) {
    return std::isfinite(point.error);
  });
  if (!referenced && !arguments.against.empty())
    compare_with(ends_of_study(arguments.against), points);
  mark_best(points);
  write_csv(arguments.axes, points, stdout);
  if (arguments.out.empty()) return;
  std::ofstream out(arguments.out);
  const std::string scene = std::filesystem::path(arguments.scene).filename().string();
  out << to_json(scene, arguments.axes, points).dump(1) << "\n";
  if (!out) throw std::runtime_error("can't write " + arguments.out);
}

int main_program(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const bool more = i + 1 < argc;
    if (argument == "--vary" && more)
      arguments.axes.push_back(scene_file::parse_axis(argv[++i]));
    else if (argument == "--set" && more)
      arguments.changes.push_back(argv[++i]);
    else if (argument == "--against" && more)
      arguments.against = argv[++i];
    else if (argument == "--who" && more)
      arguments.who = argv[++i];
    else if (argument == "--out" && more)
      arguments.out = argv[++i];
    else if (arguments.scene.empty() && argument[0] != '-')
      arguments.scene = argument;
    else
      arguments.scene.clear(), i = argc;
  }
  if (arguments.scene.empty()) {
    std::fprintf(stderr,
                 "usage: %s SCENE.json --vary KEY=A,B,… [--set NAME=VALUE] [--against STUDY.json] "
                 "[--who REGEX] [--out FILE.json]\n",
                 argv[0]);
    return 2;
  }
  return guarded(argv[0], [&] { run(arguments); });
}

}  // namespace
}  // namespace quoin::bench

int main(int argc, char** argv) { return quoin::bench::main_program(argc, argv); }
