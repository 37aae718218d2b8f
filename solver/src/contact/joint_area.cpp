#include "contact/joint_area.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace quoin::solver {
namespace {

using Eigen::Vector2d;
using Polygon = std::vector<Vector2d>;

// Of the side of a square of the joint's area: a corner farther from all contacts is lifted.
// Chosen: less than a brick's short side.
constexpr double kNearCorner = 0.3;

/// A block seen from A's centroid.
struct SeenBlock {
  const BlockModel& model;
  const Pose& pose;
  int part;
  Vector3 centroid;
  Vector3 vertex(int v) const {
    return centroid + pose.shape * (model.turn * model.shape->vertex(v));
  }
  Vector3 normal(int face) const {
    return pose.rotation * (model.turn * model.shape->face_normal(face));
  }
};

/// The vertex that lies farthest that way.
int farthest_vertex(const SeenBlock& block, const Vector3& way) {
  const FeatureRange vertices = vertices_of(block.model, block.part);
  int farthest = vertices.first;
  double most = -std::numeric_limits<double>::infinity();
  for (int v = vertices.first; v < vertices.end; ++v) {
    const double along = way.dot(block.vertex(v));
    if (along > most) farthest = v;
    most = std::max(most, along);
  }
  return farthest;
}

/// The face of a block that carries the joint: that at its foremost vertex which faces most.
Polygon foremost_face(const SeenBlock& block, const JointPlane& plane, const Vector3& way) {
  const geometry::Topology& topology = block.model.shape->topology();
  const auto faces = topology.vertex_faces(farthest_vertex(block, way));
  const int face =
      *std::ranges::max_element(faces, {}, [&](int f) { return way.dot(block.normal(f)); });
  Polygon polygon;
  for (const int v : topology.face(face)) polygon.push_back(plane(block.vertex(v)));
  return polygon;
}

/// The part of a polygon to the left of a line from p to q.
Polygon left_of(const Polygon& polygon, const Vector2d& p, const Vector2d& q) {
  Polygon part;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d &here = polygon[i], &next = polygon[(i + 1) % polygon.size()];
    const double left = cross(q - p, here - p), left_next = cross(q - p, next - p);
    if (left >= 0.0) part.push_back(here);
    if ((left >= 0.0) == (left_next >= 0.0)) continue;
    part.push_back(here + left / (left - left_next) * (next - here));
  }
  return part;
}

/// Without corners that are none: of sides that lie over each other, and cross by rounding.
Polygon without_straight(const Polygon& polygon) {
  Polygon corners;
  const std::size_t n = polygon.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vector2d to = polygon[i] - (corners.empty() ? polygon[n - 1] : corners.back());
    const Vector2d from = polygon[(i + 1) % n] - polygon[i];
    if (cross(to, from) > kStraight * to.norm() * from.norm()) corners.push_back(polygon[i]);
  }
  return corners;
}

/// What the two faces share. `contact`: of the joint.
Polygon shared_face(const JointBlocks& blocks, const BodyContact& contact,
                    const JointPlane& plane) {
  const SeenBlock a{blocks.model_a, blocks.a, contact.part_a, Vector3::Zero()};
  const SeenBlock b{blocks.model_b, blocks.b, contact.part_b, between(blocks.a, blocks.b)};
  Polygon shared = foremost_face(a, plane, plane.normal);
  Polygon other = foremost_face(b, plane, -plane.normal);
  std::ranges::reverse(other);  // seen from behind
  for (std::size_t i = 0; i < other.size() && !shared.empty(); ++i) {
    shared = left_of(shared, other[i], other[(i + 1) % other.size()]);
  }
  return without_straight(shared);
}

/// Each corner's half of the two triangles (centroid, corner, next) beside it, m2: as geometry
/// shares out a contact polygon.
std::vector<double> corner_shares(const Polygon& polygon) {
  const std::size_t n = polygon.size();
  Vector2d moment = Vector2d::Zero();
  double area = 0.0;
  for (std::size_t i = 2; i < n; ++i) {
    const double part = 0.5 * cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
    area += part;
    moment += part / 3.0 * (polygon[0] + polygon[i - 1] + polygon[i]);
  }
  std::vector<double> shares(n, 0.0);
  if (!(area > 0.0)) return shares;
  const Vector2d centroid = moment / area;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t next = (i + 1) % n;
    const double half = 0.25 * cross(polygon[i] - centroid, polygon[next] - centroid);
    shares[i] += half;
    shares[next] += half;
  }
  return shares;
}

}  // namespace

/// A corner that parts from another, as an edge slides over it, takes its share along without a
/// jump.
JointArea joint_area(const JointBlocks& blocks, std::span<const BodyContact> joint) {
  const JointPlane plane(joint.front().state.point.normal);
  const Polygon polygon = shared_face(blocks, joint.front(), plane);
  const std::vector<double> corners = corner_shares(polygon);
  JointArea area{0.0, std::vector<double>(joint.size(), 0.0)};
  for (const double corner : corners) area.whole += corner;
  const double reach = kNearCorner * std::sqrt(area.whole);
  for (std::size_t i = 0; i < polygon.size() && area.whole > 0.0; ++i) {
    const auto distance = [&](const BodyContact& contact) {
      return (plane(blocks.a.shape * contact.arm_a) - polygon[i]).norm();
    };
    const auto nearest = std::ranges::min_element(joint, {}, distance);
    const double left = std::max(0.0, 1.0 - distance(*nearest) / reach);
    area.share[static_cast<std::size_t>(nearest - joint.begin())] += left * corners[i];
  }
  return area;
}

}  // namespace quoin::solver
