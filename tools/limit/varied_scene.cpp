#include "limit/varied_scene.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "scene_file/read_json.hpp"

namespace quoin::limit_analysis {
namespace {

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
  throw std::invalid_argument("--vary " + text + ": " + why);
}

double number(const std::string& text, const std::string& whole) {
  std::size_t used = 0;
  double value = 0.0;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used == 0 || used != text.size() || !std::isfinite(value))
    refuse(whole, "\"" + text + "\" is no number");
  return value;
}

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts(1);
  for (const char c : text) c == at ? (void)parts.emplace_back() : parts.back().push_back(c);
  return parts;
}

}  // namespace

Vary parse_vary(const std::string& text) {
  Vary vary;
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) refuse(text, "has to be WHAT=FROM:TO");
  vary.what = text.substr(0, equals);
  std::vector<std::string> parts = split(text.substr(equals + 1), ':');
  if (vary.what == "load" || vary.what == "settlement") {
    if (parts.size() != 3) refuse(text, "has to be " + vary.what + "=NAME:FROM:TO");
    vary.name = parts.front();
    parts.erase(parts.begin());
  } else if (vary.what == "tilt" && parts.size() == 3) {
    const std::size_t axis = std::string("xyz").find(parts[2]);
    if (parts[2].size() != 1 || axis == std::string::npos) refuse(text, "the axis is x, y or z");
    vary.axis = Vector3::Unit(static_cast<Eigen::Index>(axis));
    parts.pop_back();
  } else if (vary.what != "tilt" && vary.what != "strength" && vary.what != "friction" &&
             !vary.what.starts_with("/")) {
    refuse(text, "can vary load, tilt, strength, friction, settlement or a JSON pointer");
  }
  if (parts.size() != 2) refuse(text, "has to be WHAT=FROM:TO");
  vary.from = number(parts[0], text);
  vary.to = number(parts[1], text);
  if (!(vary.from < vary.to)) refuse(text, "FROM must be less than TO");
  if (vary.what == "strength" && !(vary.from > 0.0)) refuse(text, "must be greater than 0");
  if (vary.what == "settlement" && vary.from != 0.0) refuse(text, "FROM has to be 0");
  if (vary.what == "friction" && !(vary.from >= 0.0 && vary.to < 90.0))
    refuse(text, "angles lie in [0, 90) degrees");
  return vary;
}

std::vector<std::string> with_static_stage(const std::string& path,
                                           std::vector<std::string> changes) {
  const nlohmann::json document = scene_file::read_json(path);
  const auto is_given = [&](const std::string& key) {
    return document.contains(key) || std::ranges::any_of(changes, [&](const std::string& change) {
             return change.starts_with("/" + key);
           });
  };
  if (document.is_object() && !is_given("stages") && !is_given("end_time"))
    changes.emplace_back(R"(/stages=[{"analysis": "static"}])");
  return changes;
}

namespace {

template <class Change>
void change_joints(Scene& scene, const Change& change) {
  change(scene.joint);
  for (solver::PairJoint& pair : scene.pair_joints) change(pair.joint);
  for (solver::BlockJoint& pair : scene.block_joints) change(pair.joint);
}

template <class Visit>
void each_joint(const Scene& scene, const Visit& visit) {
  visit(scene.joint);
  for (const solver::PairJoint& pair : scene.pair_joints) visit(pair.joint);
  for (const solver::BlockJoint& pair : scene.block_joints) visit(pair.joint);
}

solver::VectorOfTime scaled(const solver::VectorOfTime& vector, double factor) {
  return {[vector, factor](double time) { return Vector3(factor * vector.at(time)); }};
}

}  // namespace

const char* name(Joints joints) {
  static constexpr const char* kNames[] = {"yield", "whole", "broken"};
  return kNames[static_cast<std::size_t>(joints)];
}

bool has_tension(const Scene& scene) {
  bool any = false;
  each_joint(scene, [&](const solver::Joint& joint) { any = any || joint.tension > 0.0; });
  return any;
}

Scene with_joints(Scene scene, Joints joints) {
  if (joints != Joints::Broken) return scene;
  change_joints(scene, [](solver::Joint& joint) {
    if (joint.residual_friction_angle >= 0.0) joint.friction_angle = joint.residual_friction_angle;
    joint.cohesion = joint.residual_cohesion;
    joint.tension = 0.0;
  });
  return scene;
}

EquilibriumProblem problem_of(const Scene& scene, Joints joints) {
  const bool whole = joints == Joints::Whole;
  return solver::equilibrium_problem(
      with_joints(scene, joints), 0.0,
      whole ? solver::JointStress::Elastic : solver::JointStress::Plastic);
}

VariedScene::VariedScene(std::string path, std::vector<std::string> changes, const Vary& vary)
    : path_(std::move(path)),
      changes_(std::move(changes)),
      vary_(vary),
      file_(scene_file::read_scene(path_, changes_)),
      scene_(file_.scene) {
  if (vary.what != "load") return;
  live_ = scene_;
  live_.gravity = Vector3(0, 0, 0);
  live_.pressure_loads.clear();
  part_loads();
  judge_by(Joints::Yield);
}

void VariedScene::judge_by(Joints joints) {
  joints_ = joints;
  if (vary_.what != "load") return;
  problem_ = problem_of(scene_, joints);
  const std::vector<Vector6> live = solver::block_loads(live_);
  for (std::size_t b = 0; b < live.size(); ++b) {
    problem_.blocks[b].live = live[b];
    problem_.blocks[b].load += vary_.from * live[b];
  }
}

Trial VariedScene::at(double value) {
  progress("proofs: " + std::to_string(value));
  const bool load = vary_.what == "load";
  Trial trial{value, with_joints(load ? scene_ : changed_scene(value), joints_), problem_};
  trial.joints = joints_;
  if (load)
    trial.factor = value - vary_.from;
  else
    trial.problem = problem_of(trial.scene, joints_);
  trial.found = solver::find_equilibrium(trial.problem, trial.factor);
  factorizations += trial.found.factorizations;
  return trial;
}

Equilibrium VariedScene::largest() {
  progress("proofs: the convex problem");
  const Equilibrium found = solver::largest_load_factor(problem_, vary_.to - vary_.from);
  factorizations += found.factorizations;
  return found;
}

Scene VariedScene::scene_at(double value) const {
  if (vary_.what != "load") return changed_scene(value);
  Scene scene = scene_;
  for (solver::PointLoad load : live_.point_loads) {
    load.force = scaled(load.force, value);
    scene.point_loads.push_back(load);
  }
  for (solver::FaceLoad load : live_.face_loads) {
    load.traction = scaled(load.traction, value);
    scene.face_loads.push_back(load);
  }
  for (solver::BodyLoad load : live_.body_loads) {
    load.force = scaled(load.force, value);
    scene.body_loads.push_back(load);
  }
  return scene;
}

Scene VariedScene::changed_scene(double value) const {
  Scene scene = scene_;
  if (vary_.what == "tilt") {
    const double angle = value * std::numbers::pi / 180.0;  // the ground turns by it, not gravity
    const Vector3 gravity = scene.gravity.at(0.0);
    scene.gravity = Vector3(Eigen::AngleAxisd(-angle, vary_.axis) * gravity);
  } else if (vary_.what == "strength") {
    change_joints(scene, [&](solver::Joint& joint) {
      joint.friction_angle = std::atan(std::tan(joint.friction_angle) / value);
      if (joint.residual_friction_angle >= 0.0)
        joint.residual_friction_angle = std::atan(std::tan(joint.residual_friction_angle) / value);
      for (double* strength :
           {&joint.cohesion, &joint.tension, &joint.residual_cohesion, &joint.residual_tension})
        *strength /= value;
    });
  } else if (vary_.what == "friction") {
    change_joints(scene, [&](solver::Joint& joint) {
      joint.friction_angle = value * std::numbers::pi / 180.0;
    });
  } else {
    std::vector<std::string> changes = changes_;
    char text[64];
    std::snprintf(text, sizeof text, "=%.17g", value);
    changes.push_back(vary_.what + text);
    scene = scene_file::read_scene(path_, changes).scene;
  }
  return scene;
}

/// Loads of that name stay in live_ alone. Lists of the scene keep the order of the file.
void VariedScene::part_loads() {
  nlohmann::json document = scene_file::read_json(path_);
  scene_file::expand(document, changes_);
  std::vector<char> named[3];
  for (const auto& load : document.value("loads", nlohmann::json::array())) {
    const std::string type = load.at("type");
    const int kind = type == "point" ? 0 : type == "face" ? 1 : 2;
    named[kind].push_back(load.value("name", "") == vary_.name);
  }
  bool any = false;
  const auto part = [&](auto& dead, auto& live, const std::vector<char>& is_live) {
    std::size_t i = 0;
    std::erase_if(dead, [&](const auto&) { return is_live.at(i++) != 0; });
    i = 0;
    std::erase_if(live, [&](const auto&) { return is_live.at(i++) == 0; });
    any = any || !live.empty();
  };
  part(scene_.point_loads, live_.point_loads, named[0]);
  part(scene_.face_loads, live_.face_loads, named[1]);
  part(scene_.body_loads, live_.body_loads, named[2]);
  if (!any) throw scene_file::SceneError("/loads", "there is no load named \"" + vary_.name + "\"");
}

}  // namespace quoin::limit_analysis
