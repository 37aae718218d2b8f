#pragma once
/// The balance of rigid blocks: maps of a cone program, and its weighted normal equations.

#include <span>

#include "statics/cone_program.hpp"

namespace quoin::solver {

/// A of a program, and S = A W A' + proximal, W a matrix a contact.
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

}  // namespace quoin::solver
