#include "moving/moving_contacts.hpp"

#include <algorithm>
#include <limits>

#include "moving/cone.hpp"

namespace quoin::solver {
namespace {

// Chosen on single steps of piles and shaken walls.
constexpr int kSweeps = 10;
constexpr double kSoftness = 0.03;
constexpr int kMostUpdates = 3;   // of the forces about which contacts yield, while they yield by
constexpr double kYield = 1e-6;   // more than this of the smallest block, and while each
constexpr double kStalled = 0.5;  // leaves no more than this of it
constexpr int kMostSteps = 50;    // of one iteration, a bound: the shipped problems stay well below
constexpr double kInteriorResidual = 1e-3;  // from here Newton's method finds the rest

void add(const IterationCount& part, IterationCount& total) {
  total.converged = part.converged;
  total.residual = part.residual;
  total.iterations += part.iterations;
  total.solves += part.solves;
  total.factorizations += part.factorizations;
}

}  // namespace

/// `first`: the first linearisation of a step, which sweeps; the others yield about the same
/// forces.
void MovingContacts::start(std::span<const LinearContact> contacts, bool first) {
  x_.resize(contacts.size());
  bar_.resize(contacts.size());
  motion_.resize(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    x_[i] = project_on_cone(problem_.cone_force(i, contacts[i].multiplier));
  }
  if (first || bar_force_.size() != contacts.size()) {
    problem_.respond(x_, motion_);
    for (int sweep = 0; sweep < kSweeps; ++sweep) problem_.sweep(x_);
    bar_force_.resize(contacts.size());
    for (std::size_t i = 0; i < contacts.size(); ++i) bar_force_[i] = problem_.force(i, x_[i]);
  }
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    bar_[i] = problem_.cone_force(i, bar_force_[i]);
  }
}

IterationCount MovingContacts::solve_soft(double tolerance) {
  const Softness softness{kSoftness, bar_};
  IterationCount total;
  respond_softly(problem_, softness, x_, motion_);
  total.residual = relative_residual(x_, motion_);
  total.converged = total.residual <= tolerance;
  if (total.converged) return total;
  const auto iterate_by = [&](auto& iteration, double residual) {
    const int most = std::max(0, std::min(kMostSteps, iterations_left_));
    const IterationCount count = iteration.solve(problem_, softness, {residual, most}, x_);
    iterations_left_ -= count.iterations;
    add(count, total);
  };
  if (total.residual > kInteriorResidual) iterate_by(interior_point_, kInteriorResidual);
  iterate_by(smoothed_newton_, tolerance);
  return total;
}

/// How far contacts yield, m.
double MovingContacts::largest_yield() const {
  double most = 0.0;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    most = std::max(most, problem_.motion(i, kSoftness * (x_[i] - bar_[i])).norm());
  }
  return most;
}

/// Contacts that yield too far do so about the forces that they have come to, and again.
IterationCount MovingContacts::iterate(double tolerance, double allowed_yield) {
  IterationCount total = solve_soft(tolerance);
  double yield = largest_yield();
  for (int update = 0; total.converged && yield > allowed_yield && update < kMostUpdates;
       ++update) {
    const double before = yield;
    last_x_ = x_;
    last_bar_ = bar_;
    bar_ = x_;
    const IterationCount count = solve_soft(tolerance);
    yield = largest_yield();
    const bool better = count.converged && yield < before;
    add(count, total);
    if (!better) {
      x_ = last_x_;
      bar_ = last_bar_;
      total.converged = true;
    }
    if (!better || yield > kStalled * before) break;
  }
  return total;
}

/// Forces, motions and modes of the contacts.
void MovingContacts::record(std::span<LinearContact> contacts) {
  const Softness softness{kSoftness, bar_};
  respond_softly(problem_, softness, x_, motion_);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    LinearContact& c = contacts[i];
    const Vector3 trial = x_[i] - corrected(motion_[i]);
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
  problem_.set(base, force, contacts, increment);
  start(contacts, options.predicted);
  iterations_left_ = options.max_iterations;
  const double length = *std::ranges::min_element(slots_->length);
  const double allowed_yield =
      options.predicted ? kYield * length : std::numeric_limits<double>::infinity();
  const IterationCount count = iterate(options.force_tolerance, allowed_yield);
  for (std::size_t i = 0; i < contacts.size(); ++i) bar_force_[i] = problem_.force(i, bar_[i]);
  record(contacts);
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
