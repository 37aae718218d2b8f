#include "moving/soft_contacts.hpp"

#include <algorithm>
#include <cmath>

#include "moving/cone.hpp"

namespace quoin::solver {

Vector3 corrected(const Vector3& u, double smoothing) {
  Vector3 y = u;
  y[0] += std::hypot(u.tail<2>().norm(), smoothing) - smoothing;
  return y;
}

Matrix3 correction_slope(const Vector3& u, double smoothing) {
  Matrix3 result = Matrix3::Identity();
  const double size = std::hypot(u.tail<2>().norm(), smoothing);
  if (size > 0.0) result.block<1, 2>(0, 1) = u.tail<2>().transpose() / size;
  return result;
}

double relative_residual(std::span<const Vector3> x, std::span<const Vector3> u) {
  double worst = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double left = (x[i] - project_on_cone(x[i] - corrected(u[i]))).norm();
    if (!(left <= worst)) worst = left;  // NaN stays
  }
  return worst == 0.0 ? 0.0 : worst / std::max(largest(x), 1e-300);
}

double largest(std::span<const Vector3> x) {
  double most = 0.0;
  for (const Vector3& force : x) most = std::max(most, force.norm());
  return most;
}

void respond_softly(ConeProblem& problem, const Softness& softness, std::span<const Vector3> x,
                    std::span<Vector3> u) {
  problem.respond(x, u);
  for (std::size_t i = 0; i < x.size(); ++i) u[i] += softness.share * (x[i] - softness.bar[i]);
}

}  // namespace quoin::solver
