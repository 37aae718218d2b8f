#include "iteration/cone_projection.hpp"

#include <algorithm>
#include <cmath>

namespace quoin::solver {
namespace {

// Of contacts, by their own Delassus block: of 100, 250 and 400 the one with which shaken walls
// gain least.
constexpr double kStiffness = 250.0;
constexpr int kSearch = 12;         // values of the slope along a step, at most; it ends at
constexpr double kFlatCone = 1e-2;  // of the slope that the step begins with

}  // namespace

void ConeProjection::freeze(std::span<const Admissible> admissible) {
  admissible_.assign(admissible.begin(), admissible.end());
  for (std::size_t i = 0; i < admissible_.size(); ++i) {
    Admissible& forces = admissible_[i];
    forces.cohesion = forces.shear_limit(x_[i][0]);
    forces.friction = 0.0;
  }
}

Vector3 ConeProjection::trial(std::size_t contact, const Vector3& moved) const {
  return x_[contact] - kStiffness * (start_[contact] + moved);
}

/// How far the forces that give D are from P(x - r y), by the largest.
double ConeProjection::update_trials() {
  double left = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    trial_[i] = trial(i, moved_[i]);
    const Vector3 pushed = pushed_[i] = project_on(admissible_[i], trial_[i]);
    left = std::max(left, (pushed - x_[i] - change_[i]).norm());
    largest = std::max(largest, pushed.norm());
  }
  return left / std::max(largest, 1e-300);
}

bool ConeProjection::find_step(ConeProblem& problem) {
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const auto [pushed, derivative] = project_smoothly(admissible_[i], trial_[i], 0.0);
    tangents_[i] = kStiffness * derivative;
    next_change_[i] = pushed - x_[i] + tangents_[i] * moved_[i];
  }
  if (!problem.factorize(tangents_, Tangents::Symmetric)) return false;
  problem.solve(next_change_, next_moved_);
  for (std::size_t i = 0; i < x_.size(); ++i) next_change_[i] -= tangents_[i] * next_moved_[i];
  return true;
}

/// Of the function along the step: it never falls. K D is what the forces are.
double ConeProjection::slope(double share) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const Vector3 step = next_moved_[i] - moved_[i];
    const Vector3 force = x_[i] + change_[i] + share * (next_change_[i] - change_[i]);
    const Vector3 pushed = project_on(admissible_[i], trial(i, moved_[i] + share * step));
    sum += (force - pushed).dot(step);
  }
  return sum;
}

/// Where along the step the function has its minimum: false position, the slope of
/// the end that stays halved.
/// [Dowell & Jarratt 1971]
double ConeProjection::find_share() const {
  double low = 0.0, high = 1.0, low_slope = slope(0.0), high_slope = slope(1.0);
  if (!(high_slope > 0.0) || !(low_slope < 0.0)) return 1.0;
  const double enough = -kFlatCone * low_slope;
  int last = 0;  // the end that moved
  for (int k = 0; k < kSearch; ++k) {
    const double share = (low * high_slope - high * low_slope) / (high_slope - low_slope);
    const double at = slope(share);
    if (std::abs(at) <= enough) return share;
    if (at < 0.0) {
      low = share;
      low_slope = at;
      if (last == -1) high_slope *= 0.5;
      last = -1;
    } else {
      high = share;
      high_slope = at;
      if (last == 1) low_slope *= 0.5;
      last = 1;
    }
  }
  return high;
}

IterationCount ConeProjection::solve(ConeProblem& problem, std::span<const Vector3> x,
                                     std::span<const Vector3> apart, const AddedForces& guess,
                                     const IterationLimit& limit) {
  IterationCount count;
  x_ = x;
  freeze(problem.admissible());
  start_.resize(x.size());
  std::ranges::transform(admissible_, apart, start_.begin(), corrected);
  moved_.assign(guess.motion.begin(), guess.motion.end());
  moved_.resize(x.size(), Vector3::Zero());
  change_.assign(guess.x.begin(), guess.x.end());
  change_.resize(x.size(), Vector3::Zero());
  next_moved_ = next_change_ = trial_ = pushed_ = moved_;
  tangents_.resize(x.size());
  for (;;) {
    count.residual = update_trials();
    count.converged = count.residual <= limit.residual;
    if (count.converged || count.iterations >= limit.iterations) return count;
    ++count.iterations;
    ++count.factorizations;
    if (!find_step(problem)) return count;
    ++count.solves;
    const double share = find_share();
    for (std::size_t i = 0; i < x.size(); ++i) {
      change_[i] += share * (next_change_[i] - change_[i]);
      moved_[i] += share * (next_moved_[i] - moved_[i]);
    }
  }
}

}  // namespace quoin::solver
