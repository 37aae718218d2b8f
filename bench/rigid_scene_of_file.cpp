#include "rigid_scene_of_file.hpp"

#include <algorithm>
#include <cmath>
#include <quoin/geometry/mass_properties.hpp>
#include <stdexcept>

namespace quoin::bench {
namespace {

/// The three edges that leave one vertex of a box, m; empty when it is no box.
std::vector<Vector3d> box_edges(const geometry::Body& body) {
  if (body.shape().vertex_count() != 8 || body.shape().topology().face_count() != 6) return {};
  std::vector<Vector3d> edges;
  for (int v = 1; v < 8; ++v) edges.push_back(body.vertex(v) - body.vertex(0));
  std::sort(edges.begin(), edges.end(),
            [](const Vector3d& a, const Vector3d& b) { return a.squaredNorm() < b.squaredNorm(); });
  // The shortest two are edges; the third is the first that stands square on both.
  const auto square = [](const Vector3d& a, const Vector3d& b) {
    return std::abs(a.dot(b)) <= 1e-9 * a.norm() * b.norm();
  };
  if (!square(edges[0], edges[1])) return {};
  for (std::size_t k = 2; k < edges.size(); ++k)
    if (square(edges[k], edges[0]) && square(edges[k], edges[1]))
      return {edges[0], edges[1], edges[k]};
  return {};
}

std::function<Vector3d(double)> acceleration_of(const solver::Block& block) {
  if (block.motion.kind != solver::MotionKind::Acceleration)
    throw std::invalid_argument("the peers know motion given by its acceleration");
  return [value = block.motion.value](double time) { return value.at(time); };
}

bool is_held(const solver::Block& block) {
  return block.kind == solver::BlockKind::Fixed || block.kind == solver::BlockKind::Prescribed;
}

RigidBody body_of(const solver::Block& block) {
  const double density = is_held(block) ? 0.0 : block.material.density;
  RigidBody body;
  const std::vector<Vector3d> edges = box_edges(block.body());
  if (edges.size() == 3) {
    const Vector3d half(0.5 * edges[0].norm(), 0.5 * edges[1].norm(), 0.5 * edges[2].norm());
    body = box(-half, half, density);
    Eigen::Matrix3d axes;
    axes << edges[0].normalized(), edges[1].normalized(), edges[0].cross(edges[1]).normalized();
    body.turn = Eigen::Quaterniond(axes);
    body.place = geometry::mass_properties(block.body()).centroid;
  } else {
    body = hull(block.body().vertices(), density);
  }
  if (block.kind == solver::BlockKind::Prescribed) body.acceleration = acceleration_of(block);
  body.velocity = block.velocity;
  body.spin = block.angular_velocity;
  return body;
}

/// That of the pairs of held blocks with others, where all have one of their own.
std::optional<double> held_friction(const solver::Scene& scene) {
  if (scene.pair_joints.empty()) return {};
  const solver::PairJoint& pair = scene.pair_joints[0];
  const auto first = std::find_if(scene.blocks.begin(), scene.blocks.end(), is_held);
  const int held = first == scene.blocks.end() ? pair.group_a : first->material.joint_group;
  const int others = pair.group_a == held ? pair.group_b : pair.group_a;
  bool known = scene.pair_joints.size() == 1 && pair.group_a != pair.group_b &&
               (pair.group_a == held || pair.group_b == held) && pair.joint.restitution == 0.0 &&
               pair.joint.cohesion == 0.0 && pair.joint.tension == 0.0 &&
               scene.joint.friction_angle > 0.0;
  for (const solver::Block& block : scene.blocks)
    known = known && block.material.joint_group == (is_held(block) ? held : others);
  if (!known) throw std::invalid_argument("the peers know one other joint: of what is held");
  return std::tan(pair.joint.friction_angle);
}

}  // namespace

RigidScene rigid_scene(const scene_file::SceneFile& file) {
  const solver::Scene& scene = file.scene;
  const bool plain = scene.face_loads.empty() && scene.body_loads.empty() &&
                     scene.fixed_points.empty() && scene.gravity.is_constant() &&
                     scene.joint.restitution == 0.0 && file.stages.size() == 1;
  if (!plain) throw std::invalid_argument("the peers know gravity, friction and central forces");
  RigidScene rigid;
  rigid.friction = std::tan(scene.joint.friction_angle);
  rigid.held_friction = held_friction(scene);
  rigid.gravity = scene.gravity.at(0.0);
  for (const solver::Block& block : scene.blocks) rigid.bodies.push_back(body_of(block));
  for (const solver::PointLoad& load : scene.point_loads) {
    RigidBody& body = rigid.bodies[static_cast<std::size_t>(load.block)];
    const Vector3d force = load.force.at(0.0);
    const double arm = (load.point - body.place).cross(force).norm() / force.norm();
    if (!load.force.is_constant() || arm > 1e-9)
      throw std::invalid_argument("the peers know constant forces through centroids");
    body.force += force;
  }
  return rigid;
}

}  // namespace quoin::bench
