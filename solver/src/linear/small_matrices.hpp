#pragma once
/// Of a block's own matrices, compiled once: each size that Eigen decomposes costs seconds.

#include <Eigen/Core>

namespace quoin::solver {

/// Inverse of a symmetric matrix of at most 12 rows. False where it is not positive definite: rows
/// whose pivots are not positive are zero then.
bool invert_symmetric(const Eigen::Ref<const Eigen::MatrixXd>& matrix,
                      Eigen::Ref<Eigen::MatrixXd> inverse);

/// Of a symmetric matrix, ascending.
Eigen::Vector3d eigenvalues(const Eigen::Matrix3d& matrix);

}  // namespace quoin::solver
