#pragma once
/// The point-to-face contact of [Beyabanaki 2009], section 4: what its springs and its friction add
/// to the equations of the two blocks.

#include "block/displacement.hpp"

namespace quoin::solver {

/// A material point P1 of block i before a material point P0 of the face of block j.
/// After the increments D_i, D_j:   P0'P1' = between + T_i D_i - T_j D_j,   d_n = normal · P0'P1'
/// (28).
struct PointToFace {
  Vector3 normal = Vector3::UnitZ();         ///< unit, out of block j; frozen over the step (23)
  Vector3 between = Vector3::Zero();         ///< P1 - P0 at the start of the step, m
  Matrix3x12 motion_i = Matrix3x12::Zero();  ///< T_i(P1)
  Matrix3x12 motion_j = Matrix3x12::Zero();  ///< T_j(P0), not T_j(P2): see solver/README.md
};

/// Forces on the two blocks, 12×1 each, N and N m.
struct ContactForces {
  Vector12 i = Vector12::Zero(), j = Vector12::Zero();
};

/// Second derivatives and, at D = 0, minus the first derivatives of an energy. K_ji = K_ijᵀ.
struct ContactBlocks {
  Matrix12 ii = Matrix12::Zero(), ij = Matrix12::Zero(), jj = Matrix12::Zero();
  ContactForces force;
};

/// P0'P1', m.
Vector3 between_after(const PointToFace& contact, const Vector12& d_i, const Vector12& d_j);

/// Normal spring with multiplier, energy lambda d_n + Pn d_n²/2 (29): equations (31)–(41).
/// stiffness: Pn, N/m; multiplier: lambda, N, negative in compression.
ContactBlocks normal_blocks(const PointToFace& contact, double stiffness, double multiplier);

/// Force of the normal spring's multiplier alone, the part of (39), (41) that an update changes.
ContactForces multiplier_forces(const PointToFace& contact, double multiplier);

/// Shear spring, energy Ps (|P0'P1'|² - d_n²)/2 (43): equations (47), (48). stiffness: Ps, N/m.
ContactBlocks shear_blocks(const PointToFace& contact, double stiffness);

/// Friction, energy F d·L/|L| (52): equations (54)–(57). friction: F, N; direction: L/|L| or zero.
ContactForces friction_forces(const PointToFace& contact, double friction,
                              const Vector3& direction);

}  // namespace quoin::solver
