#include "moving/interior_point.hpp"

#include <algorithm>
#include <cmath>

#include "moving/cone.hpp"

namespace quoin::solver {
namespace {

// Chosen on single steps of piles and shaken walls.
constexpr double kInside = 1e-3;           // of the largest force: how far inside it starts
constexpr double kTangentSoftness = 1e-3;  // in the matrix alone
constexpr double kSmoothing = 0.01;        // of mu / x_n: |u_t| near zero
constexpr double kFirstShare = 0.9;  // of the way to the cone's boundary, in the first two steps
constexpr double kShare = 0.99;      // and after

}  // namespace

/// From inside: x and y moved along the axis of the cone.
void InteriorPoint::start(ConeProblem& problem, const Softness& softness, std::vector<Vector3>& x) {
  const std::size_t n = x.size();
  for (std::vector<Vector3>* list : {&y_, &u_, &right_, &motion_, &step_x_, &step_y_, &target_}) {
    list->assign(n, Vector3::Zero());
  }
  contacts_.resize(n);
  tangents_.resize(n);
  slopes_.resize(n);
  const Vector3 inside(kInside * largest(x), 0.0, 0.0);
  for (Vector3& force : x) force = project_on_cone(force) + inside;
  respond_softly(problem, softness, x, u_);
  for (std::size_t i = 0; i < n; ++i) y_[i] = project_on_cone(corrected(u_[i])) + inside;
  complementarity_ = complementarity(x, 0.0);
}

/// The tangents of the contacts and the matrix they make.
bool InteriorPoint::linearise(ConeProblem& problem, const Softness& softness,
                              std::span<const Vector3> x) {
  const double share = softness.share + kTangentSoftness;
  for (std::size_t i = 0; i < x.size(); ++i) {
    Contact& c = contacts_[i];
    const ConeScaling scaling = cone_scaling(x[i], y_[i]);
    const double smoothing = kSmoothing * complementarity_ / x[i][0];
    slopes_[i] = correction_slope(u_[i], smoothing);
    c.scale = scaling.scale;
    c.inverse = scaling.inverse;
    c.product = scaling.scale * y_[i];
    c.rest = y_[i] - corrected(u_[i], smoothing);
    const Matrix3 stiffness = scaling.squared * slopes_[i];
    const Matrix3 yielding = (Matrix3::Identity() + share * stiffness).inverse();
    c.force_per_rest = yielding * scaling.scale;
    c.force_per_motion = yielding * stiffness;
    tangents_[i] = c.force_per_motion;
  }
  return problem.factorize(tangents_);
}

/// What λ ∘ (W dy + W⁻¹ dx) is to be, by λ: towards `centring` times the mean complementarity.
void InteriorPoint::centre(double centring, bool second_order) {
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const Contact& c = contacts_[i];
    Vector3 wanted = -jordan_product(c.product, c.product);
    wanted[0] += centring * complementarity_;
    if (second_order) wanted -= jordan_product(c.scale * step_y_[i], c.inverse * step_x_[i]);
    target_[i] = jordan_quotient(wanted, c.product);
  }
}

/// step_x_, step_y_ and `motion_` for the target.
void InteriorPoint::find_step(ConeProblem& problem, const Softness& softness,
                              std::span<const Vector3> x) {
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Contact& c = contacts_[i];
    right_[i] = c.force_per_rest * (target_[i] + c.scale * c.rest);
  }
  problem.solve(right_, motion_);
  const double share = softness.share + kTangentSoftness;
  for (std::size_t i = 0; i < x.size(); ++i) {
    step_x_[i] = right_[i] - contacts_[i].force_per_motion * motion_[i];
    step_y_[i] = slopes_[i] * (motion_[i] + share * step_x_[i]) - contacts_[i].rest;
  }
}

double InteriorPoint::share_inside(std::span<const Vector3> x) const {
  double share = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < x.size(); ++i) {
    share = std::min({share, share_in_cone(x[i], step_x_[i]), share_in_cone(y_[i], step_y_[i])});
  }
  return share;
}

/// Mean of (x + share dx)·(y + share dy).
double InteriorPoint::complementarity(std::span<const Vector3> x, double share) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sum += (x[i] + share * step_x_[i]).dot(y_[i] + share * step_y_[i]);
  }
  return sum / static_cast<double>(std::max<std::size_t>(x.size(), 1));
}

IterationCount InteriorPoint::solve(ConeProblem& problem, const Softness& softness,
                                    const IterationLimit& limit, std::vector<Vector3>& x) {
  IterationCount count;
  start(problem, softness, x);
  for (;;) {
    count.residual = relative_residual(x, u_);
    count.converged = count.residual <= limit.residual;
    if (count.converged || count.iterations == limit.iterations) return count;
    ++count.iterations;
    ++count.factorizations;
    if (!linearise(problem, softness, x)) return count;
    centre(0.0, false);
    find_step(problem, softness, x);
    const double part = count.iterations <= 2 ? kFirstShare : kShare;
    const double predicted = std::min(1.0, part * share_inside(x));
    double centring = 0.0;
    if (predicted < 1.0) {
      const double left = complementarity(x, predicted) / complementarity_;
      centring = std::clamp(std::max(std::pow(left, 3), std::pow(1.0 - predicted, 3)), 0.0, 1.0);
    }
    centre(centring, true);
    find_step(problem, softness, x);
    count.solves += 2;
    const double share = std::min(1.0, part * share_inside(x));
    if (!(share > 0.0)) return count;
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] += share * step_x_[i];
      y_[i] += share * step_y_[i];
      u_[i] += share * (motion_[i] + softness.share * step_x_[i]);
    }
    complementarity_ = complementarity(x, 0.0);
  }
}

}  // namespace quoin::solver
