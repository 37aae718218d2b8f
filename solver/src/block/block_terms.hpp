#pragma once
/// Inertia, elasticity and loads of one block: 12×12 and 12×1 terms of K D = F without contacts.

#include <array>
#include <quoin/geometry/mass_properties.hpp>

#include "block/displacement.hpp"

namespace quoin::solver {

/// A convex part of a block, and where its features begin among those of the block's shape.
struct ReferencePart {
  std::shared_ptr<const geometry::Shape> shape;  ///< in the frame of the whole
  std::array<int, 3> first{};                    ///< vertex, edge and face, by FeatureKind
};
using ReferenceParts = std::vector<ReferencePart>;

/// A shape as seen from its centroid: shared by all blocks of that shape.
struct ReferenceShape {
  std::shared_ptr<const geometry::Shape> shape;   ///< centroid in its origin, axes as given
  std::shared_ptr<const ReferenceParts> parts{};  ///< null: the shape is convex
  Vector3 centroid = Vector3::Zero();       ///< of the shape as given, from its Shape::origin(), m
  double volume = 0.0;                      ///< m3
  Matrix3 second_moment = Matrix3::Zero();  ///< about the centroid, m5
};

/// `parts`: Block::parts; null: the shape is convex.
ReferenceShape reference_shape(const geometry::Shape& shape,
                               const std::vector<geometry::Shape>* parts = nullptr);

/// Isotropic: stress from strain, Pa; shear strains as gamma. Zero of a block that does not deform.
struct Elasticity {
  double lame = 0.0;                      ///< Pa
  double shear = 0.0;                     ///< Pa
  double operator()(int i, int j) const;  ///< of the 6×6 matrix, Pa
  Eigen::Matrix<double, 6, 6> matrix() const;
  Vector6 operator*(const Vector6& strain) const;
  double energy(const Vector6& stress) const;  ///< per volume, stress · inverse · stress / 2, J/m3
};

/// Pa; > 0, -1 < poisson < 0.5.
Elasticity isotropic_elasticity(double young, double poisson);

/// What never changes of a block: reference shape and constant matrices, all in the turning frame.
struct BlockModel {
  BlockKind kind = BlockKind::Fixed;
  int unknowns = 0;                              ///< 12, 6 or 0
  std::shared_ptr<const geometry::Shape> shape;  ///< ReferenceShape::shape
  std::shared_ptr<const ReferenceParts> parts;   ///< ReferenceShape::parts
  Matrix3 turn = Matrix3::Identity();            ///< reference arm = turn × place in `shape`
  BlockState start;                              ///< at rest in its place, without velocities
  double volume = 0.0;                           ///< m3
  double mass = 0.0;                             ///< kg
  double size = 0.0;  ///< diameter (Shape::diameter), the same in any frame, m
  double coordinate_rounding =
      0.0;  ///< m: a vertex is known no better, for the rounding of its coordinates
  Matrix3 inertia = Matrix3::Zero();             ///< kg m2
  Eigen::Matrix<double, 3, 6> inertia_coupling;  ///< rotation with strain, kg m2
  Vector6 initial_stress = Vector6::Zero();      ///< Pa, turning frame
  Eigen::Matrix<double, 6, 6> strain_inertia;    ///< kg m2
  Elasticity elasticity;
  Matrix3 second_moment = Matrix3::Zero();  ///< rho integral X X^T dV, kg m2
};

/// `origin`: State::origin, m. Throws InputError naming the block.
BlockModel make_block_model(const Block& block, const ReferenceShape& reference,
                            const Vector3& origin, int index);

geometry::Points reference_arms(const BlockModel& model);  ///< of all vertices, 3 × n, m

/// Part of a block that a feature of its shape is of; 0 of a convex one.
int part_of(const BlockModel& model, const geometry::Feature& feature);

/// Indices of the vertices or faces that a part has in the block's shape: first <= i < end.
struct FeatureRange {
  int first = 0, end = 0;
};
FeatureRange vertices_of(const BlockModel& model, int part);
FeatureRange faces_of(const BlockModel& model, int part);

/// Where the reference shape stands, relative to State::origin.
geometry::Placement placement(const BlockModel& model, const Pose& pose);

/// Of the material point with that reference arm since the start, m.
Vector3 displacement(const BlockModel& model, const Pose& pose, const Vector3& arm);

/// Share of the elastic force that is taken at the end of the step: 1 for Shi's scheme, 1/2 for the
/// energy–momentum scheme.
struct StepScheme {
  double time_step = 0.0;
  double end_share = 1.0;
  bool deforms = true;  ///< false: the block moves rigidly in this step and its strain waits
};

/// K of a block alone: 2 M/dt2 + end_share V E.   [Beyabanaki 2009], equation (8), after Shi.
Matrix12 block_matrix(const BlockModel& model, const StepScheme& scheme);

/// F of a block alone: 2 M v/dt - V stress, centrifugal and gyroscopic forces. `theta`: rotation
/// increment of the step (the last estimate of it), turning frame.
Vector12 block_force(const BlockModel& model, const BlockState& state, const StepScheme& scheme,
                     const Vector12& increment);

/// The same at rest: - V stress.
Vector12 static_block_force(const BlockModel& model, const BlockState& state);

/// Velocities at the end of the step: 2 D/dt - v.
BlockState with_end_velocity(const BlockState& end, const BlockState& start,
                             const Vector12& increment, double time_step);

/// The same state with its strain held: the strain rates go, their angular momentum stays. Of all
/// rigid motions the nearest by mass, so kinetic energy does not grow.
BlockState with_held_strain(const BlockModel& model, const BlockState& state);

/// (v | W | strain rate)
Vector12 velocity_vector(const BlockState& state);
BlockState with_velocity(const BlockState& state, const Vector12& velocity);

Vector6 stress(const BlockModel& model, const Vector6& strain);           ///< Pa, turning frame
double kinetic_energy(const BlockModel& model, const BlockState& state);  ///< J
double strain_energy(const BlockModel& model, const BlockState& state);   ///< J

}  // namespace quoin::solver
