/// Structures of rigid and deformable blocks that stand or come down: many contacts that slide,
/// open and meet again in each step. Whether they stand is known from limit analysis by linear
/// programming, limit_loads.json, which tests/tools/test_limit.py compares with quoin limit.

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "scene_file/scene_file.hpp"
#include "stability/cell.hpp"
#include "stability/embedded.hpp"

namespace quoin::stability {
namespace {

constexpr double kTimeStep = 0.01, kRamp = 0.2;  // s
/// m, of blocks of 0.1 to 0.4 m: what stands keeps its place but for what it bends; an excess of 2
/// % of the smallest limit load, 0.15 of the weight, accelerates blocks by some 0.03 m/s2.
constexpr double kFallen = 1e-4;

/// What the linear programme says of a scene.
struct LimitLoad {
  std::string scene;                       ///< file, in the folder of scenes
  Vector3 live = Vector3::Zero();          ///< direction of the load, by weight
  std::optional<double> inner{}, outer{};  ///< of the load factor; none: falls under its own weight
};

LimitLoad limit_load(const std::string& name, const std::string& scenes) {
  for (const auto& entry : nlohmann::json::parse(limit_loads())) {
    if (entry.at("name") != name) continue;
    const std::vector<double> live = entry.at("live");
    LimitLoad load{scenes + "/" + entry.at("scene").get<std::string>(),
                   {live.at(0), live.at(1), live.at(2)}};
    if (!entry.at("inner").is_null()) load.inner = entry.at("inner").get<double>();
    if (!entry.at("outer").is_null()) load.outer = entry.at("outer").get<double>();
    return load;
  }
  throw std::runtime_error("limit_loads.json: there is no " + name);
}

/// `young` 0: as the file has them, rigid.
solver::Scene scene_of(const LimitLoad& load, double young) {
  solver::Scene scene = scene_file::read_scene(load.scene).scene;
  for (solver::Block& block : scene.blocks) {
    if (block.kind != solver::BlockKind::Rigid || !(young > 0.0)) continue;
    block.kind = solver::BlockKind::Deformable;
    block.material.young = young;
  }
  return scene;
}

double largest_motion(const Run& run, const std::vector<Vector3>& start) {
  double largest = 0.0;
  for (std::size_t b = 0; b < start.size(); ++b) {
    largest = std::max(largest, (run.place(static_cast<int>(b)) - start[b]).norm());
  }
  return largest;
}

std::vector<Vector3> places(const Run& run) {
  std::vector<Vector3> all;
  for (std::size_t b = 0; b < run.simulation().state().blocks.size(); ++b) {
    all.push_back(run.place(static_cast<int>(b)));
  }
  return all;
}

/// Error below 1: it stood or fell as the linear programme says.
Result judged(const Run& run, const std::vector<Vector3>& start, bool stands) {
  const double motion = largest_motion(run, start) / kFallen;
  return {stands ? motion : 1.0 / motion, run.evidence};
}

/// Let go under its own weight.
Result run_released(const LimitLoad& load, double young) {
  Run run(scene_of(load, young), {.time_step = kTimeStep});
  const std::vector<Vector3> start = places(run);
  run.steps(std::lround(0.6 / kTimeStep));
  return judged(run, start, load.inner.has_value());
}

/// Comes to rest under its own weight; then the live load grows to `share` of its limit, and stays
/// for `hold` (s).
Result run_pushed(const LimitLoad& load, double young, double share, double hold) {
  const double factor = share * (share < 1.0 ? load.inner.value() : load.outer.value());
  solver::Scene scene = scene_of(load, young);
  const Vector3 live = load.live;
  scene.gravity = solver::VectorOfTime([=](double time) -> Vector3 {
    return kGravity * (factor * std::clamp(time / kRamp, 0.0, 1.0) * live - Vector3::UnitZ());
  });
  Run run(std::move(scene), {.time_step = kTimeStep});
  run.rest(1.0);
  const std::vector<Vector3> start = places(run);
  run.steps(std::lround((kRamp + hold) / kTimeStep));
  return judged(run, start, share < 1.0);
}

}  // namespace

void append_collapse_cells(const std::string& scenes, std::vector<Cell>& cells) {
  constexpr double kAllowed = 1.0;
  for (const char* structure : {"arch", "sliding wall", "overturning wall"}) {
    const LimitLoad load = limit_load(structure, scenes);
    for (const double share : {0.9, 0.955, 0.98, 1.02, 1.1}) {
      for (const double young : {0.0, 1e10}) {
        const std::string kind = young > 0.0 ? ", deformable" : ", rigid";
        cells.push_back({structure + kind, {{"share_of_limit_load", share}}, kAllowed, [=] {
                           return run_pushed(load, young, share, 0.4);
                         }});
      }
    }
  }
  const LimitLoad thin = limit_load("thin arch", scenes), wall = limit_load("sliding wall", scenes);
  for (int exponent = 8; exponent <= 13; ++exponent) {
    const double young = std::pow(10.0, exponent);
    cells.push_back(
        {"falling arch", {{"young", young}}, kAllowed, [=] { return run_released(thin, young); }});
    cells.push_back({"sliding wall", {{"young", young}}, kAllowed, [=] {
                       return run_pushed(wall, young, 1.5, 0.1);
                     }});
  }
}

}  // namespace quoin::stability
