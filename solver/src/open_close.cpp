#include "open_close.hpp"

#include <algorithm>
#include <cmath>

namespace quoin::solver {
namespace {

constexpr int kLiveIterations = 40;  // then the friction limits are frozen inside an outer loop

/// Projects the trial force on what the contact can bear.   [Alart & Curnier 1991]
void apply_law(LinearContact& c, bool live) {
  const Vector3 trial(c.multiplier[0] - c.normal_stiffness * c.relative[0],
                      c.multiplier[1] - c.shear_stiffness * c.relative[1],
                      c.multiplier[2] - c.shear_stiffness * c.relative[2]);
  c.force = trial;
  c.mode = ContactMode::Stick;
  if (c.law == ContactLaw::Bilateral) return;
  if (!(trial[0] > -c.tension)) {
    c.force.setZero();
    c.mode = ContactMode::Open;
    if (live) c.bound = 0.0;
    return;
  }
  if (c.law == ContactLaw::Stuck) return;
  if (c.law == ContactLaw::Frictionless) {
    c.force.tail<2>().setZero();
    c.mode = ContactMode::Slip;
    return;
  }
  if (live) c.bound = c.friction * std::max(trial[0], 0.0) + c.cohesion;
  const double size = trial.tail<2>().norm();
  if (size <= c.bound) return;
  c.force.tail<2>() *= c.bound / size;
  c.mode = ContactMode::Slip;
}

/// -df/dd, symmetric part: what the contact adds to the stiffness.
Matrix3 tangent(const LinearContact& c) {
  Matrix3 result = Matrix3::Zero();
  if (c.mode == ContactMode::Open) return result;
  result(0, 0) = c.normal_stiffness;
  if (c.law == ContactLaw::Frictionless) return result;
  if (c.mode == ContactMode::Stick) {
    result(1, 1) = result(2, 2) = c.shear_stiffness;
    return result;
  }
  const Eigen::Vector2d trial = c.multiplier.tail<2>() - c.shear_stiffness * c.relative.tail<2>();
  const double size = trial.norm();
  if (!(size > 0.0)) return result;
  const Eigen::Vector2d along = trial / size;
  result.bottomRightCorner<2, 2>() =
      (c.shear_stiffness * c.bound / size) *
      (Eigen::Matrix2d::Identity() - along * along.transpose());
  return result;
}

void accumulate(const LinearContact& c, BlockVector& y, std::vector<double>& scale) {
  if (c.mode == ContactMode::Open) return;
  const auto add = [&](int slot, const Matrix3x12& jacobian) {
    if (slot < 0) return;
    const auto s = static_cast<std::size_t>(slot);
    y[s].noalias() += jacobian.transpose() * c.force;
    scale[s] += c.force.norm();
  };
  add(c.slot_a, c.jacobian_a);
  add(c.slot_b, c.jacobian_b);
}

}  // namespace

void OpenClose::evaluate(const BlockSystem& base, const BlockVector& force,
                         std::span<LinearContact> contacts, const BlockVector& increment,
                         Limits limits) {
  for (std::size_t s = 0; s < increment.size(); ++s) {
    const Vector12 inner = base.diagonal[s] * increment[s];
    residual_[s] = force[s] - inner;
    const double length = slots_->length[s];
    scale_[s] = force_size(force[s], length) + force_size(inner, length);
  }
  for (LinearContact& c : contacts) {
    c.relative = c.offset;
    if (c.slot_a >= 0) {
      c.relative.noalias() += c.jacobian_a * increment[static_cast<std::size_t>(c.slot_a)];
    }
    if (c.slot_b >= 0) {
      c.relative.noalias() += c.jacobian_b * increment[static_cast<std::size_t>(c.slot_b)];
    }
    apply_law(c, limits == Limits::Live);
    accumulate(c, residual_, scale_);
  }
}

double OpenClose::relative_residual() const {
  double worst = 0.0;
  for (std::size_t s = 0; s < residual_.size(); ++s) {
    const double size = force_size(residual_[s], slots_->length[s]);
    if (!(size <= worst * scale_[s])) worst = size / std::max(scale_[s], 1e-300);
  }
  return worst;
}

double OpenClose::slope(const BlockVector& direction) const {
  double sum = 0.0;
  for (std::size_t s = 0; s < direction.size(); ++s) sum += residual_[s].dot(direction[s]);
  return sum;
}

bool OpenClose::same_tangent(std::span<const LinearContact> contacts) {
  next_tangent_.resize(contacts.size());
  for (std::size_t c = 0; c < contacts.size(); ++c) next_tangent_[c] = tangent(contacts[c]);
  const bool same = factorized_ && next_tangent_ == tangent_;
  std::swap(tangent_, next_tangent_);
  return same;
}

void OpenClose::assemble(const BlockSystem& base, std::span<const LinearContact> contacts) {
  system_.diagonal = base.diagonal;
  system_.pairs = base.pairs;
  system_.off_diagonal.assign(base.pairs.size(), Matrix12::Zero());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const LinearContact& c = contacts[i];
    if (c.mode == ContactMode::Open) continue;
    const Matrix3x12 stiff_a = tangent_[i] * c.jacobian_a;
    const Matrix3x12 stiff_b = tangent_[i] * c.jacobian_b;
    if (c.slot_a >= 0) {
      system_.diagonal[static_cast<std::size_t>(c.slot_a)].noalias() +=
          c.jacobian_a.transpose() * stiff_a;
    }
    if (c.slot_b >= 0) {
      system_.diagonal[static_cast<std::size_t>(c.slot_b)].noalias() +=
          c.jacobian_b.transpose() * stiff_b;
    }
    if (c.pair < 0) continue;
    Matrix12& off = system_.off_diagonal[static_cast<std::size_t>(c.pair)];
    if (c.slot_a < c.slot_b) {
      off.noalias() += c.jacobian_a.transpose() * stiff_b;
    } else {
      off.noalias() += c.jacobian_b.transpose() * stiff_a;
    }
  }
}

/// One Newton step with an exact search along it: the residual is minus the gradient of a convex
/// function when the limits are frozen, so its slope along the step falls and crosses zero once.
bool OpenClose::newton_step(const BlockSystem& base, const BlockVector& force,
                            std::span<LinearContact> contacts, Limits limits,
                            BlockVector& increment, OpenCloseResult& result) {
  if (!same_tangent(contacts)) {
    assemble(base, contacts);
    factorized_ = solver_.factorize(system_);
    ++result.factorizations;
    if (!factorized_) return false;
  }
  const BlockVector& right = residual_;
  solver_.solve(right, step_);
  ++result.solves;
  const double slope_start = slope(step_);
  double low = 0.0, high = 1.0;
  double at = 1.0;
  for (int search = 0; search < 30; ++search) {
    for (std::size_t s = 0; s < step_.size(); ++s) trial_[s] = increment[s] + at * step_[s];
    evaluate(base, force, contacts, trial_, limits);
    const double slope_now = slope(step_);
    if (std::abs(slope_now) <= 0.1 * std::abs(slope_start)) break;
    if (slope_now > 0.0) {
      if (at >= 1.0) break;
      low = at;
    } else {
      high = at;
    }
    at = 0.5 * (low + high);
  }
  std::swap(increment, trial_);
  return true;
}

/// Takes the forces as the new multipliers; the largest change relative to the largest force.
double OpenClose::update_multipliers(std::span<LinearContact> contacts) {
  double change = 0.0, largest = 0.0;
  for (LinearContact& c : contacts) {
    if (c.compliant) continue;
    change = std::max(change, (c.force - c.multiplier).cwiseAbs().maxCoeff());
    largest = std::max(largest, c.force.norm());
    c.multiplier = c.force;
  }
  return largest > 0.0 ? change / largest : 0.0;
}

namespace {

/// Largest violation of the contact conditions that multipliers should remove, m.
double violation(std::span<const LinearContact> contacts) {
  double worst = 0.0;
  for (const LinearContact& c : contacts) {
    if (c.compliant || c.mode == ContactMode::Open) continue;
    worst = std::max(worst, std::abs(c.relative[0]));
    if (c.mode == ContactMode::Stick) worst = std::max(worst, c.relative.tail<2>().norm());
  }
  return worst;
}

}  // namespace

OpenCloseResult OpenClose::solve(const BlockSystem& base, const BlockVector& force,
                                 std::span<LinearContact> contacts,
                                 const OpenCloseOptions& options, BlockVector& increment) {
  OpenCloseResult result;
  const std::size_t n = increment.size();
  residual_.resize(n);
  step_.resize(n);
  trial_.resize(n);
  scale_.resize(n);
  factorized_ = false;
  Limits limits = Limits::Live;
  evaluate(base, force, contacts, increment, limits);
  for (; result.iterations < options.max_iterations; ++result.iterations) {
    result.residual = relative_residual();
    if (result.residual <= options.force_tolerance) {
      const double gap = violation(contacts);
      const double change = update_multipliers(contacts);
      if (gap <= options.gap_tolerance && change <= 1e3 * options.force_tolerance) {
        if (limits == Limits::Live) {
          result.converged = true;
          break;
        }
        evaluate(base, force, contacts, increment, Limits::Live);  // new limits for the outer loop
        if (relative_residual() <= options.force_tolerance) {
          result.converged = true;
          break;
        }
      }
      evaluate(base, force, contacts, increment, limits);
      if (gap > options.gap_tolerance && relative_residual() <= options.force_tolerance) {
        // rounding keeps the residual below the tolerance: the gap is as good as it gets
        if (violation(contacts) <= 1e3 * options.gap_tolerance) {
          result.converged = true;
          break;
        }
      }
    }
    if (result.iterations == kLiveIterations) limits = Limits::Frozen;
    if (!newton_step(base, force, contacts, limits, increment, result)) break;
  }
  if (factorized_) result.condition = solver_.condition_estimate();
  return result;
}

}  // namespace quoin::solver
