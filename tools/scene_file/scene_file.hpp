#pragma once
/// Scene files: a JSON document (scene.schema.json) read into a solver::Scene and how to run it.

#include <memory>
#include <optional>
#include <quoin/solver/simulation.hpp>
#include <string>
#include <vector>

#include "scene_file/formula.hpp"
#include "scene_file/scene_error.hpp"

namespace quoin::scene_file {

using solver::Vector3;

/// One part of a run: static or settling until rest or for so many steps; dynamic until a time.
struct Stage {
  solver::Analysis analysis = solver::Analysis::Dynamic;
  double end_time = 0.0;        ///< dynamic: s from the start of the first dynamic stage
  std::optional<long> steps{};  ///< static, settle: just so many; none: until rest
  long max_steps = 1000;        ///< static, settle: at rest by then, or the stage has failed
  double unbalance = 1e-6;      ///< static, settle: limit of StepReport::unbalance at rest
  double time_step = 0.0;       ///< s
};

/// Something to watch: a material point of a block, or the contact between two blocks.
struct Monitor {
  std::string name{};
  int block = 0;                   ///< of a contact: the one that the force pushes
  std::optional<int> other{};      ///< of a contact: the one that pushes
  std::optional<Vector3> point{};  ///< place of the material point at the start, m; none: centroid
};

enum class Quantity : std::uint8_t { Displacement, Velocity, Rotation, AngularVelocity, Force };

/// An exact answer: a formula of t or a table, against a quantity of a monitor.
struct Reference {
  std::string name{};
  int monitor = 0;
  Quantity quantity = Quantity::Displacement;
  enum class Component : std::uint8_t { Vector, Along, Magnitude } component = Component::Vector;
  Vector3 direction = Vector3::Zero();       ///< of Along: unit
  std::vector<Formula> formulas{};           ///< one, or three for a vector
  std::vector<std::vector<double>> table{};  ///< rows t, value(s); used when there are no formulas
  double from = 0.0;                         ///< s: it holds from here …
  double until = 0.0;                        ///< … to here
  double allowed = 0.0;                      ///< relative; 0: none stated

  /// The exact value at time t (s from the start of the first dynamic stage): one number, or three.
  Eigen::VectorXd exact(double time) const;
};

/// When the stage that runs began, s. run_scene() sets it; formulas of stage_time read it.
struct StageClock {
  double start = 0.0;
};

struct SceneFile {
  std::string title{};
  solver::Scene scene{};
  solver::StepOptions options{};
  std::vector<Stage> stages{};
  std::shared_ptr<StageClock> stage_clock = std::make_shared<StageClock>();
  std::vector<Monitor> monitors{};
  std::vector<Reference> references{};
  double output_interval = 0.0;        ///< s between ParaView files
  int history_every = 1;               ///< steps between lines of the history
  std::vector<std::string> sources{};  ///< the files that it was read from
};

/// Reads a scene file. `changes` are "NAME=VALUE": NAME a parameter of the scene, or a JSON pointer
/// ("/penalty=5e7", "/joint/friction_angle_deg=0"); VALUE JSON, or a bare word. They are made
/// before anything is checked. Throws SceneError and FileError.
SceneFile read_scene(const std::string& path, const std::vector<std::string>& changes = {});

/// The schema that scene files are checked against, as it is installed.
std::string_view scene_schema();

}  // namespace quoin::scene_file
