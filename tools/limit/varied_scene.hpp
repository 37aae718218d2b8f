#pragma once
/// What `quoin limit` varies, and the scene at each value of it.

#include <functional>
#include <quoin/solver/equilibrium.hpp>
#include <string>
#include <vector>

#include "scene_file/scene_file.hpp"

namespace quoin::limit_analysis {

using solver::Equilibrium;
using solver::EquilibriumProblem;
using solver::EquilibriumVerdict;
using solver::Scene;
using solver::Vector3;
using solver::Vector6;

/// What is varied, from where to where.
struct Vary {
  std::string what{}, name{};
  double from = 0.0, to = 0.0;
  Vector3 axis = Vector3::UnitY();  ///< of a tilt
};

/// Of WHAT=FROM:TO. Throws std::invalid_argument.
Vary parse_vary(const std::string& text);

/// `changes`, with one that makes a scene without "stages" or "end_time" a static stage under its
/// loads. Throws what scene_file::read_json does.
std::vector<std::string> with_static_stage(const std::string& path,
                                           std::vector<std::string> changes);

/// What joints with tension can do. Plastic ones yield, and reach all that could ever be borne;
/// brittle ones are whole, their stress as steps judge it, or have residual strength, no tension.
enum class Joints : std::uint8_t { Yield, Whole, Broken };

/// "yield", "whole", "broken".
const char* name(Joints joints);
bool has_tension(const Scene& scene);
Scene with_joints(Scene scene, Joints joints);
EquilibriumProblem problem_of(const Scene& scene, Joints joints);

/// One value, what was solved there and what came out.
struct Trial {
  double value = 0.0;
  Scene scene{};
  EquilibriumProblem problem{};
  double factor = 0.0;  ///< of the live loads
  Equilibrium found{};
  double shrink = 1.0;  ///< of contact areas about their middles
  Joints joints = Joints::Yield;
};

using Progress = std::function<void(const std::string&)>;

/// Scenes by value.
class VariedScene {
 public:
  /// Throws what scene_file::read_scene does, and SceneError where no load has the name.
  VariedScene(std::string path, std::vector<std::string> changes, const Vary& vary);

  /// Of what follows; at first they yield.
  void judge_by(Joints joints);
  Trial at(double value);  ///< solved
  /// Of a load: the convex problem.
  Equilibrium largest();
  /// The scene with all its loads at that value.
  Scene scene_at(double value) const;
  const scene_file::SceneFile& file() const { return file_; }
  const EquilibriumProblem& load_problem() const { return problem_; }
  const Vary& vary() const { return vary_; }

  int factorizations = 0;
  Progress progress = [](const std::string&) {};  ///< told before a value is solved

 private:
  Scene changed_scene(double value) const;
  void part_loads();

  std::string path_;
  std::vector<std::string> changes_;
  Vary vary_;
  scene_file::SceneFile file_;
  Scene scene_, live_{};          ///< of a load: without the loads of that name; with them alone
  EquilibriumProblem problem_{};  ///< of a load: with what `from` takes of it
  Joints joints_ = Joints::Yield;
};

}  // namespace quoin::limit_analysis
