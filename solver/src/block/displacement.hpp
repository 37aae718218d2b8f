#pragma once
/// The 12 unknowns of a block and how they move its points.
///
/// One increment is D = (u | theta | e): translation of the centroid (3, world, m), Cayley rotation
/// vector (3, turning frame, rad) and strain increment (6, turning frame, xx yy zz xy yz zx, shear
/// as gamma). The end of a step is exact for any size of increment:
///   c' = c + u,   R' = R cay(theta),   eps' = eps + e,   x = c + R (I + eps) X.
/// A material point then moves by exactly
///   dx = u + r × (y + y')/2 + (I + [r]/2) R E(e) X,   r = R theta,   y = x - c,
/// which is linear in (u, theta, e) once the mean arm (y + y')/2 is known: the discrete counterpart
/// of T(x) D of [Beyabanaki 2009], equation (2), that loses neither energy nor angular momentum.

#include <quoin/solver/state.hpp>

#include "base/matrix_values.hpp"

namespace quoin::solver {

using Vector12 = Eigen::Matrix<double, 12, 1>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;
using Matrix3x6 = Eigen::Matrix<double, 3, 6>;
using Matrix3x12 = Eigen::Matrix<double, 3, 12>;

/// Symmetric 3×3 matrix of a strain vector.
Matrix3 strain_matrix(const Vector6& strain);

/// [v]: the matrix with [v] w = v × w.
Matrix3 cross_matrix(const Vector3& v);

/// Rotation by the Cayley map: by 2 atan(|theta|/2) about theta.
Eigen::Quaterniond cayley(const Vector3& theta);

/// Place of a block: what is needed of its state to find its points.
struct Pose {
  Vector3 centroid = Vector3::Zero();
  Vector3 centroid_rest = Vector3::Zero();  ///< as in BlockState
  Matrix3 rotation = Matrix3::Identity();
  Matrix3 shape = Matrix3::Identity();  ///< R (I + eps)
};

Pose pose(const BlockState& block);

/// From one centroid to another, m: right to its own last place, wherever the two stand.
Vector3 between(const Pose& from, const Pose& to);

/// Moves a centroid; nothing is lost.
void move_centroid(const Vector3& by, BlockState& block);

/// The state's place after an increment; velocities are left alone.
BlockState displaced(const BlockState& block, const Vector12& increment);

/// 3×12: the mean motion of the point with reference arm X over a step from `start` to `end` with
/// rotation increment theta, so that T D is exactly the displacement of the point (see above).
/// Columns 6..11 are left zero when the block is rigid.
Matrix3x12 mean_motion(const Pose& start, const Pose& end, const Vector3& theta,
                       const Vector3& reference_arm, bool deformable);

/// 3×12: velocity of the point at one pose from (v | W | strain rate).
Matrix3x12 motion(const Pose& pose, const Vector3& reference_arm, bool deformable);

/// 3×6: E(e) X as a matrix on e.
Matrix3x6 strain_motion(const Vector3& arm);

}  // namespace quoin::solver
