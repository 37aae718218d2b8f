#include "iteration/interior_point.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "iteration/cone.hpp"

namespace quoin::solver {
namespace {

// Chosen on walls of 105 to 1040 bricks that deform, from nothing.
constexpr double kFollows = 1e-3;          // the residual from which s follows the iterates
constexpr double kInteriorLengths = 0.99;  // of the way to the cones
constexpr double kWanted = 1e-8;  // residual: with 1e-7 a wall that rests ended as a mechanism
// From so many deforming blocks on, steps go on below kWanted while each halves the residual: the
// open-close iteration would take longer (bench/README.md, Mechanisms).
constexpr int kManyInside = 300;
constexpr double kHalved = 0.5;
constexpr double kUseful = 1e-2;  // a larger one is of no use
// A wall of E 1e6 took 2.1 times the solves with 30, 1.2 with 50.
constexpr int kMostInteriorSteps = 40;
constexpr double kShort = 0.2, kCentre = 0.8;  // a step so short is one towards the centre instead
constexpr double kLong = 0.5;  // after a step that was, the change of the slip is in the next one
constexpr double kHeld = 1e8;  // what a held point opposes, by what its blocks do
constexpr double kShortest = 1e-6;  // a step that goes nowhere

constexpr Admissible kCone{};

}  // namespace

bool InteriorPoint::suits(const LinearContact& c) {
  return ConeProblem::follows_coulomb(c) || c.law == ContactLaw::Bilateral ||
         (c.law == ContactLaw::Stuck && c.bonded && !c.compliant);
}

bool InteriorPoint::held(std::size_t contact) const {
  return problem_.admissible()[contact].shear == Admissible::Shear::All;
}

/// By which of x and y is well inside.
ContactMode InteriorPoint::mode(std::size_t contact) const {
  if (held(contact)) return ContactMode::Stick;
  const Vector3 &x = x_[contact], y = corrected(kCone, u_[contact]);
  if (y.norm() < x[0] - x.tail<2>().norm()) return ContactMode::Stick;
  return x.norm() < y[0] - y.tail<2>().norm() ? ContactMode::Open : ContactMode::Slip;
}

/// u + s n, which y comes to.
Vector3 InteriorPoint::pressed(std::size_t contact) const {
  return u_[contact] + slip_[contact] * Vector3::UnitX();
}

/// From no forces: forces and motions well inside their cones: by the largest motion without
/// forces.
void InteriorPoint::begin() {
  const std::size_t n = x_.size();
  for (auto* memory : {&y_, &u_, &right_, &motion_}) memory->resize(n);
  slip_.assign(n, 0.0);
  scalings_.resize(n);
  tangents_.resize(n);
  dx_ = dy_ = x_;
  problem_.respond(x_, u_);
  double inside = 0.0;
  for (const Vector3& u : u_) inside = std::max(inside, u.norm());
  for (std::size_t i = 0; i < n; ++i) {
    if (held(i)) {
      x_[i] = y_[i] = Vector3::Zero();
      continue;
    }
    x_[i] = inside * Vector3::UnitX();
    y_[i] = project_on(kCone, u_[i]) + inside * Vector3::UnitX();
  }
}

InteriorPoint::Residuals InteriorPoint::residuals() const {
  Residuals worst{0.0, 0.0};
  double most = 1e-300;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    most = std::max(most, x_[i].norm());
    if (held(i)) {
      const double apart = u_[i].norm();
      worst = {std::max(worst.frozen, apart), std::max(worst.real, apart)};
      continue;
    }
    const double frozen = (x_[i] - project_on(kCone, x_[i] - pressed(i))).norm();
    const double real = (x_[i] - project_on(kCone, x_[i] - corrected(kCone, u_[i]))).norm();
    if (!(frozen <= worst.frozen)) worst.frozen = frozen;  // NaN stays
    if (!(real <= worst.real)) worst.real = real;
  }
  return {worst.frozen / most, worst.real / most};
}

/// Mean of x·y after a step.
double InteriorPoint::duality(double step) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < x_.size(); ++i)
    sum += (x_[i] + step * dx_[i]).dot(y_[i] + step * dy_[i]);
  return sum / static_cast<double>(x_.size());
}

void InteriorPoint::set_scalings() {
  for (std::size_t i = 0; i < x_.size(); ++i) {
    if (held(i)) {
      tangents_[i] = kHeld * Matrix3::Identity();
      continue;
    }
    const ConeScaling scaling = cone_scaling(x_[i], y_[i]);
    Scaling& w = scalings_[i];
    w.scale = matrix(scaling, 1.0);
    w.unscale = matrix(scaling, -1.0);
    w.lambda = w.scale * y_[i];
    tangents_[i] = w.scale * w.scale;
  }
}

/// Whether the change of s belongs to the next directions: its slope by the motion is
/// t = u_t / |u_t|, and W² (1 + n tᵀ) the contact's tangent.
void InteriorPoint::follow_slip(bool wanted) {
  coupled_.clear();
  if (!wanted) return;
  coupled_.assign(x_.size(), Vector3::Zero());
  tangents_of_slip_ = tangents_;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const double slip = u_[i].tail<2>().norm();
    if (held(i) || !(slip > 0.0)) continue;
    coupled_[i].tail<2>() = u_[i].tail<2>() / slip;
    tangents_of_slip_[i] += tangents_[i].col(0) * coupled_[i].transpose();
  }
}

/// dx_, dy_ and how far they go. dx = r - W² dy, r of the complementarity alone; `mean`: what the
/// corrector wants x·y to be.
double InteriorPoint::direction(Part part, double mean) {
  for (std::size_t i = 0; i < x_.size(); ++i) {
    if (held(i)) {
      dy_[i] = u_[i];
      dx_[i].setZero();
      right_[i] = -tangents_[i] * u_[i];
      continue;
    }
    Vector3 r = -x_[i];
    if (part != Part::Predictor) {
      const Scaling& w = scalings_[i];
      Vector3 left = -product(w.lambda, w.lambda);
      if (part == Part::Corrector) left -= product(w.unscale * dx_[i], w.scale * dy_[i]);
      left[0] += mean;
      r = w.scale * quotient(w.lambda, left);
    }
    dx_[i] = r;
    dy_[i] = pressed(i) - y_[i];
    right_[i] = r - tangents_[i] * dy_[i];
  }
  problem_.solve(right_, motion_);
  double step = 1.0;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    dy_[i] += motion_[i];  // not by W⁻¹, which rounds
    if (!coupled_.empty()) dy_[i][0] += coupled_[i].dot(motion_[i]);
    dx_[i] -= tangents_[i] * dy_[i];
    if (held(i)) {
      dy_[i].setZero();
      continue;
    }
    step = std::min({step, longest(x_[i], dx_[i]), longest(y_[i], dy_[i])});
  }
  return step;
}

IterationCount InteriorPoint::iterate(int most) {
  IterationCount count;
  begin();
  bool follows = false;
  const bool exact = !slots_->rigid() && slots_->count() >= kManyInside;
  double last = 1.0;                                        // step
  double before = std::numeric_limits<double>::infinity();  // residual
  for (;;) {
    problem_.respond(x_, u_);
    const Residuals residual = residuals();
    if (count.iterations == 0 || residual.real < count.residual) {
      count.residual = residual.real;
      best_ = x_;
    }
    count.converged = count.residual <= kWanted;
    const bool halves = residual.real < kHalved * std::exchange(before, residual.real);
    if ((count.converged && !(exact && halves)) || count.iterations >= most) break;
    follows = follows || residual.frozen <= kFollows;
    for (std::size_t i = 0; follows && i < x_.size(); ++i) slip_[i] = u_[i].tail<2>().norm();
    ++count.iterations;
    ++count.factorizations;
    set_scalings();
    follow_slip(follows && last > kLong);
    const bool couples = !coupled_.empty();
    if (!problem_.factorize(couples ? tangents_of_slip_ : tangents_,
                            couples ? Tangents::General : Tangents::Symmetric))
      break;
    count.solves += 2;
    const double mean = duality(0.0);
    const double affine = direction(Part::Predictor, 0.0);
    const double left = std::clamp(duality(affine) / mean, 0.0, 1.0);
    double way = direction(Part::Corrector, left * left * left * mean);
    if (way < kShort) way = direction(Part::Centre, kCentre * mean);
    const double step = std::min(1.0, kInteriorLengths * way);
    last = step;
    if (!(step > kShortest)) break;
    for (std::size_t i = 0; i < x_.size(); ++i) {
      x_[i] += step * dx_[i];
      y_[i] += step * dy_[i];
    }
  }
  std::swap(x_, best_);
  return count;
}

OpenCloseResult InteriorPoint::solve(const BlockSystem& base, const BlockVector& force,
                                     std::span<LinearContact> contacts, int most,
                                     BlockVector& increment) {
  problem_.set(base, force, contacts, increment);
  x_.assign(contacts.size(), Vector3::Zero());
  const IterationCount count = iterate(std::min(most, kMostInteriorSteps));
  OpenCloseResult result{count, count.residual <= kUseful, count.residual};
  if (!result.converged) return result;
  problem_.respond(x_, u_);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    contacts[i].force = contacts[i].multiplier = problem_.force(i, x_[i]);
    contacts[i].relative = problem_.motion(i, u_[i]);
    contacts[i].assumed = contacts[i].mode = mode(i);
  }
  result.change = largest_motion(*slots_, problem_.increment());
  for (std::size_t s = 0; s < increment.size(); ++s) increment[s] += problem_.increment()[s];
  return result;
}

}  // namespace quoin::solver
