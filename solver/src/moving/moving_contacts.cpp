#include "moving/moving_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "moving/cone.hpp"

namespace quoin::solver {
namespace {

// Chosen on single steps of piles, shaken walls, towers, arches and slopes, and on runs of them.
constexpr int kSweeps = 10;
constexpr double kForces = 1e4;     // times the tolerance: gaps come out as much better than forces
constexpr int kMostHard = 20;       // steps on hard contacts before they yield by
constexpr double kSoftness = 0.03;  // and, where Newton's method does not end in
constexpr int kMostSoft = 12;       // steps, by
constexpr double kSofter = 4.0;     // times as much, up to
constexpr double kSoftest = 2.0;
constexpr double kNear = 1e-3;    // the residual from which hard contacts are what they yield about
constexpr int kMostUpdates = 3;   // of the forces about which they yield, while they do so by
constexpr double kYield = 1e-6;   // more than this of the smallest block,
constexpr double kLess = 0.7;     // by less than this of the time before,
constexpr int kMostInUpdate = 8;  // and in so many steps

void add(const IterationCount& part, IterationCount& total) {
  total.converged = part.converged;
  total.residual = part.residual;
  total.iterations += part.iterations;
  total.solves += part.solves;
  total.factorizations += part.factorizations;
}

}  // namespace

/// `first`: the first linearisation of a step, which sweeps; the others are near their solution.
void MovingContacts::start(std::span<const LinearContact> contacts, bool first) {
  x_.resize(contacts.size());
  motion_.resize(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    x_[i] = project_on_cone(problem_.cone_force(i, contacts[i].multiplier));
  }
  bar_ = x_;
  if (!first) {
    for (std::size_t i = 0; i < bar_.size(); ++i) bar_[i] = problem_.cone_force(i, bar_force_[i]);
    return;
  }
  softness_ = 0.0;
  problem_.respond(x_, motion_);
  for (int sweep = 0; sweep < kSweeps; ++sweep) problem_.sweep(x_);
  bar_ = x_;
}

/// How far contacts yield, m.
double MovingContacts::largest_yield() const {
  double most = 0.0;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    most = std::max(most, problem_.motion(i, softness_ * (x_[i] - bar_[i])).norm());
  }
  return most;
}

IterationCount MovingContacts::solve_soft(double tolerance) {
  IterationCount total;
  while (iterations_left_ > 0) {
    const IterationLimit limit{tolerance, std::min(kMostSoft, iterations_left_)};
    const IterationCount count = newton_.solve_soft(problem_, softness_, bar_, limit, x_);
    iterations_left_ -= count.iterations;
    add(count, total);
    if (count.converged || softness_ * kSofter > kSoftest) break;
    softness_ *= kSofter;
    x_ = bar_;
  }
  return total;
}

/// Hard contacts; where these are not found contacts yield, about forces that push no block out:
/// those of the sweeps while hard ones are far from a solution.
IterationCount MovingContacts::iterate(double tolerance, double allowed_yield) {
  if (softness_ > 0.0) return solve_soft(tolerance);
  IterationCount total =
      newton_.solve_hard(problem_, {tolerance, std::min(kMostHard, iterations_left_)}, x_);
  iterations_left_ -= total.iterations;
  if (total.residual <= kNear) bar_ = x_;
  if (total.converged) return total;
  softness_ = kSoftness;
  add(solve_soft(tolerance), total);
  if (total.converged) add(yield_less(tolerance, allowed_yield), total);
  return total;
}

/// Contacts that yield too far do so about the forces that they have come to, and again: the
/// proximal point method. What there was is a solution, too, where that does not end.
IterationCount MovingContacts::yield_less(double tolerance, double allowed_yield) {
  IterationCount total{.converged = true};
  double yield = largest_yield(), before = std::numeric_limits<double>::infinity();
  for (int update = 0; update < kMostUpdates; ++update) {
    if (yield <= allowed_yield || yield > kLess * before) break;
    last_x_ = x_;
    last_bar_ = std::exchange(bar_, x_);
    const IterationLimit limit{tolerance, std::min(kMostInUpdate, iterations_left_)};
    const IterationCount count = newton_.solve_soft(problem_, softness_, bar_, limit, x_);
    iterations_left_ -= count.iterations;
    add(count, total);
    if (!count.converged) {
      x_ = last_x_;
      bar_ = last_bar_;
      total.converged = true;
      break;
    }
    before = std::exchange(yield, largest_yield());
  }
  return total;
}

/// Forces, motions and modes of the contacts.
void MovingContacts::record(std::span<LinearContact> contacts) {
  problem_.respond(x_, motion_);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    LinearContact& c = contacts[i];
    const Vector3 yield = softness_ * (x_[i] - bar_[i]);
    const Vector3 trial = x_[i] - corrected(motion_[i] + yield);
    const double tangential = trial.tail<2>().norm();
    c.mode = trial[0] <= -tangential                        ? ContactMode::Open
             : trial[0] < tangential || !(c.friction > 0.0) ? ContactMode::Slip
                                                            : ContactMode::Stick;
    c.assumed = c.mode;
    c.force = c.mode == ContactMode::Open ? Vector3(Vector3::Zero()) : problem_.force(i, x_[i]);
    c.multiplier = c.force;
    c.bound = c.friction * c.force[0];
  }
}

OpenCloseResult MovingContacts::solve(const BlockSystem& base, const BlockVector& force,
                                      std::span<LinearContact> contacts,
                                      const OpenCloseOptions& options, BlockVector& increment) {
  problem_.set(base, force, contacts, increment, options.mending);
  start(contacts, options.predicted || bar_force_.size() != contacts.size());
  iterations_left_ = options.max_iterations;
  const double length = *std::ranges::min_element(slots_->length);
  const IterationCount count = iterate(kForces * options.force_tolerance, kYield * length);
  record(contacts);
  bar_force_.resize(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) bar_force_[i] = problem_.force(i, bar_[i]);
  OpenCloseResult result;
  result.converged = count.converged;
  result.iterations = count.iterations;
  result.solves = count.solves;
  result.factorizations = count.factorizations;
  result.residual = count.residual;
  for (std::size_t s = 0; s < increment.size(); ++s) {
    const Vector12& change = problem_.increment()[s];
    increment[s] += change;
    result.change = std::max(result.change, motion_of(change, slots_->length[s]));
  }
  for (LinearContact& c : contacts) {
    c.relative = c.offset;
    if (c.slot_a >= 0) c.relative += c.jacobian_a * increment[static_cast<std::size_t>(c.slot_a)];
    if (c.slot_b >= 0) c.relative += c.jacobian_b * increment[static_cast<std::size_t>(c.slot_b)];
  }
  if (count.factorizations > 0) result.condition = problem_.condition_estimate();
  return result;
}

}  // namespace quoin::solver
