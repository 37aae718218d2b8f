#pragma once
/// Runs a scene file stage by stage, watches its monitors and measures it against its references.

#include <functional>

#include "scene_file/comparison.hpp"

namespace quoin::scene_file {

enum class RunStatus : std::uint8_t {
  Completed,
  NotConverged,  ///< a step did not converge
  NotAtRest,     ///< a static stage did not come to rest
  Interrupted
};

struct StageResult {
  solver::Analysis analysis = solver::Analysis::Dynamic;
  long steps = 0;
  double unbalance = 0.0;  ///< of the last step
  bool done = false;
};

/// A flag that steps of a run raised.
struct RunFlag {
  solver::StepFlag worst{};
  double first_time = 0.0;  ///< s
  long steps = 0;           ///< that raised it
};

/// Sums, extremes and last values over the steps of a run.
struct RunResult {
  RunStatus status = RunStatus::Completed;
  std::string message{};
  std::vector<StageResult> stages{};
  std::vector<ReferenceResult> references{};
  std::vector<MonitorValue> monitors{};
  solver::EnergyLedger energy_start{}, energy{};
  double energy_growth =
      0.0;  ///< most that mechanical energy less work rose above its least so far, J
  double energy_scale = 0.0;     ///< largest kinetic energy + swing of potential energy, J
  std::vector<RunFlag> flags{};  ///< one of a kind
  long steps = 0, unconverged_steps = 0;
  solver::StepReport total{};  ///< counts and seconds added up; overlap, condition, … the largest
  double wall_seconds = 0.0;
  double time = 0.0;                        ///< simulated, all stages, s
  double dynamic_time = 0.0;                ///< s since the start of the first dynamic stage
  Vector3 base_reaction = Vector3::Zero();  ///< on all blocks without unknowns, N
  std::vector<std::string> left_out{};
};

struct StepView {
  const solver::Simulation& simulation;
  const solver::StepReport& report;
  const std::vector<MonitorValue>& monitors;
  double dynamic_time;  ///< s since the start of the first dynamic stage; 0 before
  std::size_t stage;
  double progress;  ///< of the stage: 0..1 (dynamic), else 0
};

struct RunOptions {
  int threads = 1;
  enum class OnFailure : std::uint8_t { Stop, Accept } on_failure = OnFailure::Stop;
  std::function<void(const StepView&)> before_first{};  ///< the start, before any step
  std::function<bool(const StepView&)> after_step{};    ///< false: stop here
};

/// Throws geometry::InputError when the solver refuses the scene.
RunResult run_scene(const SceneFile& file, const RunOptions& options);

}  // namespace quoin::scene_file
