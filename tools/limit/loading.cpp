#include "limit/loading.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <sstream>

namespace quoin::limit_analysis {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kMostSteps = 1000;  // of a static analysis
constexpr int kIncrements = 6;    // of the way to the proved mechanism
constexpr int kCoulombRounds = 60;
constexpr double kRelaxation = 0.4;  // of what a round says of the normal forces

class Runs {
 public:
  Runs(const VariedScene& scenes, double seconds)
      : scenes_(scenes),
        end_(Clock::now() +
             std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds))) {
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

/// Of a value between what holds and what is lost.
bool near_enough(const Reached& reached) {
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
  if (!limit.stands || !limit.falls) return reached;
  const Runs runs(scenes, seconds);
  const Vary& vary = scenes.vary();
  const double safe = limit.falls->value > limit.stands->value ? vary.from : vary.to;
  double next = limit.stands->value;  // most often it holds there, or close to it
  reached.lost = limit.falls->value;  // proved
  for (;;) {
    const auto run = runs.start(next);
    const Outcome outcome = runs.come_to_rest(*run);
    ++reached.runs;
    progress(told("sudden", next, outcome));
    if (!book(outcome, next, reached)) return reached;
    if (reached.holds && near_enough(reached)) return reached;
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
  if (!limit.stands || !limit.falls) return reached;
  const Runs runs(scenes, seconds);
  const Vary& vary = scenes.vary();
  const double safe = limit.falls->value > limit.stands->value ? vary.from : vary.to;
  double increment = (limit.falls->value - safe) / kIncrements, at = safe;
  reached.lost = limit.falls->value;
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
    if (!reached.holds || near_enough(reached)) return reached;
    const double left = *reached.lost - *reached.holds;
    while (std::abs(increment) > 0.75 * std::abs(left)) increment *= 0.5;
    at = *reached.holds + increment;
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

  /// Takes the forces into the averages; farthest that friction exceeds Coulomb's limit, N.
  double take(const std::vector<Vector3>& forces, double part) {
    double excess = 0.0;
    for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
      const solver::EquilibriumContact& contact = problem.contacts[i];
      if (contact.held || contact.guided) continue;
      const double normal = forces[i].dot(contact.normal);
      const double shear = (forces[i] - normal * contact.normal).norm();
      excess = std::max(excess, shear - contact.friction * normal - contact.cohesion);
      pressed[i] += part * (std::max(0.0, normal) - pressed[i]);
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

}  // namespace

std::optional<CoulombMechanism> coulomb_mechanism(const EquilibriumProblem& problem, double from,
                                                  double to, const Progress& progress) {
  std::optional<CoulombMechanism> lowest;
  Equilibrium found = solver::largest_load_factor(problem, to - from);
  if (found.verdict != EquilibriumVerdict::Admissible || !found.limited) return lowest;
  FrictionLimits limits{problem, std::vector<double>(problem.contacts.size(), 0.0)};
  limits.take(found.forces, 1.0);
  int factorizations = found.factorizations;
  const double range = std::min(to - from, 2.0 * found.factor);
  for (int round = 1; round <= kCoulombRounds; ++round) {
    found = solver::largest_load_factor(limits.fixed(), range);
    factorizations += found.factorizations;
    if (found.verdict != EquilibriumVerdict::Admissible || !found.limited) break;
    const double excess =
        limits.take(found.forces, kRelaxation) / largest_load(problem, found.factor);
    const double value = from + found.factor;
    std::ostringstream text;
    text << "Coulomb mechanism, round " << round << ": " << value << ", friction exceeds by "
         << excess << " of the largest load";
    progress(text.str());
    if (excess > kCoulombExcess || (lowest && value >= lowest->value)) continue;
    lowest = CoulombMechanism{value, excess, round, factorizations};
  }
  return lowest;
}

}  // namespace quoin::limit_analysis
