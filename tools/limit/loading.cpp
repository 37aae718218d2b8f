#include "limit/loading.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <numbers>
#include <sstream>

namespace quoin::limit_analysis {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kMostSteps = 1000;  // of a static analysis
constexpr int kIncrements = 6;    // of the way to the proved mechanism
constexpr int kCoulombRounds = 60;
constexpr double kSameFactor = 1e-9;
constexpr double kLargestStrength = 1e3;
constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kRelaxation = 0.4;  // of what a round says of the normal forces

Clock::time_point end_after(double seconds) {
  return Clock::now() +
         std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

/// Told what has been done; false: the time is over.
using Watch = std::function<bool(const std::string&)>;

class Runs {
 public:
  Runs(const VariedScene& scenes, double seconds) : scenes_(scenes), end_(end_after(seconds)) {
    options_ = scenes.file().options;
    options_.analysis = solver::Analysis::Static;
    options_.watch = [this](const solver::StepReport&) { return Clock::now() < end_; };
  }

  std::unique_ptr<solver::Simulation> start(double value) const {
    return std::make_unique<solver::Simulation>(scenes_.scene_at(value), options_);
  }

  /// Goes on from what was saved, under the value's loads.
  std::unique_ptr<solver::Simulation> resume(double saved, const std::string& state,
                                             double value) const {
    std::istringstream in(state);
    auto run = std::make_unique<solver::Simulation>(scenes_.scene_at(saved), options_, in);
    run->change(scenes_.scene_at(value));
    return run;
  }

  Outcome come_to_rest(solver::Simulation& run) const {
    return limit_analysis::come_to_rest(run, options_);
  }

 private:
  const VariedScene& scenes_;
  Clock::time_point end_;
  solver::StepOptions options_;
};

/// Where rest is surest, and the value that runs try to reach: proved to fall, or the range's end.
struct Way {
  double safe = 0.0, far = 0.0;
};

Way way_of(const Vary& vary, const Limit& limit) {
  const double safe = rises(vary, limit) ? vary.from : vary.to;
  return {safe, limit.falls ? limit.falls->value : vary.from + vary.to - safe};
}

/// Of a value between what holds and what is lost.
bool near_enough(const Reached& reached) {
  if (!reached.lost) return false;
  const double low = *reached.holds, high = *reached.lost;
  return std::abs(high - low) <= kRunTolerance * std::max(std::abs(low), std::abs(high));
}

std::string told(const char* how, double value, Outcome outcome) {
  static constexpr const char* kNames[] = {"holds", "is lost", "was not solved", "took too long"};
  std::ostringstream text;
  text << how << " loading: " << value << ' ' << kNames[static_cast<int>(outcome)];
  return text.str();
}

/// False: the search is over.
bool book(Outcome outcome, double value, Reached& reached) {
  if (outcome == Outcome::OutOfTime) {
    reached.why = "the time for runs is over";
    return false;
  }
  if (outcome == Outcome::Unsolved) reached.why = "a run was not solved, and counts as lost";
  (outcome == Outcome::Holds ? reached.holds : reached.lost) = value;
  return true;
}

}  // namespace

bool rises(const Vary& vary, const Limit& limit) {
  return limit.falls ? limit.falls->value > limit.stands->value : vary.what != "friction";
}

Outcome come_to_rest(solver::Simulation& run, const solver::StepOptions& options) {
  run.set_options(options);
  for (int i = 0; i < kMostSteps; ++i) {
    const solver::StepReport report = run.advance();
    if (report.status == solver::StepStatus::Stopped) return Outcome::OutOfTime;
    if (report.status != solver::StepStatus::Converged) return Outcome::Unsolved;
    if (report.verdict == solver::StaticVerdict::Rest) return Outcome::Holds;
    if (report.verdict == solver::StaticVerdict::Mechanism) return Outcome::Lost;
  }
  return Outcome::Unsolved;
}

Reached sudden_loading(const VariedScene& scenes, const Limit& limit, double seconds,
                       const Progress& progress) {
  Reached reached;
  if (!limit.stands) return reached;
  const Runs runs(scenes, seconds);
  const auto [safe, far] = way_of(scenes.vary(), limit);
  double next = far;
  if (limit.falls) {
    next = limit.stands->value;  // most often it holds there, or close to it
    reached.lost = far;          // proved
  }
  for (;;) {
    const auto run = runs.start(next);
    const Outcome outcome = runs.come_to_rest(*run);
    ++reached.runs;
    progress(told("sudden", next, outcome));
    if (!book(outcome, next, reached)) return reached;
    if (!reached.lost || (reached.holds && near_enough(reached))) return reached;
    if (!reached.holds && next == safe) return reached;
    const double bottom = reached.holds.value_or(safe);
    // First close below the limit, then halves.
    next = reached.holds || reached.runs > 1 ? 0.5 * (bottom + *reached.lost)
                                             : *reached.lost + 0.05 * (safe - *reached.lost);
    if (std::abs(next - safe) <= kRunTolerance * std::abs(*reached.lost - safe)) next = safe;
  }
}

Reached gradual_loading(const VariedScene& scenes, const Limit& limit, double seconds,
                        const Progress& progress) {
  Reached reached;
  if (!limit.stands) return reached;
  const Runs runs(scenes, seconds);
  const auto [safe, far] = way_of(scenes.vary(), limit);
  double increment = (far - safe) / kIncrements, at = safe;
  if (limit.falls) reached.lost = far;
  std::string saved;
  for (;;) {
    const auto run = saved.empty() ? runs.start(at) : runs.resume(*reached.holds, saved, at);
    const Outcome outcome = runs.come_to_rest(*run);
    ++reached.runs;
    progress(told("gradual", at, outcome));
    if (!book(outcome, at, reached)) return reached;
    if (outcome == Outcome::Holds) {
      std::ostringstream out;
      run->save(out);
      saved = out.str();
    }
    if (!reached.holds || reached.holds == far || near_enough(reached)) return reached;
    const double left = reached.lost.value_or(far) - *reached.holds;
    while (reached.lost && std::abs(increment) > 0.75 * std::abs(left)) increment *= 0.5;
    const bool is_last = !reached.lost && std::abs(left) < 1.5 * std::abs(increment);
    at = is_last ? far : *reached.holds + increment;
  }
}

namespace {

/// Friction's limits by contact: of normal forces on average.
struct FrictionLimits {
  const EquilibriumProblem& problem;
  std::vector<double> pressed;

  EquilibriumProblem fixed() const {
    EquilibriumProblem result = problem;
    for (std::size_t i = 0; i < result.contacts.size(); ++i) {
      solver::EquilibriumContact& contact = result.contacts[i];
      contact.cohesion += contact.friction * pressed[i];
      contact.friction = 0.0;
    }
    return result;
  }

  /// Takes the forces, whose normal parts stand for `scale` times those that press, into the
  /// averages; farthest that friction exceeds Coulomb's limit, N.
  double take(const std::vector<Vector3>& forces, double scale, double part) {
    double excess = 0.0;
    for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
      const solver::EquilibriumContact& contact = problem.contacts[i];
      if (contact.held || contact.guided) continue;
      const double normal = forces[i].dot(contact.normal);
      const double shear = (forces[i] - normal * contact.normal).norm();
      const double pressing = normal / scale;
      excess = std::max(excess, shear - contact.friction * pressing - contact.cohesion);
      pressed[i] += part * (std::max(0.0, pressing) - pressed[i]);
    }
    return excess;
  }
};

double largest_load(const EquilibriumProblem& problem, double factor) {
  double largest = 0.0;
  for (const solver::EquilibriumBlock& block : problem.blocks) {
    if (!block.moves) continue;
    largest = std::max(largest, (block.load + factor * block.live).head<3>().norm());
  }
  return largest;
}

/// What the factor of a mechanism multiplies.
enum class FactorOf : std::uint8_t {
  LiveLoads,
  Strength  ///< the inverse: friction, cohesion and tension are divided; all loads are live
};

struct Factor {
  double value = 0.0, excess = 0.0;
  double at_most() const { return value * (1.0 + excess); }
};

/// The lowest factor found from forces that balance the loads on.
std::optional<Factor> lowest_factor(const EquilibriumProblem& problem,
                                    const std::vector<Vector3>& forces, double largest,
                                    FactorOf factor_of, const Watch& watch) {
  std::optional<Factor> lowest;
  FrictionLimits limits{problem, std::vector<double>(problem.contacts.size(), 0.0)};
  limits.take(forces, 1.0, 1.0);
  double last = 0.0;
  for (int round = 1; round <= kCoulombRounds; ++round) {
    const Equilibrium found = solver::largest_load_factor(limits.fixed(), largest);
    const double wrong = std::max(found.unbalance, found.violation);
    if (!found.limited || !(found.factor > 0.0) || wrong > kCoulombExcess) break;
    const double scale = factor_of == FactorOf::Strength ? found.factor : 1.0;
    const double excess =
        limits.take(found.forces, scale, kRelaxation) / largest_load(problem, found.factor);
    std::ostringstream text;
    text << "mechanism without dilation, round " << round << ": " << found.factor
         << ", friction exceeds by " << excess << " of the largest load";
    const bool agrees = excess <= kCoulombExcess;
    if (agrees && !(lowest && found.factor * (1.0 + excess) >= lowest->at_most()))
      lowest = Factor{found.factor, excess};
    const bool same = std::abs(found.factor - last) <= kSameFactor * found.factor;
    if (!watch(text.str()) || (same && excess <= kSameFactor)) break;
    last = found.factor;
  }
  return lowest;
}

/// Of strength, in a scene as it stands at `value`.
std::optional<Factor> strength_factor(VariedScene& scenes, double value, const Trial* forces_of,
                                      double largest, const Watch& watch) {
  const Trial trial = scenes.at(value);
  if (forces_of == nullptr) forces_of = &trial;
  if (forces_of->found.verdict != EquilibriumVerdict::Admissible) return std::nullopt;
  EquilibriumProblem problem = trial.problem;
  for (solver::EquilibriumBlock& block : problem.blocks) {
    block.live = block.load;
    block.load.setZero();
  }
  return lowest_factor(problem, forces_of->found.forces, largest, FactorOf::Strength, watch);
}

bool has_strength_without_friction(const Scene& scene) {
  const auto has = [](const solver::Joint& joint) {
    return joint.cohesion > 0.0 || joint.tension > 0.0;
  };
  return has(scene.joint) ||
         std::ranges::any_of(scene.pair_joints, has, &solver::PairJoint::joint) ||
         std::ranges::any_of(scene.block_joints, has, &solver::BlockJoint::joint);
}

/// Of a value on which strength depends in any way: where its factor is 1.
std::optional<CoulombMechanism> mechanism_between(VariedScene& scenes, const Limit& limit,
                                                  const Watch& watch) {
  auto [safe, lost] = way_of(scenes.vary(), limit);
  if (limit.falls) lost = limit.stands->value;
  std::optional<CoulombMechanism> found;
  const auto is_lost = [&](double value) {
    const auto factor = strength_factor(scenes, value, nullptr, kLargestStrength, watch);
    if (!factor || factor->value >= 1.0) return false;
    found = {value, factor->excess};
    return true;
  };
  if (!is_lost(lost)) return std::nullopt;
  const double enough = kRunTolerance * std::abs(lost - safe);
  while (std::abs(lost - safe) > enough) {
    const double middle = 0.5 * (safe + lost);
    (is_lost(middle) ? lost : safe) = middle;
    if (!watch("")) break;
  }
  return found;
}

}  // namespace

std::optional<CoulombMechanism> coulomb_mechanism(VariedScene& scenes, const Limit& limit,
                                                  double seconds, const Progress& progress) {
  const auto end = end_after(seconds);
  const Watch watch = [&](const std::string& line) {
    if (!line.empty()) progress(line);
    return Clock::now() < end;
  };
  const Vary& vary = scenes.vary();
  const double far = way_of(vary, limit).far;
  if (vary.what == "load") {
    const double largest = std::min(vary.to, 2.0 * far) - vary.from;
    const auto found = lowest_factor(scenes.load_problem(), limit.stands->found.forces, largest,
                                     FactorOf::LiveLoads, watch);
    if (found) return CoulombMechanism{vary.from + found->value, found->excess};
  } else if (vary.what == "strength") {
    const auto found = strength_factor(scenes, 1.0, limit.stands.get(), 2.0 * far, watch);
    if (found) return CoulombMechanism{found->value, found->excess};
  } else if (vary.what == "friction" && !has_strength_without_friction(scenes.file().scene)) {
    const auto found = strength_factor(scenes, 45.0, limit.stands.get(), kLargestStrength, watch);
    if (found) return CoulombMechanism{std::atan(1.0 / found->value) * kDegrees, found->excess};
  } else {
    return mechanism_between(scenes, limit, watch);
  }
  return std::nullopt;
}

}  // namespace quoin::limit_analysis
