#include "iteration/gap_projection.hpp"

#include <algorithm>
#include <cmath>

namespace quoin::solver {
namespace {

// By each contact's own Delassus block. Chosen on shaken walls of 27 and 105: 100 leaves ten times
// the overlaps, sticking contacts of 10 take a third more steps.
constexpr double kStiff = 1e3, kStick = 1.0;
constexpr int kHalvings = 20;  // of a step, in the search along it

}  // namespace

void GapProjection::start(const ConeProblem& problem, std::span<const Vector3> x,
                          std::span<const ContactMode> modes, std::span<const Vector3> motion) {
  admissible_ = problem.admissible();
  forces_.assign(x.size(), Vector3::Zero());
  moved_ = next_moved_ = gap_ = forces_;
  next_forces_.clear();
  tangents_.assign(x.size(), Matrix3::Zero());
  borne_.resize(x.size());
  sticks_.resize(x.size());
  closed_.assign(x.size(), 0);
  for (std::size_t i = 0; i < x.size(); ++i) {
    gap_[i] = motion[i];
    borne_[i] = modes[i] == ContactMode::Open ? 0.0 : x[i][0];
    sticks_[i] = modes[i] == ContactMode::Stick;
  }
  multiplier_ = borne_;
}

void GapProjection::start_from(const AddedForces& guess) {
  if (guess.x.empty()) return;
  forces_.assign(guess.x.begin(), guess.x.end());
  moved_.assign(guess.motion.begin(), guess.motion.end());
  update_multipliers();
  next_forces_ = forces_;
}

/// x_n that the contact bears of what presses it.
double GapProjection::normal_force(std::size_t contact, double trial) const {
  return admissible_[contact].pulls ? trial : std::max(0.0, trial);
}

bool GapProjection::pressed(std::size_t contact) const {
  if (admissible_[contact].pulls) return true;
  return kStiff * (gap_[contact][0] + moved_[contact][0]) < multiplier_[contact];
}

/// m
double GapProjection::largest_stretch(const ConeProblem& problem) const {
  double most = 0.0;
  for (std::size_t i = 0; i < gap_.size(); ++i) {
    if (!sticks_[i]) continue;
    most = std::max(most, problem.motion(i, gap_[i] + moved_[i]).tail<2>().norm());
  }
  return most;
}

/// Of contacts that are pressed, m.
double GapProjection::largest_gap(const ConeProblem& problem) const {
  double most = 0.0;
  for (std::size_t i = 0; i < gap_.size(); ++i) {
    if (!pressed(i)) continue;
    most = std::max(most, std::abs(problem.motion(i, gap_[i] + moved_[i])[0]));
  }
  return most;
}

/// The first one takes all that bear forces for closed.
bool GapProjection::find_step(ConeProblem& problem) {
  const bool first = next_forces_.empty();
  next_forces_.resize(gap_.size());
  changed_ = first;
  for (std::size_t i = 0; i < gap_.size(); ++i) {
    const double stick = sticks_[i] ? kStick : 0.0;
    const bool closed = pressed(i) || (first && borne_[i] > 0.0);
    changed_ = changed_ || closed != (closed_[i] != 0);
    closed_[i] = closed;
    tangents_[i].diagonal() << (closed ? kStiff : 0.0), stick, stick;
    next_forces_[i] = -tangents_[i] * gap_[i];
    next_forces_[i][0] += (closed ? multiplier_[i] : 0.0) - borne_[i];
  }
  if (!problem.factorize(tangents_, Tangents::Symmetric)) return false;
  problem.solve(next_forces_, next_moved_);
  for (std::size_t i = 0; i < gap_.size(); ++i) next_forces_[i] -= tangents_[i] * next_moved_[i];
  return true;
}

/// Of the function along the step: piecewise linear, it never falls. K D is what the forces are.
double GapProjection::slope(double share) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < gap_.size(); ++i) {
    const Vector3 step = next_moved_[i] - moved_[i];
    const Vector3 left = gap_[i] + moved_[i] + share * step;
    sum += (forces_[i] + share * (next_forces_[i] - forces_[i])).dot(step);
    sum += (borne_[i] - normal_force(i, multiplier_[i] - kStiff * left[0])) * step[0];
    if (sticks_[i]) sum += kStick * left.tail<2>().dot(step.tail<2>());
  }
  return sum;
}

/// Where the function has its minimum: its forces are the next multipliers.
void GapProjection::update_multipliers() {
  for (std::size_t i = 0; i < gap_.size(); ++i)
    multiplier_[i] = normal_force(i, borne_[i] + forces_[i][0]);
}

void GapProjection::take_step() {
  double share = 1.0, low = 0.0;
  if (slope(1.0) > 0.0) {
    for (int k = 0; k < kHalvings; ++k) {
      const double middle = 0.5 * (low + share);
      (slope(middle) < 0.0 ? low : share) = middle;
    }
  }
  for (std::size_t i = 0; i < gap_.size(); ++i) {
    forces_[i] += share * (next_forces_[i] - forces_[i]);
    moved_[i] += share * (next_moved_[i] - moved_[i]);
  }
}

IterationCount GapProjection::solve(ConeProblem& problem, std::span<const Vector3> x,
                                    std::span<const ContactMode> modes,
                                    std::span<const Vector3> motion, const AddedForces& guess,
                                    const IterationLimit& limit) {
  IterationCount count;
  start(problem, x, modes, motion);
  start_from(guess);
  bool apart = std::max(largest_gap(problem), largest_stretch(problem)) > limit.residual;
  while (apart && count.iterations < limit.iterations) {
    ++count.iterations;
    ++count.factorizations;
    if (!find_step(problem)) break;
    ++count.solves;
    take_step();
    apart = largest_gap(problem) > limit.residual;
    if (!changed_) update_multipliers();
  }
  count.converged = !apart;
  return count;
}

}  // namespace quoin::solver
