#include "iteration/projections.hpp"

#include <algorithm>
#include <cmath>

namespace quoin::solver {
namespace {

// Of contacts in their cones, by their own Delassus block: of 100, 250 and 400 the one with which
// shaken walls gain least.
constexpr double kStiffness = 250.0;
// Of gaps, likewise. Chosen on shaken walls of 27 and 105: 100 leaves ten times the overlaps,
// sticking contacts of 10 take a third more steps.
constexpr double kStiff = 1e3, kStick = 1.0;
constexpr int kSearch = 12;         // values of the slope along a step, at most; it ends at
constexpr double kFlatCone = 1e-2;  // of the slope that the step begins with

/// Where along a step, at most 1, a slope that never falls is zero: false position, the slope of
/// the end that stays halved.   [Dowell & Jarratt 1971]
template <class Slope>
double flat_share(const Slope& slope) {
  double low = 0.0, high = 1.0, low_slope = slope(0.0), high_slope = slope(1.0);
  if (!(high_slope > 0.0) || !(low_slope < 0.0)) return 1.0;
  const double enough = -kFlatCone * low_slope;
  int last = 0;  // the end that moved
  for (int k = 0; k < kSearch; ++k) {
    const double share = (low * high_slope - high * low_slope) / (high_slope - low_slope);
    const double at = slope(share);
    if (std::abs(at) <= enough) return share;
    const int side = at < 0.0 ? 1 : -1;
    (side > 0 ? low : high) = share;
    (side > 0 ? low_slope : high_slope) = at;
    if (last == side) (side > 0 ? high_slope : low_slope) *= 0.5;
    last = side;
  }
  return high;
}

}  // namespace

void ConvexNewton::start(std::size_t contacts, const AddedForces& guess) {
  moved_.assign(guess.motion.begin(), guess.motion.end());
  forces_.assign(guess.x.begin(), guess.x.end());
  for (auto* memory : {&moved_, &forces_, &next_moved_, &next_forces_})
    memory->resize(contacts, Vector3::Zero());
  tangents_.resize(contacts);
}

template <class Force>
bool ConvexNewton::step(ConeProblem& problem, const Force& force) {
  const std::size_t contacts = forces_.size();
  if (!problem.factorize(tangents_, Tangents::Symmetric)) return false;
  problem.solve(next_forces_, next_moved_);
  for (std::size_t i = 0; i < contacts; ++i) next_forces_[i] -= tangents_[i] * next_moved_[i];
  const double share = flat_share([&](double at) {  // K D is what the forces are
    double sum = 0.0;
    for (std::size_t i = 0; i < contacts; ++i) {
      const Vector3 way = next_moved_[i] - moved_[i];
      const Vector3 now = forces_[i] + at * (next_forces_[i] - forces_[i]);
      sum += (now - force(i, moved_[i] + at * way)).dot(way);
    }
    return sum;
  });
  for (std::size_t i = 0; i < contacts; ++i) {
    forces_[i] += share * (next_forces_[i] - forces_[i]);
    moved_[i] += share * (next_moved_[i] - moved_[i]);
  }
  return true;
}

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
    left = std::max(left, (pushed - x_[i] - forces_[i]).norm());
    largest = std::max(largest, pushed.norm());
  }
  return left / std::max(largest, 1e-300);
}

bool ConeProjection::take_step(ConeProblem& problem) {
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const auto [pushed, derivative] = project_smoothly(admissible_[i], trial_[i], 0.0);
    tangents_[i] = kStiffness * derivative;
    next_forces_[i] = pushed - x_[i] + tangents_[i] * moved_[i];
  }
  return step(problem, [&](std::size_t i, const Vector3& moved) -> Vector3 {
    return project_on(admissible_[i], trial(i, moved)) - x_[i];
  });
}

IterationCount ConeProjection::solve(ConeProblem& problem, std::span<const Vector3> x,
                                     std::span<const Vector3> apart, const AddedForces& guess,
                                     const IterationLimit& limit) {
  IterationCount count;
  x_ = x;
  freeze(problem.admissible());
  start_.resize(x.size());
  std::ranges::transform(admissible_, apart, start_.begin(), corrected);
  start(x.size(), guess);
  trial_ = pushed_ = moved_;
  for (;;) {
    count.residual = update_trials();
    count.converged = count.residual <= limit.residual;
    if (count.converged || count.iterations >= limit.iterations) return count;
    ++count.iterations;
    ++count.factorizations;
    if (!take_step(problem)) return count;
    ++count.solves;
  }
}

void GapProjection::set_gaps(std::span<const Vector3> x, std::span<const ContactMode> modes,
                             std::span<const Vector3> motion) {
  gap_.assign(motion.begin(), motion.end());
  borne_.resize(x.size());
  sticks_.resize(x.size());
  closed_.assign(x.size(), 0);
  for (std::size_t i = 0; i < x.size(); ++i) {
    borne_[i] = modes[i] == ContactMode::Open ? 0.0 : x[i][0];
    sticks_[i] = modes[i] == ContactMode::Stick;
  }
  multiplier_ = borne_;
}

/// x_n that the contact bears of what presses it.
double GapProjection::normal_force(std::size_t contact, double trial) const {
  return admissible_[contact].pulls ? trial : std::max(0.0, trial);
}

Vector3 GapProjection::force(std::size_t contact, const Vector3& moved) const {
  const Vector3 left = gap_[contact] + moved;
  Vector3 force = Vector3::Zero();
  force[0] = normal_force(contact, multiplier_[contact] - kStiff * left[0]) - borne_[contact];
  if (sticks_[contact]) force.tail<2>() = -kStick * left.tail<2>();
  return force;
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
bool GapProjection::take_step(ConeProblem& problem, bool first) {
  changed_ = first;
  for (std::size_t i = 0; i < gap_.size(); ++i) {
    const double stick = sticks_[i] ? kStick : 0.0;
    const bool closed = pressed(i) || (first && borne_[i] > 0.0);
    changed_ = changed_ || closed != (closed_[i] != 0);
    closed_[i] = closed;
    tangents_[i] = Vector3(closed ? kStiff : 0.0, stick, stick).asDiagonal();
    next_forces_[i] = -tangents_[i] * gap_[i];
    next_forces_[i][0] += (closed ? multiplier_[i] : 0.0) - borne_[i];
  }
  return step(problem, [&](std::size_t i, const Vector3& moved) { return force(i, moved); });
}

/// Where the function has its minimum: its forces are the next multipliers.
void GapProjection::update_multipliers() {
  for (std::size_t i = 0; i < gap_.size(); ++i)
    multiplier_[i] = normal_force(i, borne_[i] + forces_[i][0]);
}

IterationCount GapProjection::solve(ConeProblem& problem, std::span<const Vector3> x,
                                    std::span<const ContactMode> modes,
                                    std::span<const Vector3> motion, const AddedForces& guess,
                                    const IterationLimit& limit) {
  IterationCount count;
  admissible_ = problem.admissible();
  set_gaps(x, modes, motion);
  start(x.size(), guess);
  if (!guess.x.empty()) update_multipliers();
  bool apart = std::max(largest_gap(problem), largest_stretch(problem)) > limit.residual;
  while (apart && count.iterations < limit.iterations) {
    ++count.iterations;
    ++count.factorizations;
    if (!take_step(problem, count.iterations == 1 && guess.x.empty())) break;
    ++count.solves;
    apart = largest_gap(problem) > limit.residual;
    if (!changed_) update_multipliers();
  }
  count.converged = !apart;
  return count;
}

}  // namespace quoin::solver
