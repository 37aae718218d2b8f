#include "block/block_terms.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "base/messages.hpp"

namespace quoin::solver {
namespace {

void check_material(const Block& block, int index) {
  const Material& m = block.material;
  if (!(m.density > 0.0) || !std::isfinite(m.density)) {
    throw InputError(label(block, index) + ": density " + text_of(m.density) +
                     " kg/m3 must be finite and greater than 0");
  }
  if (block.kind != BlockKind::Deformable) return;
  if (!(m.young > 0.0) || !std::isfinite(m.young)) {
    throw InputError(label(block, index) + ": Young's modulus " + text_of(m.young) +
                     " Pa must be finite and greater than 0 (or make the block rigid)");
  }
  if (!(m.poisson > -1.0 && m.poisson < 0.5)) {
    throw InputError(label(block, index) + ": Poisson's ratio " + text_of(m.poisson) +
                     " must lie in (-1, 0.5)");
  }
}

/// E(e) X = sum X_k strain_basis(k) e.
const Eigen::Matrix<double, 3, 6>& strain_basis(int k) {
  static const std::array<Eigen::Matrix<double, 3, 6>, 3> basis = {strain_motion(Vector3::UnitX()),
                                                                   strain_motion(Vector3::UnitY()),
                                                                   strain_motion(Vector3::UnitZ())};
  return basis[static_cast<std::size_t>(k)];
}

void set_inertia(BlockModel& model, double density, const Matrix3& second_moment) {
  const Matrix3& s = model.second_moment = density * second_moment;
  model.inertia = s.trace() * Matrix3::Identity() - s;
  model.strain_inertia.setZero();
  model.inertia_coupling.setZero();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Eigen::Matrix<double, 3, 6>& basis_i = strain_basis(i);
      const Eigen::Matrix<double, 3, 6>& basis_j = strain_basis(j);
      model.strain_inertia += s(i, j) * basis_i.transpose() * basis_j;
      // theta × X = -[X] theta
      model.inertia_coupling += s(i, j) * cross_matrix(Vector3::Unit(i)) * basis_j;
    }
  }
}

/// Momenta per unit time step of (theta | e) rows: (J W + C e', C^T W + S e').
Eigen::Matrix<double, 9, 1> momentum(const BlockModel& m, const Vector3& spin,
                                     const Vector6& rate) {
  Eigen::Matrix<double, 9, 1> result;
  if (m.unknowns == 6) {  // no rate
    result << m.inertia * spin, Vector6::Zero();
    return result;
  }
  result.head<3>() = m.inertia * spin + m.inertia_coupling * rate;
  result.tail<6>() = m.inertia_coupling.transpose() * spin + m.strain_inertia * rate;
  return result;
}

}  // namespace

double Elasticity::operator()(int i, int j) const {
  if (i >= 3 || j >= 3) return i == j ? shear : 0.0;
  return i == j ? lame + 2.0 * shear : lame;
}

Eigen::Matrix<double, 6, 6> Elasticity::matrix() const {
  return Eigen::Matrix<double, 6, 6>::NullaryExpr([this](Eigen::Index i, Eigen::Index j) {
    return (*this)(static_cast<int>(i), static_cast<int>(j));
  });
}

Vector6 Elasticity::operator*(const Vector6& strain) const {
  Vector6 stress;
  for (int i = 0; i < 3; ++i)
    stress[i] = (*this)(i, 0) * strain[0] + (*this)(i, 1) * strain[1] + (*this)(i, 2) * strain[2];
  stress.tail<3>() = shear * strain.tail<3>();
  return stress;
}

double Elasticity::energy(const Vector6& stress) const {
  const double trace = stress.head<3>().sum();
  const double share = lame / (2.0 * shear + 3.0 * lame);
  return 0.25 / shear * (stress.head<3>().squaredNorm() - share * trace * trace) +
         0.5 / shear * stress.tail<3>().squaredNorm();
}

Elasticity isotropic_elasticity(double young, double poisson) {
  return {.lame = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)),
          .shear = young / (2.0 * (1.0 + poisson))};
}

namespace {

/// The same parts at other places of the vertices of all.
std::shared_ptr<const ReferenceParts> placed_parts(const std::vector<geometry::Shape>& parts,
                                                   const geometry::Points& arms) {
  ReferenceParts placed;
  std::array<int, 3> first{};
  for (const geometry::Shape& part : parts) {
    const geometry::Topology& topology = part.topology();
    placed.push_back({std::make_shared<const geometry::Shape>(
                          part.shared_topology(), arms.middleCols(first[0], part.vertex_count())),
                      first});
    first[0] += topology.vertex_count();
    first[1] += topology.edge_count();
    first[2] += topology.face_count();
  }
  return std::make_shared<const ReferenceParts>(std::move(placed));
}

FeatureRange range_of(const BlockModel& model, int part, geometry::FeatureKind kind, int count) {
  if (!model.parts) return {0, count};
  const ReferenceParts& parts = *model.parts;
  const auto p = static_cast<std::size_t>(part), k = static_cast<std::size_t>(kind);
  return {parts[p].first[k], p + 1 < parts.size() ? parts[p + 1].first[k] : count};
}

}  // namespace

ReferenceShape reference_shape(const geometry::Shape& shape,
                               const std::vector<geometry::Shape>* parts) {
  const geometry::Points near = shape.vertices().colwise() - shape.origin();
  const geometry::MassProperties properties =
      geometry::mass_properties(geometry::Shape(shape.shared_topology(), near));
  const geometry::Points arms = near.colwise() - properties.centroid;
  return {std::make_shared<const geometry::Shape>(shape.shared_topology(), arms),
          parts ? placed_parts(*parts, arms) : nullptr, properties.centroid, properties.volume,
          properties.second_moment};
}

int part_of(const BlockModel& model, const geometry::Feature& feature) {
  if (!model.parts) return 0;
  const auto first = [&](const ReferencePart& part) {
    return part.first[static_cast<std::size_t>(feature.kind)];
  };
  const auto next = std::ranges::upper_bound(*model.parts, feature.index, {}, first);
  return static_cast<int>(next - model.parts->begin()) - 1;
}

FeatureRange vertices_of(const BlockModel& model, int part) {
  return range_of(model, part, geometry::FeatureKind::Vertex, model.shape->vertex_count());
}

FeatureRange faces_of(const BlockModel& model, int part) {
  return range_of(model, part, geometry::FeatureKind::Face, model.shape->topology().face_count());
}

geometry::Points reference_arms(const BlockModel& model) {
  return model.turn * model.shape->vertices();
}

geometry::Placement placement(const BlockModel& model, const Pose& pose) {
  return {pose.shape * model.turn, pose.centroid};
}

Vector3 displacement(const BlockModel& model, const Pose& pose, const Vector3& arm) {
  return between(solver::pose(model.start), pose) + (pose.shape * arm - arm);
}

BlockModel make_block_model(const Block& block, const ReferenceShape& reference,
                            const Vector3& origin, int index) {
  BlockModel model;
  model.kind = block.kind;
  model.shape = reference.shape;
  model.parts = reference.parts;
  model.turn = block.placement.linear;
  const geometry::Body body = block.body();
  model.start.centroid = block.placement.translation;
  move_centroid(-origin, model.start);
  move_centroid(body.turned_origin(), model.start);
  move_centroid(body.turned_origin_rest(), model.start);
  move_centroid(model.turn * reference.centroid, model.start);
  const double stretch = model.turn.determinant();
  model.volume = stretch * reference.volume;
  model.size = body.stretch() * model.shape->diameter();
  model.coordinate_rounding = std::numeric_limits<double>::epsilon() *
                              (body.turned_origin().norm() + block.placement.translation.norm());
  model.strain_inertia.setZero();
  model.inertia_coupling.setZero();
  if (block.kind >= BlockKind::Fixed) return model;
  check_material(block, index);
  model.unknowns = block.kind == BlockKind::Deformable ? 12 : 6;
  model.mass = block.material.density * model.volume;
  set_inertia(model, stretch * block.material.density,
              model.turn * reference.second_moment * model.turn.transpose());
  if (block.kind == BlockKind::Deformable) {
    model.elasticity = isotropic_elasticity(block.material.young, block.material.poisson);
    model.initial_stress = block.initial_stress;
  } else {
    model.strain_inertia.setZero();
    model.inertia_coupling.setZero();
  }
  return model;
}

Matrix12 block_matrix(const BlockModel& model, const StepScheme& scheme) {
  const double factor = 2.0 / (scheme.time_step * scheme.time_step);
  Matrix12 k = Matrix12::Zero();
  k.diagonal().head<3>().setConstant(factor * model.mass);
  k.block<3, 3>(3, 3) = factor * model.inertia;
  if (model.unknowns == 12 && scheme.deforms) {
    k.block<3, 6>(3, 6) = factor * model.inertia_coupling;
    k.block<6, 3>(6, 3) = factor * model.inertia_coupling.transpose();
    k.bottomRightCorner<6, 6>() =
        factor * model.strain_inertia + scheme.end_share * model.volume * model.elasticity.matrix();
  } else {
    k.bottomRightCorner<6, 6>().setIdentity();
  }
  return k;
}

Vector12 static_block_force(const BlockModel& model, const BlockState& state) {
  Vector12 force = Vector12::Zero();
  if (model.unknowns == 12) force.tail<6>() = -model.volume * stress(model, state.strain);
  return force;
}

Vector12 block_force(const BlockModel& model, const BlockState& state, const StepScheme& scheme,
                     const Vector12& increment) {
  const double dt = scheme.time_step;
  const Vector3 theta = increment.segment<3>(3);
  Vector12 force = Vector12::Zero();
  force.head<3>() = (2.0 / dt) * model.mass * state.velocity;
  const bool deformable = model.unknowns == 12 && scheme.deforms;
  const Vector6 rate = deformable ? state.strain_rate : Vector6::Zero();
  const Eigen::Matrix<double, 9, 1> now = momentum(model, state.angular_velocity, rate);
  const Vector6 strain_increment = deformable ? Vector6(increment.tail<6>()) : Vector6::Zero();
  const Vector3 spin_end =
      (2.0 / dt) * (model.inertia * theta + model.inertia_coupling * strain_increment) -
      now.head<3>();
  // The momentum at the end stands in the turned frame: cay(theta) - I turns it back (gyroscopic).
  force.segment<3>(3) = (2.0 / dt) * now.head<3>() - (cayley(theta) * spin_end - spin_end) / dt;
  if (!deformable) return force;
  force += static_block_force(model, state);
  force.tail<6>() += (2.0 / dt) * now.tail<6>();
  const Vector3 spin = theta / dt;
  for (int i = 0; i < 3; ++i) {
    const Vector3 centripetal = spin.cross(spin.cross(Vector3(model.second_moment.row(i))));
    force.tail<6>() -= strain_basis(i).transpose() * centripetal;
  }
  return force;
}

BlockState with_end_velocity(const BlockState& end, const BlockState& start,
                             const Vector12& increment, double time_step) {
  BlockState result = end;
  result.velocity = (2.0 / time_step) * increment.head<3>() - start.velocity;
  result.angular_velocity = (2.0 / time_step) * increment.segment<3>(3) - start.angular_velocity;
  result.strain_rate = (2.0 / time_step) * increment.tail<6>() - start.strain_rate;
  return result;
}

BlockState with_held_strain(const BlockModel& model, const BlockState& state) {
  BlockState result = state;
  result.angular_velocity += model.inertia.inverse() * (model.inertia_coupling * state.strain_rate);
  result.strain_rate.setZero();
  return result;
}

Vector12 velocity_vector(const BlockState& state) {
  Vector12 v;
  v << state.velocity, state.angular_velocity, state.strain_rate;
  return v;
}

BlockState with_velocity(const BlockState& state, const Vector12& velocity) {
  BlockState moving = state;
  moving.velocity = velocity.head<3>();
  moving.angular_velocity = velocity.segment<3>(3);
  moving.strain_rate = velocity.tail<6>();
  return moving;
}

Vector6 stress(const BlockModel& model, const Vector6& strain) {
  return model.elasticity * strain + model.initial_stress;
}

double kinetic_energy(const BlockModel& model, const BlockState& state) {
  if (model.unknowns == 0) return 0.0;
  const Eigen::Matrix<double, 9, 1> p = momentum(model, state.angular_velocity, state.strain_rate);
  return 0.5 * (model.mass * state.velocity.squaredNorm() +
                state.angular_velocity.dot(p.head<3>()) + state.strain_rate.dot(p.tail<6>()));
}

double strain_energy(const BlockModel& model, const BlockState& state) {
  if (model.unknowns != 12) return 0.0;
  return model.volume * model.elasticity.energy(stress(model, state.strain));
}

}  // namespace quoin::solver
