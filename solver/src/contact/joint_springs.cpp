#include "contact/joint_springs.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "contact/joint_law.hpp"

namespace quoin::solver {
namespace {

using Eigen::Vector2d;
using Polygon = std::vector<Vector2d>;

// Chosen. Of the squared length of the smaller block (cube root of its volume), for all contacts of
// a joint: what stands on an edge or a corner beside all faces has a spring, too.
constexpr double kLeastArea = 0.01;
// Of the side of a square of the joint's area: a corner farther from all contacts is lifted.
// Chosen: less than a brick's short side.
constexpr double kNearCorner = 0.3;
constexpr double kStraight = 1e-3;         // rad: a side that turns by less does not
constexpr double kWholeArea = 1.0 - 1e-6;  // of the faces': geometry has found all of it
constexpr double kSameEnergy = 1e-9;       // more, relative, is not rounding of gaps

/// The plane of a joint, seen along its normal; from A's centroid, m.
struct JointPlane {
  Vector3 normal, u, v;
  explicit JointPlane(const Vector3& along) : normal(along) {
    u = normal.unitOrthogonal();
    v = normal.cross(u);
  }
  Vector2d operator()(const Vector3& place) const { return {u.dot(place), v.dot(place)}; }
};

double cross(const Vector2d& p, const Vector2d& q) { return p.x() * q.y() - p.y() * q.x(); }

/// A block seen from A's centroid.
struct SeenBlock {
  const BlockModel& model;
  const Pose& pose;
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
  int farthest = 0;
  double most = -std::numeric_limits<double>::infinity();
  for (int v = 0; v < block.model.shape->vertex_count(); ++v) {
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

/// What the two faces share.
Polygon shared_face(const JointBlocks& blocks, const JointPlane& plane) {
  const SeenBlock a{blocks.model_a, blocks.a, Vector3::Zero()};
  const SeenBlock b{blocks.model_b, blocks.b, between(blocks.a, blocks.b)};
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

/// Corners give their shares to the nearest contact, the less the farther it is: a corner that
/// parts from another, as an edge slides over it, takes its share along without a jump.
void share_out(const Polygon& polygon, std::span<const double> shares, double area,
               const JointPlane& plane, const Pose& a, std::span<BodyContact> joint) {
  const double reach = kNearCorner * std::sqrt(area);
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const auto distance = [&](const BodyContact& contact) {
      return (plane(a.shape * contact.arm_a) - polygon[i]).norm();
    };
    BodyContact& nearest = *std::ranges::min_element(joint, {}, distance);
    nearest.state.spring_area += std::max(0.0, 1.0 - distance(nearest) / reach) * shares[i];
  }
}

/// Whether a place lies among others: they are seen from it in all directions, but for less than
/// half of them.
bool lies_among(const Vector2d& place, std::span<const Vector2d> others) {
  if (others.size() < 2) return false;
  std::vector<double> angles;
  for (const Vector2d& other : others) {
    angles.push_back(std::atan2(other.y() - place.y(), other.x() - place.x()));
  }
  std::ranges::sort(angles);
  double widest = angles.front() + 2.0 * std::numbers::pi - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i) {
    widest = std::max(widest, angles[i] - angles[i - 1]);
  }
  return widest < std::numbers::pi + kStraight;
}

/// Contacts that lie at no corner, but among those that do, touch where these do.
void leave_inner_out(const JointPlane& plane, const Pose& a, std::span<BodyContact> joint) {
  std::vector<Vector2d> corners;
  for (const BodyContact& contact : joint) {
    if (contact.state.spring_area > 0.0) corners.push_back(plane(a.shape * contact.arm_a));
  }
  for (BodyContact& contact : joint) {
    if (contact.state.spring_area > 0.0) continue;
    contact.beside_springs = lies_among(plane(a.shape * contact.arm_a), corners);
  }
}

/// Others that lie at no corner, and corners of slivers, have their part of the least area.
void raise_to_least(const JointBlocks& blocks, std::span<BodyContact> joint) {
  const double length = std::cbrt(std::min(blocks.model_a.volume, blocks.model_b.volume));
  const auto parts = std::ranges::count(joint, false, &BodyContact::beside_springs);
  const double least = kLeastArea * length * length / static_cast<double>(parts);
  for (BodyContact& contact : joint) {
    if (contact.beside_springs) continue;
    contact.state.spring_area = std::max(contact.state.spring_area, least);
  }
}

/// Of a contact, J.
struct Stored {
  double normal = 0.0, shear = 0.0;
};

/// Of a gap, m: the joint's opening is that of the contact.
double normal_stretch(const Joint& joint, const Contact& contact, double gap) {
  const double stretch = gap - opening(joint, contact);
  return contact.bonded ? stretch : std::min(stretch, 0.0);
}

/// `gap` (m) and `normal`: as the contact's blocks have it.
Stored stored(const JointBlocks& blocks, const Joint& joint, const Contact& contact, double gap,
              const Vector3& normal) {
  Stored energy;
  const double stretch = normal_stretch(joint, contact, gap);
  energy.normal = 0.5 * joint.normal_stiffness * contact.spring_area * stretch * stretch;
  if (contact.mode == ContactMode::Open) return energy;
  energy.shear = 0.5 * joint.shear_stiffness * contact.spring_area *
                 shear_stretch(blocks.a, blocks.b, normal, contact).squaredNorm();
  return energy;
}

void add(const Stored& one, Stored& sum) {
  sum.normal += one.normal;
  sum.shear += one.shear;
}

Stored stored(const JointBlocks& blocks, const Joint& joint, std::span<const Contact> contacts) {
  Stored sum;
  for (const Contact& contact : contacts) {
    add(stored(blocks, joint, contact, contact.point.gap, contact.point.normal), sum);
  }
  return sum;
}

Stored stored(const JointBlocks& blocks, std::span<const BodyContact> joint) {
  Stored sum;
  for (const BodyContact& contact : joint) {
    const ContactGeometry now = contact_geometry(contact, blocks.a, blocks.b);
    add(stored(blocks, *contact.joint, contact.state, now.gap, now.normal), sum);
  }
  return sum;
}

/// All normal stretches but for this share of them.
void offset_springs(const JointBlocks& blocks, double left, std::span<BodyContact> joint) {
  for (BodyContact& contact : joint) {
    const double gap = contact_geometry(contact, blocks.a, blocks.b).gap;
    contact.state.spring_offset = (1.0 - left) * normal_stretch(*contact.joint, contact.state, gap);
  }
}

void reduce_shear(const JointBlocks& blocks, double left, std::span<BodyContact> joint) {
  for (BodyContact& contact : joint) {
    Contact& state = contact.state;
    if (state.mode == ContactMode::Open) continue;
    const Vector3 normal = contact_normal(contact, blocks.a, blocks.b);
    const Vector3 stretch = shear_stretch(blocks.a, blocks.b, normal, state);
    state.anchor_b -= reference_arm(blocks.b, (1.0 - left) * stretch);
  }
}

/// Where it begins to slip: anchors are found beside each other along the pair's normal, which need
/// not be the contact's.
void level_anchors(const JointBlocks& blocks, const Vector3& normal, Contact& contact) {
  const Vector3 beside = shear_stretch(blocks.a, blocks.b, normal, contact);
  contact.anchor_b -= reference_arm(blocks.b, beside);
}

/// Of stretches that would store `now` (J) and may store `before`; none at all: 1.
double share_left(double before, double now) {
  return now > (1.0 + kSameEnergy) * before ? std::sqrt(before / now) : 1.0;
}

}  // namespace

Vector3 shear_stretch(const Pose& a, const Pose& b, const Vector3& normal, const Contact& contact) {
  const Vector3 apart = between(a, b) + (b.shape * contact.anchor_b - a.shape * contact.anchor_a);
  return apart - apart.dot(normal) * normal;
}

void set_spring_areas(const JointBlocks& blocks, std::span<BodyContact> joint) {
  double found = 0.0;
  for (const BodyContact& contact : joint) found += contact.state.point.area;
  const JointPlane plane(joint.front().state.point.normal);
  const Polygon polygon = shared_face(blocks, plane);
  const std::vector<double> shares = corner_shares(polygon);
  double area = 0.0;
  for (const double share : shares) area += share;
  const bool whole = found > 0.0 && found >= kWholeArea * area;
  for (BodyContact& contact : joint) {
    contact.state.spring_area = whole ? contact.state.point.area : 0.0;
    contact.beside_springs = whole && !(contact.state.point.area > 0.0);
  }
  if (!whole && area > 0.0) {
    share_out(polygon, shares, area, plane, blocks.a, joint);
    leave_inner_out(plane, blocks.a, joint);
  }
  raise_to_least(blocks, joint);
}

void keep_stored_energy(const JointBlocks& blocks, std::span<const Contact> before, bool dynamic,
                        std::span<BodyContact> joint) {
  for (BodyContact& contact : joint) {
    if (contact.state.mode != ContactMode::Open) continue;
    level_anchors(blocks, contact_normal(contact, blocks.a, blocks.b), contact.state);
  }
  const Stored had = stored(blocks, *joint.front().joint, before);
  const Stored now = stored(blocks, joint);
  const double normal = dynamic ? share_left(had.normal, now.normal) : 1.0;
  const double shear = dynamic ? share_left(had.shear, now.shear) : 1.0;
  if (normal < 1.0) offset_springs(blocks, normal, joint);
  if (shear < 1.0) reduce_shear(blocks, shear, joint);
  // One that is kept.
  BodyContact& part = *std::ranges::find(joint, false, &BodyContact::beside_springs);
  part.spring_loss =
      had.normal + had.shear - normal * normal * now.normal - shear * shear * now.shear;
}

void begin_spring(const JointBlocks& blocks, BodyContact& contact) {
  const ContactGeometry start = contact_geometry(contact, blocks.a, blocks.b);
  contact.state.spring_offset = std::min(start.gap, 0.0);
  level_anchors(blocks, start.normal, contact.state);
}

}  // namespace quoin::solver
