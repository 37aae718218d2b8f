#include "limit/proofs.hpp"

#include <algorithm>
#include <cmath>

namespace quoin::limit_analysis {
namespace {

// Of the limit: mechanisms so far above it open contacts widely, the nearer ones work harder.
constexpr double kFar[] = {0.5, 0.05, 0.005};
constexpr double kClosest = 0.1;  // to the limit that is tried: of the tolerance
constexpr double kWider = 3.0;
constexpr int kTries = 10;
constexpr double kLeastValue =
    1e-6;  // of the range: a limit near 0 is proved to the tolerance of it

/// What moves if every contact pushes its blocks apart.
std::vector<Vector6> opening(EquilibriumProblem problem) {
  for (solver::EquilibriumBlock& block : problem.blocks) {
    block.load.setZero();
    block.live.setZero();
  }
  for (const solver::EquilibriumContact& contact : problem.contacts) {
    for (const auto& [b, sign] : {std::pair(contact.a, -1.0), {contact.b, 1.0}}) {
      if (b < 0 || contact.held || contact.guided) continue;
      solver::EquilibriumBlock& block = problem.blocks[static_cast<std::size_t>(b)];
      block.load.head<3>() += sign * contact.normal;
      block.load.tail<3>() += (contact.point - block.place).cross(sign * contact.normal);
    }
  }
  return solver::find_equilibrium(problem).velocities;
}

}  // namespace

void decide(Trial& trial, std::vector<Vector6>& strict) {
  if (trial.found.verdict != EquilibriumVerdict::Undecided) return;
  if (strict.empty()) strict = opening(trial.problem);
  const Equilibrium found =
      solver::combined_mechanism(trial.problem, trial.factor, trial.found.velocities, strict);
  if (found.verdict == EquilibriumVerdict::Mechanism) trial.found = found;
}

namespace {

bool keep(Trial trial, Limit& limit) {
  decide(trial, limit.strict);
  if (trial.found.verdict == EquilibriumVerdict::Undecided) return false;
  if (trial.found.verdict == EquilibriumVerdict::Mechanism && limit.strict.empty())
    limit.strict = trial.found.velocities;
  auto& place = trial.found.verdict == EquilibriumVerdict::Admissible ? limit.stands : limit.falls;
  place = std::make_unique<Trial>(std::move(trial));
  return true;
}

bool laps_over(const Limit& limit) {
  return limit.stands && limit.falls && !(limit.stands->value < limit.falls->value);
}

double apart(const Limit& limit, double range) {
  const double low = limit.stands->value, high = limit.falls->value;
  return std::abs(high - low) / std::max({std::abs(low), std::abs(high), kLeastValue * range});
}

/// Falls at the least value that mechanisms of the convex problem prove, with help of those of
/// larger values.
void prove_fall(const std::function<Trial(double)>& at, const Equilibrium& largest, double from,
                double size, Limit& limit) {
  for (const double far : kFar) {
    Trial trial = at(limit.convex + far * size);
    decide(trial, limit.strict);
    if (trial.found.verdict != EquilibriumVerdict::Mechanism) continue;
    const std::vector<Vector6> strict = trial.found.velocities;
    for (const auto& tight : {largest.velocities, strict}) {
      Equilibrium found = solver::least_falling_factor(trial.problem, tight, strict);
      if (found.verdict != EquilibriumVerdict::Mechanism) continue;
      if (limit.falls && limit.falls->factor <= found.factor) continue;
      trial.value = from + found.factor;
      trial.factor = found.factor;
      trial.found = std::move(found);
      limit.falls = std::make_unique<Trial>(trial);
    }
  }
}

}  // namespace

Limit prove_factor(const std::function<Trial(double)>& at, const Equilibrium& largest, double from,
                   double to, double tolerance) {
  Limit limit;
  if (largest.verdict == EquilibriumVerdict::Mechanism || !largest.limited) {
    const bool falls = largest.verdict == EquilibriumVerdict::Mechanism;
    if (!keep(at(falls ? from : to), limit)) limit.why = "neither is proved there";
    return limit;
  }
  limit.convex = from + largest.factor;
  const double range = to - from, size = std::max(std::abs(limit.convex), kLeastValue * range);
  prove_fall(at, largest, from, size, limit);
  if (!limit.falls) keep(at(limit.convex + 0.49 * tolerance * size), limit);
  const bool borne = largest.verdict == EquilibriumVerdict::Admissible;
  if (limit.falls && borne && largest.islands == 1) {  // of more islands it knows one's forces
    limit.stands = std::make_unique<Trial>(*limit.falls);
    limit.stands->value = limit.convex;
    limit.stands->factor = largest.factor;
    limit.stands->found = largest;
  }
  // From close to the limit, where proofs may fail, outwards: mechanisms, then forces.
  const double closest = kClosest * tolerance * size;
  const auto is_wide = [&] {
    return !limit.falls || !limit.stands || apart(limit, range) > tolerance;
  };
  for (double width = closest; limit.falls; width *= kWider) {
    const double value = limit.convex + width;
    if (limit.falls->value <= value || limit.falls->value - limit.convex < 6.0 * closest) break;
    keep(at(value), limit);
  }
  double width = closest;
  for (int i = 0; i < kTries && is_wide(); ++i, width *= kWider) {
    const double value = std::max(from, limit.convex - width);
    if (!limit.stands || value > limit.stands->value) keep(at(value), limit);
  }
  if (limit.falls && limit.falls->value - limit.convex < 100.0 * closest)
    for (double below = 0.3 * closest; below < 10.0 * closest && is_wide(); below *= kWider)
      keep(at(limit.falls->value - below), limit);
  // Each is proved to rounding of the largest load, by which they may lap over.
  for (double below = closest; below < 100.0 * closest && laps_over(limit); below *= kWider)
    keep(at(limit.falls->value - below), limit);
  if (limit.stands && limit.falls)
    limit.convex = std::clamp(limit.convex, limit.stands->value, limit.falls->value);
  if (limit.stands && limit.falls && apart(limit, range) > tolerance)
    limit.why = "nearer to the limit neither is proved";
  return limit;
}

Limit prove_between(const std::function<Trial(double)>& at, double from, double to,
                    double tolerance) {
  Limit limit;
  for (const double end : {from, to})
    if (!keep(at(end), limit)) limit.why = "neither is proved at an end of the range";
  while (limit.stands && limit.falls && apart(limit, to - from) > tolerance) {
    const double low = limit.stands->value, high = limit.falls->value;
    bool decided = false;
    for (const double share : {0.5, 0.4, 0.6, 0.25, 0.75})
      decided = decided || keep(at(low + share * (high - low)), limit);
    if (decided) continue;
    limit.why = "between them neither is proved";
    break;
  }
  return limit;
}

Limit prove(VariedScene& scenes, double tolerance) {
  const auto at = [&](double value) { return scenes.at(value); };
  const Vary& vary = scenes.vary();
  Limit first;  // a load may hold what falls without it
  if (vary.what == "load") keep(at(vary.from), first);
  Limit limit = vary.what == "load" && !first.falls
                    ? prove_factor(at, scenes.largest(), vary.from, vary.to, tolerance)
                : vary.what == "friction"
                    ? prove_between(at, vary.to, vary.from, tolerance)  // less of it is worse
                    : prove_between(at, vary.from, vary.to, tolerance);
  if (!limit.stands && first.falls) limit.falls = std::move(first.falls);
  if (!(limit.stands && limit.falls) && limit.why.empty()) {
    limit.why =
        limit.stands ? "it stands at both ends of the range" : "it falls at both ends of the range";
  }
  return limit;
}

std::unique_ptr<Trial> stands_brittle(VariedScene& scenes, double tolerance) {
  std::unique_ptr<Trial> best;
  for (const Joints joints : {Joints::Whole, Joints::Broken}) {
    scenes.judge_by(joints);
    Limit found = prove(scenes, tolerance);
    if (!found.stands) continue;
    const double value = found.stands->value;
    const bool everywhere = !found.falls, rises = everywhere || found.falls->value > value;
    const bool farther = !best || (rises ? value > best->value : value < best->value);
    if (farther || everywhere) best = std::move(found.stands);
    if (everywhere) break;
  }
  scenes.judge_by(Joints::Yield);
  return best;
}

}  // namespace quoin::limit_analysis
