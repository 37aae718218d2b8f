#include "moving/smoothed_newton.hpp"

#include <algorithm>
#include <cmath>

#include "moving/cone.hpp"

namespace quoin::solver {
namespace {

// Chosen on single steps of piles and shaken walls.
constexpr double kStart = 1e-4;            // e at the start, of the largest force
constexpr double kTangentSoftness = 1e-4;  // in the matrix alone
constexpr double kCorrectionShare = 0.1;   // of e: smooths |u_t|
constexpr int kHalvings = 8;

/// x - P_e(x - y)
Vector3 rest_of(const Vector3& x, const Vector3& u, double smoothing) {
  return x - project_smoothly(x - corrected(u, kCorrectionShare * smoothing), smoothing).value;
}

double norm_of_rest(std::span<const Vector3> x, std::span<const Vector3> u, double smoothing) {
  double sum = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) sum += rest_of(x[i], u[i], smoothing).squaredNorm();
  return std::sqrt(sum);
}

}  // namespace

/// (I - D) dx + D dy = P_e(x - y) - x with dy = E (A dD + eps dx).
bool SmoothedNewton::find_step(ConeProblem& problem, const Softness& softness,
                               std::span<const Vector3> x, double smoothing) {
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double k = kCorrectionShare * smoothing;
    const SmoothProjection projection = project_smoothly(x[i] - corrected(u_[i], k), smoothing);
    const Matrix3 slope = projection.derivative * correction_slope(u_[i], k);
    const Matrix3 matrix = (1.0 + kTangentSoftness) * Matrix3::Identity() - projection.derivative +
                           softness.share * slope;
    const Matrix3 inverse = matrix.inverse();
    tangents_[i] = inverse * slope;
    right_[i] = inverse * (projection.value - x[i]);
  }
  if (!problem.factorize(tangents_)) return false;
  problem.solve(right_, motion_);
  for (std::size_t i = 0; i < x.size(); ++i) step_[i] = right_[i] - tangents_[i] * motion_[i];
  return true;
}

/// Halves the step until the smoothed map comes nearer to zero; the share that was taken.
double SmoothedNewton::search(const Softness& softness, std::vector<Vector3>& x, double smoothing) {
  const double before = norm_of_rest(x, u_, smoothing);
  double share = 1.0;
  for (int halving = 0;; ++halving, share *= 0.5) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      trial_x_[i] = x[i] + share * step_[i];
      trial_u_[i] = u_[i] + share * (motion_[i] + softness.share * step_[i]);
    }
    if (norm_of_rest(trial_x_, trial_u_, smoothing) < before || halving == kHalvings) break;
  }
  std::swap(x, trial_x_);
  std::swap(u_, trial_u_);
  return share;
}

IterationCount SmoothedNewton::solve(ConeProblem& problem, const Softness& softness,
                                     const IterationLimit& limit, std::vector<Vector3>& x) {
  for (std::vector<Vector3>* list : {&u_, &right_, &motion_, &step_, &trial_x_, &trial_u_}) {
    list->resize(x.size());
  }
  tangents_.resize(x.size());
  IterationCount count;
  respond_softly(problem, softness, x, u_);
  const double size = largest(x);
  double smoothing = kStart * size;
  for (;;) {
    count.residual = relative_residual(x, u_);
    count.converged = count.residual <= limit.residual;
    if (count.converged || count.iterations == limit.iterations) return count;
    ++count.iterations;
    ++count.factorizations;
    if (!find_step(problem, softness, x, smoothing)) return count;
    ++count.solves;
    const double share = search(softness, x, smoothing);
    if (share == 1.0) {
      smoothing = std::min(0.2 * smoothing, std::pow(smoothing / size, 1.5) * size);
    } else if (share > 0.2) {
      smoothing *= 0.5;
    }
  }
}

}  // namespace quoin::solver
