#include "limit/settlement.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "scene_file/mechanism_proof.hpp"

namespace quoin::limit_analysis {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kRangeIncrements = 16;    // of the range
constexpr int kStepsOfOne = 40;         // dynamic
constexpr double kAlmostClosed = 1e-5;  // of the smallest block
constexpr double kSlow = 12.0;          // times the time in which a stone falls as far

class Path {
 public:
  Path(const VariedScene& scenes, double seconds)
      : scene_(scenes.file().scene),
        options_(scenes.file().options),
        end_(Clock::now() +
             std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds))) {
    const std::string& name = scenes.vary().name;
    for (std::size_t b = 0; b < scene_.blocks.size(); ++b)
      if (scene_.blocks[b].name == name) support_ = static_cast<int>(b);
    if (support_ < 0 || block().kind != solver::BlockKind::Fixed)
      throw std::invalid_argument("--vary settlement=" + name + ": no fixed block has that name");
    const Vector3 gravity = scene_.gravity.at(0.0);
    if (!(gravity.norm() > 0.0))
      throw std::invalid_argument("--vary settlement=" + name + ": gravity is 0");
    gravity_ = gravity.norm();
    down_ = gravity / gravity_;
    block().kind = solver::BlockKind::Prescribed;
    options_.watch = [this](const solver::StepReport&) { return Clock::now() < end_; };
  }

  /// Sinks by so much and comes to rest; false: it does not.
  bool go(solver::Simulation& run, double way) {
    if (way > 0.0) {
      const double duration = kSlow * std::sqrt(2.0 * way / gravity_);
      const double begins = run.state().time;
      block().motion.value =
          solver::interpolate({begins, begins + 0.5 * duration, begins + duration},
                              {Vector3::Zero(), 2.0 * way / duration * down_, Vector3::Zero()});
      run.change(scene_);
      options_.analysis = solver::Analysis::Dynamic;
      options_.time_step = duration / kStepsOfOne;
      run.set_options(options_);
      bool moves = true;
      for (int i = 0; i < kStepsOfOne && moves; ++i)
        moves = run.advance().status == solver::StepStatus::Converged;
      block().motion.value = Vector3(0, 0, 0);  // what is saved stands still, and is resumed so
      if (!moves) return false;
      run.change(scene_);
    }
    options_.analysis = solver::Analysis::Static;
    return come_to_rest(run, options_) == Outcome::Holds;
  }

  std::unique_ptr<solver::Simulation> start() const {
    return std::make_unique<solver::Simulation>(scene_, options_);
  }
  std::unique_ptr<solver::Simulation> resume(const std::string& saved) const {
    std::istringstream in(saved);
    return std::make_unique<solver::Simulation>(scene_, options_, in);
  }
  bool out_of_time() const { return Clock::now() >= end_; }

  /// The geometry as the run has it.
  Trial judged(const solver::Simulation& run, double value) const {
    Trial trial{value, scene_file::standing_scene(run)};
    trial.scene.blocks[static_cast<std::size_t>(support_)].kind = solver::BlockKind::Fixed;
    trial.problem = solver::equilibrium_problem(trial.scene);
    trial.found = solver::find_equilibrium(trial.problem);
    if (trial.found.verdict == EquilibriumVerdict::Admissible) return trial;
    // What falls with these contacts falls without those that are open by a hair.
    double least = std::numeric_limits<double>::infinity();
    for (const auto& block : trial.problem.blocks) least = std::min(least, block.size);
    trial.problem = solver::equilibrium_problem(trial.scene, kAlmostClosed * least);
    trial.found = solver::find_equilibrium(trial.problem);
    std::vector<Vector6> strict;
    decide(trial, strict);
    if (trial.found.verdict == EquilibriumVerdict::Admissible)
      trial.found.verdict = EquilibriumVerdict::Undecided;
    return trial;
  }

 private:
  solver::Block& block() { return scene_.blocks[static_cast<std::size_t>(support_)]; }

  Scene scene_;
  solver::StepOptions options_;
  Clock::time_point end_;
  int support_ = -1;
  double gravity_ = 0.0;
  Vector3 down_ = Vector3::Zero();
};

std::string saved_state(const solver::Simulation& run) {
  std::ostringstream out;
  run.save(out);
  return out.str();
}

}  // namespace

Limit settle(const VariedScene& scenes, double tolerance, double seconds, const Progress& progress,
             Reached& reached) {
  Path path(scenes, seconds);
  Limit limit;
  const Vary& vary = scenes.vary();
  double increment = (vary.to - vary.from) / kRangeIncrements, way = vary.from, at = vary.from;
  auto run = path.start();
  std::string saved;
  for (;;) {
    const bool came_to_rest = path.go(*run, way);
    Trial trial = path.judged(*run, at);
    const bool rests = came_to_rest && trial.found.verdict != EquilibriumVerdict::Mechanism;
    ++reached.runs;
    std::ostringstream text;
    text << "settlement: " << at << (rests ? " holds" : " is lost");
    progress(text.str());
    if (path.out_of_time()) {
      reached.why = "the time for runs is over";
      break;
    }
    (rests ? reached.holds : reached.lost) = at;
    if (rests) saved = saved_state(*run);
    if (!rests) limit.falls.reset();
    if (trial.found.verdict ==
        (rests ? EquilibriumVerdict::Admissible : EquilibriumVerdict::Mechanism))
      (rests ? limit.stands : limit.falls) = std::make_unique<Trial>(std::move(trial));
    if (!reached.holds || (rests && at >= vary.to)) break;
    if (reached.lost) {
      if (*reached.lost - *reached.holds <= tolerance * (vary.to - vary.from)) break;
      increment = 0.5 * (*reached.lost - *reached.holds);
    }
    at = std::min(*reached.holds + increment, vary.to);
    way = at - *reached.holds;
    run = path.resume(saved);
  }
  if (!reached.lost) limit.why = "it stands at both ends of the range";
  if (!reached.holds) limit.why = "it does not rest at the start of the range";
  if (reached.lost && !limit.falls) limit.why = "no mechanism is proved where the run loses rest";
  if (reached.holds && limit.falls && !(limit.stands && limit.stands->value >= *reached.holds))
    limit.why = "no forces are proved where the run rests last";
  if (!reached.why.empty()) limit.why = reached.why;
  return limit;
}

}  // namespace quoin::limit_analysis
