#include "contact/joint_area.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/rounding.hpp"

namespace quoin::solver {
namespace {

using Eigen::Vector2d;
using geometry::Feature;
using geometry::FeatureKind;
using Corner = JointPolygon::Corner;
using Corners = std::vector<Corner>;

// Of the side of a square of the joint's area: a corner farther from all contacts is lifted.
// Chosen: less than a brick's short side.
constexpr double kNearCorner = 0.3;
constexpr double kAtCorner = 0.9;  // what a contact at a corner has left of it, at least
constexpr double kNoSide = 1e-6;   // of the longest: what that makes of corners is shorter

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

/// That at its foremost vertex which faces most.
JointFace foremost_face(const SeenBlock& block, const Vector3& way) {
  const geometry::Topology& topology = block.model.shape->topology();
  const auto faces = topology.vertex_faces(farthest_vertex(block, way));
  JointFace seen;
  seen.face = *std::ranges::max_element(faces, {}, [&](int f) { return way.dot(block.normal(f)); });
  const auto cycle = topology.face(seen.face);
  const Vector3 first = block.vertex(cycle[0]);
  Vector3 last = first;
  for (const int v : cycle) {
    const Vector3 place = block.vertex(v);
    seen.middle += place / static_cast<double>(cycle.size());
    seen.normal += (last - first).cross(place - first);
    last = place;
  }
  return seen;
}

Corners corners_of(const SeenBlock& block, const JointPlane& plane, int face, bool of_b) {
  const geometry::Topology& topology = block.model.shape->topology();
  const auto cycle = topology.face(face), edges = topology.face_edges(face);
  Corners corners;
  for (std::size_t i = 0; i < cycle.size(); ++i)
    corners.push_back({plane(block.vertex(cycle[i])), of_b, edges[i]});
  return corners;
}

/// The part of a polygon to the left of the line from `line` to q.
Corners left_of(const Corners& polygon, const Corner& line, const Vector2d& q) {
  Corners part;
  const Vector2d& p = line.place;
  const double least = -kRelativeRounding * (q - p).squaredNorm();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Corner &here = polygon[i], &next = polygon[(i + 1) % polygon.size()];
    const double left = cross(q - p, here.place - p), left_next = cross(q - p, next.place - p);
    if (left >= least) part.push_back(here);
    if ((left >= least) == (left_next >= least)) continue;
    const double at = std::clamp(left / (left - left_next), 0.0, 1.0);
    Corner& crossing = part.emplace_back(left >= least ? line : here);
    crossing.place = here.place + at * (next.place - here.place);
  }
  return part;
}

/// Without sides and corners that are none: of sides that lie over each other, and cross by
/// rounding.
Corners without_straight(const Corners& polygon) {
  const auto side = [](const Corners& of, std::size_t i) -> Vector2d {
    return of[(i + 1) % of.size()].place - of[i].place;
  };
  double longest = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    longest = std::max(longest, side(polygon, i).norm());
  Corners sides, corners;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    if (side(polygon, i).norm() > kNoSide * longest) sides.push_back(polygon[i]);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const Vector2d& before = corners.empty() ? sides.back().place : corners.back().place;
    const Vector2d to = sides[i].place - before, from = side(sides, i);
    if (cross(to, from) > kStraight * to.norm() * from.norm()) corners.push_back(sides[i]);
  }
  return corners;
}

void set_triangles(JointPolygon& polygon) {
  const Corners& corners = polygon.corners;
  Vector2d moment = Vector2d::Zero();
  for (std::size_t i = 2; i < corners.size(); ++i) {
    const Vector2d &first = corners[0].place, &p = corners[i - 1].place, &q = corners[i].place;
    const double part = 0.5 * cross(p - first, q - first);
    polygon.area += part;
    moment += part / 3.0 * (first + p + q);
  }
  if (!(polygon.area > 0.0)) {
    polygon.area = 0.0;
    polygon.corners.clear();
    return;
  }
  polygon.centroid = moment / polygon.area;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector2d p = corners[i].place - polygon.centroid;
    const Vector2d q = corners[(i + 1) % corners.size()].place - polygon.centroid;
    polygon.triangles.push_back(0.5 * cross(p, q));
  }
}

/// The contact nearest to a corner, and what it has left of its part.
struct NearContact {
  std::size_t contact = 0;
  double left = 0.0;
};

/// By corner. A corner that parts from another, as an edge slides over it, takes its part along
/// without a jump.
std::vector<NearContact> near_contacts(const JointBlocks& blocks, const JointPolygon& polygon,
                                       std::span<const BodyContact> joint) {
  const double reach = kNearCorner * std::sqrt(polygon.area);
  std::vector<NearContact> near;
  for (const Corner& corner : polygon.corners) {
    const auto distance = [&](const BodyContact& contact) {
      if (is_inner(contact.state.point.key)) return std::numeric_limits<double>::infinity();
      return (polygon.plane(blocks.a.shape * contact.arm_a) - corner.place).norm();
    };
    const auto nearest = std::ranges::min_element(joint, {}, distance);
    near.push_back({static_cast<std::size_t>(nearest - joint.begin()),
                    std::max(0.0, 1.0 - distance(*nearest) / reach)});
  }
  return near;
}

/// Features of the inner point at the side from a corner.
std::pair<Feature, Feature> inner_features(const JointPolygon& polygon, const Corner& corner) {
  const Feature edge{FeatureKind::Edge, corner.edge};
  if (corner.of_b) return {{FeatureKind::Face, polygon.a.face}, edge};
  return {edge, {FeatureKind::Face, polygon.b.face}};
}

/// Of the plane of a face, along the joint's normal, m.
double plane_height(const JointFace& face, const JointPlane& plane, const Vector2d& at) {
  const Vector3 place = at.x() * plane.u + at.y() * plane.v;
  return face.normal.dot(face.middle - place) / face.normal.dot(plane.normal);
}

double plane_gap(const JointPolygon& polygon, const Vector2d& at) {
  return plane_height(polygon.b, polygon.plane, at) - plane_height(polygon.a, polygon.plane, at);
}

/// By corner, and last their mean: by how much contacts there have another gap than the faces'
/// planes, as the depth that a pair was laid with is none.
std::vector<double> gap_changes(const JointBlocks& blocks, const JointPolygon& polygon,
                                std::span<const BodyContact> joint) {
  const std::vector<NearContact> near = near_contacts(blocks, polygon, joint);
  const double none = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> changes;
  double sum = 0.0, count = 0.0;
  for (const NearContact& one : near) {
    const BodyContact& contact = joint[one.contact];
    const Vector2d at = polygon.plane(blocks.a.shape * contact.arm_a);
    const bool known = one.left > kAtCorner;
    changes.push_back(known ? contact.state.point.gap - plane_gap(polygon, at) : none);
    if (!known) continue;
    sum += changes.back();
    count += 1.0;
  }
  const double mean = count > 0.0 ? sum / count : 0.0;
  for (double& change : changes) change = std::isnan(change) ? mean : change;
  changes.push_back(mean);
  return changes;
}

}  // namespace

std::vector<Vector2d> core(const JointPolygon& polygon) {
  std::vector<Vector2d> places, result;
  for (const Corner& corner : polygon.corners) places.push_back(corner.place);
  const std::optional<JointSection> section = joint_section(places);
  if (!section) return result;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Vector2d& p = places[i];
    const Vector2d side = (places[(i + 1) % places.size()] - p).normalized();
    const Vector2d outwards(side.y(), -side.x());
    const double distance = outwards.dot(p - section->centroid);
    result.push_back(section->centroid -
                     section->second_moment * outwards / (section->area * distance));
  }
  return result;
}

JointPolygon joint_polygon(const JointBlocks& blocks, const BodyContact& contact) {
  const SeenBlock a{blocks.model_a, blocks.a, contact.part_a, Vector3::Zero()};
  const SeenBlock b{blocks.model_b, blocks.b, contact.part_b, between(blocks.a, blocks.b)};
  JointPolygon polygon{.plane = JointPlane(contact.state.point.normal)};
  const JointPlane& plane = polygon.plane;
  polygon.a = foremost_face(a, plane.normal);
  polygon.b = foremost_face(b, -plane.normal);
  Corners shared = corners_of(a, plane, polygon.a.face, false);
  const Corners other = corners_of(b, plane, polygon.b.face, true);
  for (std::size_t i = other.size(); i-- > 0 && !shared.empty();) {  // seen from behind
    Corner line = other[i];
    line.place = other[(i + 1) % other.size()].place;
    shared = left_of(shared, line, other[i].place);
  }
  polygon.corners = without_straight(shared);
  set_triangles(polygon);
  return polygon;
}

AreaRule cohesion_rule(const JointPolygon& polygon) {
  if (!(polygon.area > 0.0)) return kSecondDegree;
  std::vector<Vector2d> places;
  double of_corners = 0.0, of_inner = 0.0;  // integrals of the distance: corners alone, inner alone
  for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
    const std::size_t next = (i + 1) % polygon.corners.size();
    const Vector2d p = polygon.corners[i].place - polygon.centroid;
    const Vector2d q = polygon.corners[next].place - polygon.centroid;
    of_corners += polygon.triangles[i] * 0.5 * (p.norm() + q.norm());
    of_inner += polygon.triangles[i] * kInner * 0.5 * (p + q).norm();
    places.push_back(polygon.corners[i].place);
  }
  const double exact = polygon.area * mean_distance(places, polygon.centroid);
  const double corner = std::clamp((exact - of_inner) / (of_corners - of_inner), 0.0, 1.0);
  return {0.5 * corner, 1.0 - corner};
}

AreaRule strength_rule(const Joint& joint, const JointPolygon& polygon) {
  if (!acts_by_area(joint)) return kCornersAlone;
  const bool coheres = joint.cohesion > 0.0 || joint.residual_cohesion > 0.0;
  // On springs even shear is to reach the strength of all points at once, which then soften.
  const bool softens = joint.softening_slip > 0.0 && joint.normal_stiffness > 0.0;
  return coheres && !softens ? cohesion_rule(polygon) : kSecondDegree;
}

std::vector<double> area_shares(const JointBlocks& blocks, const JointPolygon& polygon,
                                const AreaRule& rule, std::span<const BodyContact> joint) {
  std::vector<double> shares(joint.size(), 0.0);
  if (joint.empty()) return shares;
  const std::vector<NearContact> near = near_contacts(blocks, polygon, joint);
  for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
    const std::size_t next = (i + 1) % polygon.corners.size();
    for (const NearContact& at : {near[i], near[next]})
      shares[at.contact] += at.left * rule.corner * polygon.triangles[i];
    const auto features = inner_features(polygon, polygon.corners[i]);
    for (std::size_t k = 0; k < joint.size(); ++k) {
      const geometry::ContactKey& key = joint[k].state.point.key;
      if (std::pair(key.feature_a, key.feature_b) != features) continue;
      shares[k] += rule.inner * polygon.triangles[i];
    }
  }
  return shares;
}

std::vector<geometry::ContactPoint> inner_points(const JointBlocks& blocks,
                                                 const JointPolygon& polygon,
                                                 std::span<const BodyContact> corners,
                                                 double reach) {
  std::vector<geometry::ContactPoint> points;
  if (!(polygon.area > 0.0)) return points;
  const std::vector<double> changes = gap_changes(blocks, polygon, corners);
  const JointPlane& plane = polygon.plane;
  const auto in_shape = [](const BlockModel& model, const Pose& pose, const Vector3& place) {
    return Vector3(model.turn.transpose() * reference_arm(pose, place));
  };
  for (std::size_t i = 0, n = polygon.corners.size(); i < n; ++i) {
    const std::size_t next = (i + 1) % n;
    const Vector2d side = 0.5 * (polygon.corners[i].place + polygon.corners[next].place);
    const Vector2d at = polygon.centroid + kInner * (side - polygon.centroid);
    const double change = 0.5 * kInner * (changes[i] + changes[next]) + (1.0 - kInner) * changes[n];
    geometry::ContactPoint point = corners.front().state.point;
    point.gap = plane_gap(polygon, at) + change;
    if (!(point.gap <= reach)) continue;
    std::tie(point.key.feature_a, point.key.feature_b) =
        inner_features(polygon, polygon.corners[i]);
    const double on_b = plane_height(polygon.b, plane, at);
    const Vector3 place = at.x() * plane.u + at.y() * plane.v;
    point.point_a = in_shape(blocks.model_a, blocks.a, place + (on_b - point.gap) * plane.normal);
    point.point_b = in_shape(blocks.model_b, blocks.b,
                             place + on_b * plane.normal - between(blocks.a, blocks.b));
    point.previous = -1;
    point.area = 0.0;
    points.push_back(point);
  }
  return points;
}

namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

/// Of their convex hull, counter-clockwise: arms from `middle`.
std::vector<Vector2d> around(std::span<const Vector2d> places, const Vector2d& middle) {
  std::vector<Vector2d> arms, hull;
  for (const Vector2d& place : places) arms.push_back(place - middle);
  std::ranges::sort(arms, {}, [](const Vector2d& p) { return std::pair(p.x(), p.y()); });
  for (const bool back : {false, true}) {  // below, then above
    const std::size_t first = hull.size() + 1;
    for (const Vector2d& arm : arms) {
      while (hull.size() > first &&
             !(cross(hull.back() - hull[hull.size() - 2], arm - hull.back()) > 0.0))
        hull.pop_back();
      hull.push_back(arm);
    }
    hull.pop_back();  // the other one begins with it
    if (!back) std::ranges::reverse(arms);
  }
  return hull;
}

}  // namespace

std::optional<JointSection> joint_section(std::span<const Vector2d> places) {
  if (places.size() < 3) return std::nullopt;
  Vector2d middle = Vector2d::Zero();
  for (const Vector2d& place : places) middle += place / static_cast<double>(places.size());
  const std::vector<Vector2d> arms = around(places, middle);
  JointSection section;
  Vector2d first = Vector2d::Zero();
  Matrix2d second = Matrix2d::Zero();
  double radius = 0.0;
  for (std::size_t i = 0; i < arms.size(); ++i) {
    // The triangle of the middle and one side.
    const Vector2d &p = arms[i], &q = arms[(i + 1) % arms.size()];
    const double area = 0.5 * cross(p, q);
    const Vector2d sum = p + q;
    section.area += area;
    first += area / 3.0 * sum;
    second += area / 12.0 * (p * p.transpose() + q * q.transpose() + sum * sum.transpose());
    radius = std::max(radius, p.norm());
  }
  if (!(section.area > kRelativeRounding * radius * radius)) return std::nullopt;
  const Vector2d centroid = first / section.area;
  section.centroid = middle + centroid;
  section.second_moment = second - section.area * centroid * centroid.transpose();
  return section;
}

double mean_distance(std::span<const Vector2d> places, const Vector2d& from) {
  double distance = 0.0, area = 0.0;
  Vector2d middle = Vector2d::Zero();
  for (const Vector2d& place : places) middle += place / static_cast<double>(places.size());
  const std::vector<Vector2d> arms = around(places, middle);
  for (std::size_t i = 0; i < arms.size(); ++i) {  // the triangle of the place and one side
    const Vector2d p = middle + arms[i] - from, q = middle + arms[(i + 1) % arms.size()] - from;
    const Vector2d side = (q - p).normalized();
    const double height = cross(p, side);  // of it, on its side
    area += 0.5 * cross(p, q);
    if (height == 0.0) continue;
    const auto integral = [&](double s) {  // of the distance along the side
      return 0.5 * (s * std::hypot(height, s) + height * height * std::asinh(s / std::abs(height)));
    };
    distance += height / 3.0 * (integral(q.dot(side)) - integral(p.dot(side)));
  }
  return distance / area;
}

std::vector<double> section_stress(const JointSection& section, std::span<const Vector2d> places,
                                   std::span<const double> pull) {
  double force = 0.0;
  Vector2d moment = Vector2d::Zero();
  for (std::size_t i = 0; i < places.size(); ++i) {
    force += pull[i];
    moment += pull[i] * (places[i] - section.centroid);
  }
  const Vector2d gradient = section.second_moment.inverse() * moment;
  std::vector<double> stress;
  for (const Vector2d& place : places)
    stress.push_back(force / section.area + gradient.dot(place - section.centroid));
  return stress;
}

}  // namespace quoin::solver
