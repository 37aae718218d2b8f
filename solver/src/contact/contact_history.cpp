#include "contact/contact_history.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "contact/joint_law.hpp"

namespace quoin::solver {

using geometry::ContactPoint;
using geometry::FeatureKind;

Vector3 reference_arm(const Pose& pose, const Vector3& place) {
  return pose.shape.inverse() * (place - pose.centroid);
}

const Joint& joint_between(const Scene& scene, int a, int b) {
  const int group_a = scene.blocks[static_cast<std::size_t>(a)].material.joint_group;
  const int group_b = scene.blocks[static_cast<std::size_t>(b)].material.joint_group;
  for (const PairJoint& pair : scene.pair_joints) {
    if ((pair.group_a == group_a && pair.group_b == group_b) ||
        (pair.group_a == group_b && pair.group_b == group_a)) {
      return pair.joint;
    }
  }
  return scene.joint;
}

namespace {

/// Cosine above which a feature's own normal stands for the pair's (30 degrees).
constexpr double kLikeNormals = 0.866;

Vector3 edge_now(const Scene& scene, const Pose& pose, int block, int edge) {
  const geometry::Shape& shape = scene.blocks[static_cast<std::size_t>(block)].shape;
  const auto ends = shape.topology().edge(edge);
  return (pose.shape * (shape.vertex(ends[1]) - shape.vertex(ends[0]))).normalized();
}

/// Area vector of a face as it stands now, outward (Newell).
Vector3 face_normal(const Scene& scene, const Pose& pose, int block, int face) {
  const geometry::Shape& shape = scene.blocks[static_cast<std::size_t>(block)].shape;
  const auto cycle = shape.topology().face(face);
  const Vector3 first = shape.vertex(cycle[0]);
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 2; i < cycle.size(); ++i) {
    sum += (pose.shape * (shape.vertex(cycle[i - 1]) - first))
               .cross(pose.shape * (shape.vertex(cycle[i]) - first));
  }
  return sum.normalized();
}

/// A vertex slides along its face, not along the pair's plane: the two differ where faces are
/// tilted.
Vector3 carried_normal(const Scene& scene, const Pose& pose_a, const Pose& pose_b,
                       const BodyContact& contact) {
  const ContactPoint& point = contact.state.point;
  Vector3 normal = point.normal;
  if (point.key.feature_a.kind == FeatureKind::Face) {
    normal = face_normal(scene, pose_a, contact.a, point.key.feature_a.index);
  } else if (point.key.feature_b.kind == FeatureKind::Face) {
    normal = -face_normal(scene, pose_b, contact.b, point.key.feature_b.index);
  }
  return normal.dot(point.normal) > kLikeNormals ? normal : point.normal;
}

/// Below this sine of their angle the edges say less about the normal than the pair's own.
constexpr double kLeastCrossing = 0.02;

void set_crossed_edges(const Scene& scene, const Pose& pose_a, const Pose& pose_b,
                       BodyContact& contact) {
  const geometry::ContactKey& key = contact.state.point.key;
  if (key.feature_a.kind != FeatureKind::Edge || key.feature_b.kind != FeatureKind::Edge) return;
  Vector3 edge_a = edge_now(scene, pose_a, contact.a, key.feature_a.index);
  const Vector3 edge_b = edge_now(scene, pose_b, contact.b, key.feature_b.index);
  const Vector3 normal = edge_a.cross(edge_b);
  const double along = normal.dot(contact.state.point.normal);
  if (normal.norm() < kLeastCrossing || std::abs(along) < kLikeNormals * normal.norm()) return;
  if (along < 0.0) edge_a = -edge_a;
  contact.crossed = true;
  contact.edge_a = pose_a.rotation.transpose() * edge_a;
  contact.edge_b = pose_b.rotation.transpose() * edge_b;
}

}  // namespace

BodyContact make_body_contact(const Scene& scene, std::span<const Pose> poses,
                              const ContactPoint& point) {
  BodyContact contact;
  contact.state.point = point;
  contact.a = point.key.a;
  contact.b = point.key.b;
  const Pose& pose_a = poses[static_cast<std::size_t>(contact.a)];
  const Pose& pose_b = poses[static_cast<std::size_t>(contact.b)];
  contact.arm_a = reference_arm(pose_a, point.point_a);
  contact.arm_b = reference_arm(pose_b, point.point_b);
  contact.state.anchor_a = contact.arm_a;
  contact.state.anchor_b = contact.arm_b;
  contact.normal_on_a =
      point.key.feature_a.kind == FeatureKind::Face ||
      (point.key.feature_b.kind != FeatureKind::Face &&
       scene.blocks[static_cast<std::size_t>(contact.a)].kind >= BlockKind::Fixed);
  const Pose& owner = contact.normal_on_a ? pose_a : pose_b;
  contact.normal_local =
      owner.rotation.transpose() * carried_normal(scene, pose_a, pose_b, contact);
  set_crossed_edges(scene, pose_a, pose_b, contact);
  contact.axis = std::abs(point.normal.x()) < 0.75 ? Vector3::UnitX() : Vector3::UnitY();
  contact.joint = joint_between(scene, contact.a, contact.b);
  return contact;
}

namespace {

/// Hands the history on. The stretch of a stuck contact (place of anchor b minus that of anchor a)
/// goes over to the new contact point, so that neither a new key nor a moved projection loses it.
void hand_on(const Contact& before, std::span<const Pose> poses, BodyContact& contact) {
  Contact& state = contact.state;
  const Vector3& normal = state.point.normal;
  contact.was_closed = before.mode != ContactMode::Open;
  state.mode = before.mode;
  state.normal_force = before.normal_force;
  state.shear_force = before.shear_force - before.shear_force.dot(normal) * normal;
  state.impact = before.impact;
  state.slip = before.slip;
  state.failed = before.failed;
  state.bonded = before.bonded;
  state.laid_gap = before.laid_gap;
  state.spring_area = before.spring_area;
  if (!contact.was_closed) return;
  if (before.point.key == state.point.key) {
    state.anchor_a = before.anchor_a;
    state.anchor_b = before.anchor_b;
    return;
  }
  const Pose& a = poses[static_cast<std::size_t>(contact.a)];
  const Pose& b = poses[static_cast<std::size_t>(contact.b)];
  const Vector3 stretch =
      b.centroid + b.shape * before.anchor_b - a.centroid - a.shape * before.anchor_a;
  state.anchor_b = reference_arm(b, state.point.point_b + stretch - stretch.dot(normal) * normal);
}

void start_history(const CarryOptions& options, BodyContact& contact) {
  if (!options.laid[static_cast<std::size_t>(contact.a)] &&
      !options.laid[static_cast<std::size_t>(contact.b)]) {
    contact.state.failed = true;
    return;
  }
  const double size = std::min(options.models[static_cast<std::size_t>(contact.a)].size,
                               options.models[static_cast<std::size_t>(contact.b)].size);
  lay(contact.joint, size, contact.state);
  contact.was_closed = contact.state.bonded;
}

/// Of each pair (neighbours in the list) number and area.
void measure_joints(std::vector<BodyContact>& contacts) {
  for (std::size_t first = 0, last = 0; first < contacts.size(); first = last) {
    double area = 0.0;
    for (; last < contacts.size() && contacts[last].a == contacts[first].a &&
           contacts[last].b == contacts[first].b;
         ++last) {
      area += contacts[last].state.point.area;
    }
    for (std::size_t i = first; i < last; ++i) {
      contacts[i].joint_area = area;
      contacts[i].joint_points = static_cast<int>(last - first);
    }
  }
}

}  // namespace

void carry_over(const CarryOptions& options, const std::vector<ContactPoint>& found,
                std::span<const Contact> before, std::vector<ContactPoint>& old_points,
                std::vector<BodyContact>& contacts) {
  old_points.clear();
  for (const Contact& contact : before) old_points.push_back(contact.point);
  const std::vector<int> previous = geometry::match_previous(found, old_points, options.reach);
  contacts.clear();
  for (std::size_t i = 0; i < found.size(); ++i) {
    BodyContact& contact =
        contacts.emplace_back(make_body_contact(options.scene, options.poses, found[i]));
    if (previous[i] >= 0) {
      hand_on(before[static_cast<std::size_t>(previous[i])], options.poses, contact);
    } else {
      start_history(options, contact);
    }
    if (contact.state.point.area > 0.0) contact.state.spring_area = contact.state.point.area;
    contact.was_bonded = contact.state.bonded;
    contact.opening = opening(contact.joint, contact.state);
  }
  measure_joints(contacts);
}

ContactGeometry contact_geometry(const BodyContact& contact, const Pose& a, const Pose& b) {
  ContactGeometry result;
  if (contact.crossed) {
    result.edge_a = a.rotation * contact.edge_a;
    result.edge_b = b.rotation * contact.edge_b;
    result.normal = result.edge_a.cross(result.edge_b).normalized();
  } else {
    result.normal = (contact.normal_on_a ? a : b).rotation * contact.normal_local;
  }
  result.place_a = a.centroid + a.shape * contact.arm_a;
  result.place_b = b.centroid + b.shape * contact.arm_b;
  result.gap = (result.place_b - result.place_a).dot(result.normal);
  return result;
}

}  // namespace quoin::solver
