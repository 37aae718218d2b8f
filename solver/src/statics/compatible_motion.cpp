#include "statics/compatible_motion.hpp"

#include "statics/balance_matrix.hpp"

namespace quoin::solver {

using Eigen::VectorXd;

namespace {

constexpr int kMotionRounds = 4;           // Newton: directions of slip change little
constexpr int kMotionRefinements = 4;      // of a solve with the proximal term
constexpr double kMotionProximal = 1e-10;  // of motions of size 1: redundant conditions
constexpr double kNoSlip = 1e-14;          // of a direction

/// What a contact's motion has to lose: `weight` projects on it.
struct Excess {
  Matrix3 weight = Matrix3::Zero();
  Vector3 motion = Vector3::Zero();
};

Excess excess(const ConeContact& contact, const Vector3& v, double near) {
  if (contact.held || v.norm() < near) return {Matrix3::Identity(), v};
  const double slip = contact.has_cone() ? v.tail<2>().norm() : 0.0;
  if (!(v[0] - contact.friction * slip < near)) return {};
  Vector3 along = Vector3::UnitX();
  if (slip > kNoSlip) along.tail<2>() = -contact.friction / slip * v.tail<2>();
  along.normalize();
  return {along * along.transpose(), along * along.dot(v)};
}

}  // namespace

VectorXd compatible_motion(const ConeProgram& program, VectorXd y, double near) {
  BalanceMatrix matrix(program);
  std::vector<Matrix3> weights(program.contacts.size());
  for (int round = 0; round < kMotionRounds; ++round) {
    const VectorXd motions = matrix.motions(y);
    VectorXd left = VectorXd::Zero(motions.size());
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const auto at = 3 * static_cast<Eigen::Index>(i);
      const Excess over = excess(program.contacts[i], motions.segment<3>(at), near);
      weights[i] = over.weight;
      left.segment<3>(at) = over.motion;
    }
    if (!matrix.factorize(weights, kMotionProximal)) break;
    for (int i = 0; i < kMotionRefinements; ++i) {
      const VectorXd change = matrix.solve(matrix.loads(left));
      if (!change.allFinite()) return y;
      y -= change;
      const VectorXd moved = matrix.motions(change);
      for (std::size_t k = 0; k < weights.size(); ++k) {
        const auto at = 3 * static_cast<Eigen::Index>(k);
        left.segment<3>(at) -= weights[k] * moved.segment<3>(at);
      }
    }
  }
  return y;
}

}  // namespace quoin::solver
