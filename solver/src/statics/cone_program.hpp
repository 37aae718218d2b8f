#pragma once
/// Homogeneous self-dual interior point method for forces in second-order cones.
///
///   min c'x - lambda,   A x + lambda a = b,   s = h - G x in K,   0 <= lambda <= 1
///
/// x: forces of contacts (normal, two tangents), y: multipliers of the balance of blocks, which are
/// their velocities. Either admissible forces come out, or y with A'y + G'z = 0 and b'y + h'z < 0:
/// a mechanism. Nesterov–Todd directions with Mehrotra's corrector [Vandenberghe 2010], one
/// factorization an iteration; a proximal term stays in the solved system, so that forces which
/// balance by themselves and blocks that nothing holds need no special care [Friedlander & Orban
/// 2012]. Lengths and forces are scaled by the caller: loads and blocks of size 1.

#include <Eigen/Core>
#include <limits>
#include <span>

#include "linear/multifrontal.hpp"

namespace quoin::solver {

inline constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// Of its components, without their signs.
inline double largest_entry(const Eigen::VectorXd& v) {
  return v.size() > 0 ? v.lpNorm<Eigen::Infinity>() : 0.0;
}

using Matrix6x3 = Eigen::Matrix<double, 6, 3>;

struct ConeContact {
  int a = -1, b = -1;                   ///< slots; -1: a block that does not move
  Matrix6x3 map_a = Matrix6x3::Zero();  ///< from the force to the load on a
  Matrix6x3 map_b = Matrix6x3::Zero();
  double friction = 0.0, cohesion = 0.0, tension = 0.0;
  double cost = 0.0;  ///< c of the normal force: its gap
  bool held = false;  ///< any force

  /// To loads, 6 a slot: what it does with this force.
  void add_load(const Vector3& force, Eigen::VectorXd& loads) const {
    if (a >= 0) loads.segment<6>(6 * a) += map_a * force;
    if (b >= 0) loads.segment<6>(6 * b) += map_b * force;
  }
  /// By velocities of the slots.
  Vector3 motion(const Eigen::VectorXd& y) const {
    Vector3 sum = Vector3::Zero();
    if (a >= 0) sum += map_a.transpose().lazyProduct(y.segment<6>(6 * a));
    if (b >= 0) sum += map_b.transpose().lazyProduct(y.segment<6>(6 * b));
    return sum;
  }
  bool has_cone() const { return !held && (friction > 0.0 || cohesion > 0.0); }
  /// The cut-off decides before the cone's apex.
  bool has_cut_off() const { return !held && !(friction * tension >= cohesion && friction > 0.0); }
};

struct ConeProgram {
  int slots = 0;
  std::vector<ConeContact> contacts{};
  Eigen::VectorXd load{};       ///< -b, 6 a slot
  Eigen::VectorXd live{};       ///< a; empty: no factor
  bool mechanism_only = false;  ///< it ends where forces seem to exist
};

struct ConeSolution {
  Eigen::VectorXd forces{};      ///< x, 3 a contact
  Eigen::VectorXd velocities{};  ///< y, 6 a slot
  double factor = 0.0;           ///< lambda
  int factorizations = 0;
};

/// The best iterate: the caller judges what it proves.
ConeSolution solve(const ConeProgram& program, int most_iterations);

/// The balance of rigid blocks: A of a program, and S = A W A' + proximal, W a matrix a contact.
class BalanceMatrix {
 public:
  /// `program` must outlive this object.
  explicit BalanceMatrix(const ConeProgram& program);

  Eigen::VectorXd loads(const Eigen::VectorXd& forces) const;  ///< A x, 6 a slot
  Eigen::VectorXd motions(const Eigen::VectorXd& y) const;     ///< A'y, 3 a contact

  /// False where S is singular to working accuracy. `weights`: by contact.
  bool factorize(std::span<const Matrix3> weights, double proximal);
  Eigen::VectorXd solve(const Eigen::VectorXd& right);  ///< S⁻¹, after factorize()

 private:
  const ConeProgram& program_;
  Slots slots_;
  Multifrontal elimination_;
  BlockSystem system_;
  std::vector<int> pair_of_contact_;
};

/// `y` (6 a slot, the largest 1), moved as little as makes contacts that stick or slide to within
/// `near` do so exactly: v = 0 where |v| < near, v_n = mu |v_t| where these differ by less. By
/// Newton's method; the others are left as they are, so the result may be incompatible.
Eigen::VectorXd compatible_motion(const ConeProgram& program, Eigen::VectorXd y, double near);

}  // namespace quoin::solver
