#include "iteration/proximal_newton.hpp"

#include <algorithm>
#include <cmath>

namespace quoin::solver {
namespace {

// Chosen on single steps of piles, shaken walls, towers, arches and slopes, and on runs of them.
constexpr double kLeastEps = 1e-3, kMostEps = 0.1;  // of eps for hard contacts, and
constexpr double kOfResidual = 0.1;    // what it is of the relative residual between them
constexpr int kProximalPatience = 12;  // steps that do not halve the residual, and
constexpr int kPatienceNear = 3;       // once it is below
constexpr double kNearSolution = 1e-4;
constexpr double kStart = 3e-4;   // e for contacts that yield, of the largest force, and at most
constexpr double kOfStart = 0.1;  // this of the residual; it falls with each step
constexpr double kTangentSoftness = 1e-4;  // in the matrix alone
// What is given up soon: residuals after a step, and after so many, that hardly any solution had of
// the velocities of a vault, a wall and a pile.
constexpr double kHopeless = 0.1, kHopelessLate = 3e-3;
constexpr int kLate = 6;

/// E: I, and by Coulomb's law n u_tᵀ/|u_t|.
Matrix3 correction_slope(const Admissible& forces, const Vector3& u) {
  Matrix3 result = Matrix3::Identity();
  if (forces.shear != Admissible::Shear::Cone) return result;
  const double size = u.tail<2>().norm();
  if (size > 0.0) result.block<1, 2>(0, 1) = u.tail<2>().transpose() / size;
  return result;
}

/// Largest |x|.
double largest(std::span<const Vector3> x) {
  double most = 0.0;
  for (const Vector3& force : x) most = std::max(most, force.squaredNorm());
  return std::sqrt(most);
}

bool is_hopeless(const IterationCount& count) {
  if (count.iterations == 0) return false;
  return count.residual > (count.iterations < kLate ? kHopeless : kHopelessLate);
}

}  // namespace

double relative_residual(std::span<const Admissible> admissible, std::span<const Vector3> x,
                         std::span<const Vector3> u) {
  double worst = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vector3 trial = x[i] - corrected(admissible[i], u[i]);
    const double left = (x[i] - project_on(admissible[i], trial)).squaredNorm();
    if (!(left <= worst)) worst = left;  // NaN stays
  }
  return worst == 0.0 ? 0.0 : std::sqrt(worst) / std::max(largest(x), 1e-300);
}

/// One whole step of x by the motions u_.
bool ProximalNewton::find_step(ConeProblem& problem, double share, double smoothing,
                               std::span<const Vector3> x) {
  tangents_.resize(x.size());
  right_.resize(x.size());
  motion_.resize(x.size());
  problem.threads().each(x.size(), [&](std::size_t i) {
    const Admissible& forces = problem.admissible()[i];
    const Vector3 trial = x[i] - corrected(forces, u_[i]);
    const auto [value, derivative] = project_smoothly(forces, trial, smoothing);
    const Matrix3 slope = derivative * correction_slope(forces, u_[i]);
    const Matrix3 matrix =
        (1.0 + kTangentSoftness) * Matrix3::Identity() - derivative + share * slope;
    const Matrix3 inverse = matrix.inverse();
    tangents_[i] = inverse * slope;
    right_[i] = inverse * (value - x[i]);
  });
  if (!problem.factorize(tangents_, Tangents::General)) return false;
  problem.solve(right_, motion_);
  return true;
}

void ProximalNewton::take_step(std::vector<Vector3>& x) const {
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += right_[i] - tangents_[i] * motion_[i];
}

IterationCount ProximalNewton::solve_hard(ConeProblem& problem, const IterationLimit& limit,
                                          std::vector<Vector3>& x) {
  IterationCount count;
  u_.resize(x.size());
  problem.respond(x, u_);
  count.residual = relative_residual(problem.admissible(), x, u_);
  best_ = x;
  double residual = count.residual, halved = residual;
  int last = 0;  // the step that halved it
  const auto goes_on = [&] {
    const int patience = count.residual < kNearSolution ? kPatienceNear : kProximalPatience;
    return count.iterations < std::min(limit.iterations, last + patience);
  };
  while (!(count.residual <= limit.residual) && goes_on()) {
    ++count.iterations;
    ++count.factorizations;
    if (!find_step(problem, std::clamp(kOfResidual * residual, kLeastEps, kMostEps), 0.0, x)) break;
    take_step(x);
    ++count.solves;
    problem.respond(x, u_);
    residual = relative_residual(problem.admissible(), x, u_);
    if (!(residual < count.residual)) continue;
    count.residual = residual;
    best_ = x;
    if (residual > 0.5 * halved) continue;
    halved = residual;
    last = count.iterations;
  }
  count.converged = count.residual <= limit.residual;
  std::swap(x, best_);
  return count;
}

IterationCount ProximalNewton::solve_soft(ConeProblem& problem, double softness,
                                          std::span<const Vector3> bar, const IterationLimit& limit,
                                          std::vector<Vector3>& x) {
  IterationCount count;
  u_.resize(x.size());
  const double size = largest(x);
  double smoothing = 0.0;
  for (;;) {
    problem.respond(x, u_);
    for (std::size_t i = 0; i < x.size(); ++i) u_[i] += softness * (x[i] - bar[i]);
    count.residual = relative_residual(problem.admissible(), x, u_);
    count.converged = count.residual <= limit.residual;
    if (count.iterations == 0) smoothing = std::min(kStart, kOfStart * count.residual);
    if (count.converged || count.iterations >= limit.iterations) return count;
    if (limit.soon && is_hopeless(count)) return count;
    ++count.iterations;
    ++count.factorizations;
    if (!find_step(problem, softness, smoothing * size, x)) return count;
    take_step(x);
    ++count.solves;
    smoothing = std::min(0.2 * smoothing, std::pow(smoothing, 1.5));
  }
}

}  // namespace quoin::solver
