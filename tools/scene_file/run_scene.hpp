#pragma once
/// Runs a scene file stage by stage, watches its monitors and measures it against its references.

#include <chrono>
#include <functional>
#include <iosfwd>
#include <memory>

#include "scene_file/comparison.hpp"

namespace quoin::scene_file {

struct MechanismProof;  // mechanism_proof.hpp

enum class RunStatus : std::uint8_t {
  Completed,
  NotConverged,  ///< a step did not converge
  NotAtRest,     ///< a stage did not come to rest
  Mechanism,     ///< of a static stage: there is no equilibrium near its start
  StageRefused,  ///< a stage can't begin: what it lays overlaps what stands there
  NotTrusted,    ///< all stages were run, with a flag for which the result is not to be trusted
  Interrupted,
  TimeLimit  ///< the wall time that was given is over
};

/// "completed", "not_converged", …, as in summary.json.
const char* name(RunStatus status);

/// Which stop rule ended a stage.
enum class StageEnd : std::uint8_t { None, Rest, Moved, Steps, Time };

struct StageResult {
  solver::Analysis analysis = solver::Analysis::Dynamic;
  long steps = 0;
  double unbalance = 0.0;                                          ///< of the last step
  solver::StaticVerdict verdict = solver::StaticVerdict::Seeking;  ///< of the last step
  double travel = 0.0;      ///< likewise, by the block's size
  int travel_block = -1;    ///< that block
  bool admissible = false;  ///< it found no rest, though forces would hold it where it ended
  bool done = false;
  StageEnd end = StageEnd::None;
  double load_factor = 0.0;  ///< of a ramp: the largest at rest
};

/// A block that has come loose in a static stage that goes on all the same.
struct LooseBlock {
  int stage = 0, block = 0;
  bool removed = false;
};

/// A flag that steps of a run raised.
struct RunFlag {
  solver::StepFlag worst{};
  double first_time = 0.0;  ///< s
  long steps = 0;           ///< that raised it
  bool fails = false;       ///< the run: its result is not to be trusted
};

/// Sums, extremes and last values over the steps of a run.
struct RunResult {
  RunStatus status = RunStatus::Completed;
  std::string message{};
  std::vector<StageResult> stages{};
  std::vector<LooseBlock> loose{};
  std::shared_ptr<const MechanismProof> proof{};  ///< of the last stage that has one
  std::vector<ReferenceResult> references{};
  std::vector<MonitorValue> monitors{};
  solver::EnergyLedger energy_start{}, energy{};
  double energy_growth =
      0.0;  ///< most that mechanical energy less work rose above its least so far, J
  double energy_scale = 0.0;     ///< largest kinetic energy + swing of potential energy, J
  std::vector<RunFlag> flags{};  ///< one of a kind
  long steps = 0, unconverged_steps = 0;
  solver::StepReport total{};  ///< counts and seconds added up; overlap, condition, … the largest
  int threads = 1;             ///< that were at work
  double wall_seconds = 0.0;
  double time = 0.0;                        ///< simulated, all stages, s
  double dynamic_time = 0.0;                ///< s since the start of the first dynamic stage
  Vector3 base_reaction = Vector3::Zero();  ///< on all blocks without unknowns, N
  std::vector<solver::TieState> ties{};     ///< at the end
  std::vector<std::string> left_out{};
};

struct StepView {
  const solver::Simulation& simulation;
  const solver::StepReport& report;  ///< of the last step
  const std::vector<MonitorValue>& monitors;
  /// Places from which displacements count, by block; empty: from the start of the run.
  const std::vector<solver::BlockState>& counted_from;
  double dynamic_time;  ///< s since the start of the first dynamic stage; 0 before
  std::size_t stage;
  double progress;   ///< of the stage: 0..1 (dynamic), else 0
  RunStatus status;  ///< so far
};

/// Writes where the run is: run_scene() with RunOptions::resume goes on from there to the bit.
using SaveRun = std::function<void(std::ostream&)>;

struct RunOptions {
  int threads = 1;
  std::shared_ptr<solver::DistributedSolver> distributed_solver{};  ///< as in StepOptions
  enum class OnFailure : std::uint8_t { Stop, Accept } on_failure = OnFailure::Stop;
  std::istream* resume = nullptr;  ///< what SaveRun wrote in an earlier run of the same file
  std::function<void(const StepView&)> before_first{};  ///< the start, before any step
  std::function<void(const StepView&, const SaveRun&)> after_step{};
  std::function<void(const StepView&, const SaveRun&)> after_stage{};  ///< also one that broke off
  std::function<void(const StepView&)> in_step{};  ///< now and then; `report`: of the step so far
  std::function<void(const solver::ContactProblem&)> contact_problem{};  ///< as in StepOptions
  /// Asked after each step and some twenty times a second in a long one: Interrupted or TimeLimit
  /// ends the run, with the state after the last whole step.
  std::function<std::optional<RunStatus>()> stop{};
};

/// Why a run counts as failed, a line each; empty when all is well: its status, steps that were
/// accepted though they did not converge, flags that fail it, references that were missed.
std::vector<std::string> failures(const SceneFile& file, const RunResult& result);

/// Throws geometry::InputError when the solver refuses the scene, FileError when what is to be
/// resumed can't be.
RunResult run_scene(const SceneFile& file, const RunOptions& options);

/// On the wall clock, s.
double seconds_since(std::chrono::steady_clock::time_point start);

}  // namespace quoin::scene_file
