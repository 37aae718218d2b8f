#include "scene_file/group_value.hpp"

#include <Eigen/Geometry>
#include <quoin/geometry/mass_properties.hpp>

namespace quoin::scene_file {
namespace {

using solver::BlockState;
using solver::Matrix3;
using solver::Vector6;

/// (xx, yy, zz, gamma xy, gamma yz, gamma zx) as a tensor.
Matrix3 strain_tensor(const Vector6& v) {
  Matrix3 result;
  result << v[0], v[3] / 2, v[5] / 2, v[3] / 2, v[1], v[4] / 2, v[5] / 2, v[4] / 2, v[2];
  return result;
}

Vector6 world_strain(const BlockState& now) {
  const Matrix3 rotation = now.rotation.toRotationMatrix();
  const Matrix3 e = rotation * strain_tensor(now.strain) * rotation.transpose();
  Vector6 result;
  result << e(0, 0), e(1, 1), e(2, 2), 2 * e(0, 1), 2 * e(1, 2), 2 * e(2, 0);
  return result;
}

/// About the block's own centroid: the integral of rho (A X) × (B X), with A = I + eps and
/// B = [omega] A + eps', in the turning frame.
Vector3 own_angular_momentum(const BlockState& now, const Matrix3& second_moment) {
  const Matrix3 place = Matrix3::Identity() + strain_tensor(now.strain);
  Matrix3 spin;
  spin << 0, -now.angular_velocity.z(), now.angular_velocity.y(), now.angular_velocity.z(), 0,
      -now.angular_velocity.x(), -now.angular_velocity.y(), now.angular_velocity.x(), 0;
  const Matrix3 velocity = spin * place + strain_tensor(now.strain_rate);
  const Matrix3 m = place * second_moment * velocity.transpose();
  return now.rotation * Vector3(m(1, 2) - m(2, 1), m(2, 0) - m(0, 2), m(0, 1) - m(1, 0));
}

}  // namespace

MonitorValue group_value(const solver::Simulation& simulation, std::span<const int> blocks) {
  MonitorValue value;
  double mass = 0.0, volume = 0.0;
  Vector3 first_moment = Vector3::Zero(), about_origin = Vector3::Zero();
  for (const int b : blocks) {
    const solver::Block& block = simulation.scene().blocks[static_cast<std::size_t>(b)];
    if (block.kind == solver::BlockKind::Absent) continue;
    const BlockState& now = simulation.state().blocks[static_cast<std::size_t>(b)];
    const geometry::MassProperties shape = geometry::mass_properties(block.body());
    const double m = block.material.density * shape.volume;
    mass += m;
    first_moment += m * now.centroid;
    value.momentum += m * now.velocity;
    about_origin += now.centroid.cross(m * now.velocity) +
                    own_angular_momentum(now, block.material.density * shape.second_moment);
    if (block.kind != solver::BlockKind::Deformable) continue;
    volume += shape.volume;
    value.stress += shape.volume * simulation.stress(b);
    value.strain += shape.volume * world_strain(now);
  }
  if (mass > 0) value.angular_momentum = about_origin - (first_moment / mass).cross(value.momentum);
  value.stress /= volume;  // no deformable block: NaN
  value.strain /= volume;
  return value;
}

}  // namespace quoin::scene_file
