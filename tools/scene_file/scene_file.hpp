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

/// What a stage says of a block's motion; what it does not say stays.
struct StageVelocity {
  int block = 0;
  std::optional<Vector3> velocity{};          ///< of the centroid, m/s
  std::optional<Vector3> angular_velocity{};  ///< rad/s
};

/// What becomes of a static stage that has no equilibrium near its start.
enum class OnMechanism : std::uint8_t {
  Fail,
  Continue,  ///< what has come loose is told; the stage ends
  Remove     ///< what has come loose is taken away, until the rest comes to rest
};

/// One part of a run. It ends at the first of its stop rules; one without `steps`, `end_time` or
/// `duration` (static, settle) at rest.
struct Stage {
  solver::Analysis analysis = solver::Analysis::Dynamic;
  std::string name{};
  double end_time = 0.0;        ///< dynamic: s from the start of the first dynamic stage; 0: none
  double duration = 0.0;        ///< dynamic: s from the start of this stage; 0: none
  std::optional<long> steps{};  ///< just so many
  bool until_rest = false;      ///< at rest before another rule ends it, or it has failed
  double until_moved = 0.0;     ///< m: of a centroid since the start of the stage; 0: no rule
  long max_steps = 1000;        ///< static, settle until rest: at rest by then
  OnMechanism on_mechanism = OnMechanism::Fail;
  int relax = 0;  ///< static: parts in which removed blocks give their forces back; 0: at once
  double ramp_to = 0.0, ramp_by = 0.0;  ///< static: factor of all loads, to its last value; 0: none
  double unbalance = 1e-6;              ///< limit of StepReport::unbalance at rest
  double time_step = 0.0;               ///< s
  solver::ContactIteration contact_iteration = solver::ContactIteration::Automatic;
  bool reset_displacements = false;              ///< they count from the start of this stage
  std::shared_ptr<const solver::Scene> scene{};  ///< from this stage on; null: as before
  std::vector<StageVelocity> velocities{};       ///< dynamic: when the stage begins
};

/// Something to watch: a material point of a block, the contacts between blocks, a group of blocks,
/// or fixed points.
struct Monitor {
  enum class Kind : std::uint8_t { Point, Contact, Group, FixedPoints } kind = Kind::Point;
  std::string name{};
  std::vector<int>
      blocks{};  ///< of a point: one; of contacts: those that the force pushes; ascending
  std::vector<int> others{};                ///< of contacts: those that push; ascending
  std::vector<std::string> fixed_points{};  ///< names, ascending
  std::optional<Vector3> point{};   ///< place of the material point at the start, m; none: centroid
  Vector3 about = Vector3::Zero();  ///< of contacts: moments are taken about this place, m
  /// Of a point: its motion is that relative to the material of this block; -1: to the world.
  int relative_to = -1;
};

enum class Quantity : std::uint8_t {
  Displacement,
  Velocity,
  Rotation,
  AngularVelocity,
  Force,
  Moment,
  CentreOfPressure,
  Momentum,
  AngularMomentum,
  Stress,
  Strain
};

/// An exact answer: a formula of t or a table, against a quantity of a monitor.
struct Reference {
  std::string name{};
  int monitor = 0;
  Quantity quantity = Quantity::Displacement;
  enum class Component : std::uint8_t { Vector, Along, Magnitude } component = Component::Vector;
  Vector3 direction = Vector3::Zero();       ///< of Along: unit
  Eigen::Index tensor_component = 0;         ///< of stress and strain: xx, yy, zz, xy, yz, zx
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
  bool paraview = true;                ///< are ParaView files wanted?
  int history_every = 1;               ///< steps between lines of the history
  std::vector<std::string> sources{};  ///< the files that it was read from
  std::vector<std::string> notes{};    ///< what of them was taken otherwise than it stands

  /// The scene as it stands in a stage. `scene` is that of the start of the run.
  const solver::Scene& scene_in(std::size_t stage) const;
};

/// Reads a scene file. `changes` are "NAME=VALUE": NAME a parameter of the scene, or a JSON pointer
/// ("/penalty=5e7", "/joint/friction_angle_deg=0"); VALUE JSON, or a bare word. They are made
/// before anything is checked. Throws SceneError and FileError.
SceneFile read_scene(const std::string& path, const std::vector<std::string>& changes = {});

/// The same from the text of a scene file; files that it names are relative to `folder`.
SceneFile parse_scene(const std::string& text, const std::string& folder,
                      const std::vector<std::string>& changes = {});

/// The document of a scene file without its comments, otherwise as it stands, unchecked. Throws as
/// read_scene().
std::string plain_json(const std::string& path);

/// The schema that scene files are checked against, as it is installed.
std::string_view scene_schema();

}  // namespace quoin::scene_file
