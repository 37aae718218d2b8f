#include "contact/contact_history.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/index.hpp"
#include "base/rounding.hpp"
#include "contact/joint_law.hpp"
#include "contact/joint_springs.hpp"

namespace quoin::solver {

using geometry::ContactPoint;
using geometry::FeatureKind;

Vector3 reference_arm(const Pose& pose, const Vector3& from_centroid) {
  return pose.shape.inverse() * from_centroid;
}

const Joint& joint_between(const Scene& scene, int a, int b) {
  if (!scene.block_joints.empty()) {
    const auto blocks = [](const BlockJoint& pair) { return std::pair(pair.a, pair.b); };
    const std::pair<int, int> pair = std::minmax(a, b);
    const auto own = std::ranges::lower_bound(scene.block_joints, pair, {}, blocks);
    if (own != scene.block_joints.end() && blocks(*own) == pair) return own->joint;
  }
  const int group_a = scene.blocks[index(a)].material.joint_group;
  const int group_b = scene.blocks[index(b)].material.joint_group;
  for (const PairJoint& pair : scene.pair_joints)
    if ((pair.group_a == group_a && pair.group_b == group_b) ||
        (pair.group_a == group_b && pair.group_b == group_a))
      return pair.joint;
  return scene.joint;
}

namespace {

/// Cosine above which a feature's own normal stands for the pair's (30 degrees).
constexpr double kLikeNormals = 0.866;

/// A block where it stands.
struct Posed {
  const BlockModel& model;
  const Pose& pose;
  Vector3 line(int v, int w) const {
    return pose.shape * (model.turn * (model.shape->vertex(w) - model.shape->vertex(v)));
  }
};

Vector3 edge_now(const Posed& block, int edge) {
  const auto ends = block.model.shape->topology().edge(edge);
  return block.line(ends[0], ends[1]).normalized();
}

/// Area vector of a face as it stands now, outward (Newell).
Vector3 face_normal(const Posed& block, int face) {
  const auto cycle = block.model.shape->topology().face(face);
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 2; i < cycle.size(); ++i)
    sum += block.line(cycle[0], cycle[i - 1]).cross(block.line(cycle[0], cycle[i]));
  return sum.normalized();
}

/// The last face that was asked for: contact points of a pair share it.
struct LastFace {
  int block = -1, face = -1;
  Vector3 normal = Vector3::Zero();

  const Vector3& of(const Posed& posed, int posed_block, int posed_face) {
    if (block != posed_block || face != posed_face) normal = face_normal(posed, posed_face);
    block = posed_block;
    face = posed_face;
    return normal;
  }
};

/// A vertex slides along its face, not along the pair's plane: the two differ where faces are
/// tilted.
Vector3 carried_normal(const Posed& a, const Posed& b, const BodyContact& contact, LastFace& last) {
  const ContactPoint& point = contact.state.point;
  Vector3 normal = point.normal;
  if (point.key.feature_a.kind == FeatureKind::Face)
    normal = last.of(a, contact.a, point.key.feature_a.index);
  else if (point.key.feature_b.kind == FeatureKind::Face)
    normal = -last.of(b, contact.b, point.key.feature_b.index);
  return normal.dot(point.normal) > kLikeNormals ? normal : point.normal;
}

/// Below this sine of their angle the edges say less about the normal than the pair's own.
constexpr double kLeastCrossing = 0.02;

void set_crossed_edges(const Posed& a, const Posed& b, BodyContact& contact) {
  const geometry::ContactKey& key = contact.state.point.key;
  if (key.feature_a.kind != FeatureKind::Edge || key.feature_b.kind != FeatureKind::Edge) return;
  Vector3 edge_a = edge_now(a, key.feature_a.index);
  const Vector3 edge_b = edge_now(b, key.feature_b.index);
  const Vector3 normal = edge_a.cross(edge_b);
  const double along = normal.dot(contact.state.point.normal);
  if (normal.norm() < kLeastCrossing || std::abs(along) < kLikeNormals * normal.norm()) return;
  if (along < 0.0) edge_a = -edge_a;
  contact.crossed = true;
  contact.along_a = a.pose.rotation.transpose() * edge_a;
  contact.along_b = b.pose.rotation.transpose() * edge_b;
}

BodyContact make_contact(const PosedBlocks& blocks, const ContactPoint& found, LastFace& last) {
  BodyContact contact;
  ContactPoint& point = contact.state.point;
  point = found;
  contact.a = point.key.a;
  contact.b = point.key.b;
  contact.part_a = part_of(blocks.models[index(contact.a)], point.key.feature_a);
  contact.part_b = part_of(blocks.models[index(contact.b)], point.key.feature_b);
  const auto posed = [&](int block) {
    const std::size_t b = index(block);
    return Posed{blocks.models[b], blocks.poses[b]};
  };
  const Posed a = posed(contact.a), b = posed(contact.b);
  contact.arm_a = a.model.turn * found.point_a;
  contact.arm_b = b.model.turn * found.point_b;
  point.point_a = a.pose.centroid + a.pose.shape * contact.arm_a;
  point.point_b = b.pose.centroid + b.pose.shape * contact.arm_b;
  contact.state.anchor_a = contact.arm_a;
  contact.state.anchor_b = contact.arm_b;
  contact.normal_on_a =
      point.key.feature_a.kind == FeatureKind::Face ||
      (point.key.feature_b.kind != FeatureKind::Face && a.model.kind >= BlockKind::Fixed);
  const Pose& owner = contact.normal_on_a ? a.pose : b.pose;
  (contact.normal_on_a ? contact.along_a : contact.along_b) =
      owner.rotation.transpose() * carried_normal(a, b, contact, last);
  set_crossed_edges(a, b, contact);
  contact.axis_is_y = !(std::abs(point.normal.x()) < 0.75);
  contact.joint = &joint_between(blocks.scene, contact.a, contact.b);
  return contact;
}

double smaller_size(const CarryOptions& options, const BodyContact& contact) {
  return std::min(options.models[index(contact.a)].size, options.models[index(contact.b)].size);
}

// Of a block: corners of a joint that near are one.
constexpr double kOneCorner = 1e-6;

/// Whether a contact is held where it was: in statics a crossing of sides that nearly meet may go
/// far from there, and its force with it. Moving blocks would gain energy by that.
bool stays(const CarryOptions& options, const Contact& before, const BodyContact& contact) {
  if (before.point.key != contact.state.point.key) return false;
  const double away =
      std::min((before.anchor_a - contact.arm_a).norm(), (before.anchor_b - contact.arm_b).norm());
  return options.dynamic || away <= kOneCorner * smaller_size(options, contact);
}

/// Hands the history on. The stretch of a stuck contact (place of anchor b minus that of anchor a)
/// goes over to the new contact point, so that neither a new key nor a moved projection loses it.
void hand_on(const Contact& before, const CarryOptions& options, BodyContact& contact) {
  Contact& state = contact.state;
  const Vector3& normal = state.point.normal;
  contact.was_closed = before.mode != ContactMode::Open;
  state.mode = before.mode;
  state.normal_force = before.normal_force;
  state.shear_force = before.shear_force - before.shear_force.dot(normal) * normal;
  state.next_normal_force = before.next_normal_force;
  state.next_shear_force = before.next_shear_force - before.next_shear_force.dot(normal) * normal;
  state.impact = before.impact;
  state.slip = before.slip;
  state.failed = before.failed;
  state.bonded = before.bonded;
  state.closed_gap = before.closed_gap;
  if (!contact.was_closed) return;
  if (stays(options, before, contact)) {
    state.anchor_a = before.anchor_a;
    state.anchor_b = before.anchor_b;
    return;
  }
  const Pose &a = options.poses[index(contact.a)], &b = options.poses[index(contact.b)];
  state.anchor_b = contact.arm_b + reference_arm(b, shear_stretch(a, b, normal, before));
}

/// Whether two contacts of one pair lie between the same parts.
bool same_parts(const CarryOptions& options, const Contact& before, const BodyContact& contact) {
  const geometry::ContactKey& key = before.point.key;
  return part_of(options.models[index(contact.a)], key.feature_a) == contact.part_a &&
         part_of(options.models[index(contact.b)], key.feature_b) == contact.part_b;
}

/// Where flush parts meet, a point of other parts stands as near as its own: it hands on nothing to
/// one of another normal.
bool hands_on(const CarryOptions& options, const Contact& before, const BodyContact& contact) {
  return same_parts(options, before, contact) ||
         before.point.normal.dot(contact.state.point.normal) > kLikeNormals;
}

void start_history(const CarryOptions& options, BodyContact& contact) {
  if (!are_laid(options.laid, contact.a, contact.b)) {
    contact.state.failed = true;
    return;
  }
  lay(*contact.joint, smaller_size(options, contact), contact.state);
  contact.was_closed = contact.state.bonded;
  contact.laid = true;
}

double area_of(std::span<const BodyContact> joint) {
  double area = 0.0;
  for (const BodyContact& contact : joint) area += contact.state.point.area;
  return area;
}

/// Of those of all, sorted by pair.
std::span<const Contact> of_pair(std::span<const Contact> contacts, const BodyContact& contact) {
  const auto pair = [](const Contact& c) { return std::pair(c.point.key.a, c.point.key.b); };
  const auto found = std::ranges::equal_range(contacts, std::pair(contact.a, contact.b), {}, pair);
  return {found.begin(), found.end()};
}

/// Of the contacts of one joint among those of all, sorted by pair. `kept`: memory for them where
/// they do not stand together.
std::span<const Contact> of_joint(const CarryOptions& options, std::span<const Contact> contacts,
                                  const BodyContact& contact, std::vector<Contact>& kept) {
  const std::span<const Contact> all = of_pair(contacts, contact);
  if (!options.models[index(contact.a)].parts && !options.models[index(contact.b)].parts)
    return all;
  std::ranges::copy_if(all, std::back_inserter(kept),
                       [&](const Contact& c) { return same_parts(options, c, contact); });
  return kept;
}

JointBlocks blocks_of(const CarryOptions& options, const BodyContact& contact) {
  const std::size_t a = index(contact.a), b = index(contact.b);
  return {options.models[a], options.models[b], options.poses[a], options.poses[b]};
}

/// A strip as narrow as places are rounded is an edge.
double edge_area(const CarryOptions& options, const BodyContact& contact) {  // m2
  const double size = smaller_size(options, contact);
  return kRelativeRounding * size * size;
}

/// The integration points of a joint that acts by area: what was found of it, and inner points,
/// which are appended.
void set_integration_points(const CarryOptions& options, std::span<BodyContact> joint,
                            std::vector<BodyContact>& inner) {
  const BodyContact& first = joint.front();
  if (!acts_by_area(*first.joint)) return;
  const JointBlocks blocks = blocks_of(options, first);
  const JointPolygon polygon = joint_polygon(blocks, first);
  const bool faces = polygon.area > 0.0 && area_of(joint) > edge_area(options, first);
  const bool springs = first.joint->normal_stiffness > 0.0;
  if (springs) set_spring_areas(blocks, polygon, joint);
  std::vector<BodyContact> points;
  for (const ContactPoint& point : inner_points(blocks, polygon, joint, options.reach))
    points.push_back(make_body_contact({options.scene, options.models, options.poses}, point));
  const auto each = [&](const AreaRule& rule, std::span<BodyContact> contacts, const auto& set) {
    const std::vector<double> shares = area_shares(blocks, polygon, rule, contacts);
    for (std::size_t i = 0; i < contacts.size(); ++i) set(contacts[i].state, shares[i]);
  };
  const auto set_spring = [](Contact& contact, double share) { contact.spring_area = share; };
  const auto set_area = [](Contact& contact, double share) { contact.point.area = share; };
  if (springs) each(kSecondDegree, points, set_spring);
  const AreaRule rule = strength_rule(*first.joint, polygon);
  if (faces) each(rule, joint, set_area);
  if (faces) each(rule, points, set_area);
  std::ranges::move(points, std::back_inserter(inner));
}

/// Of all joints that act by area; false: there are none. `contacts`: sorted by key.
bool add_integration_points(const CarryOptions& options, std::vector<BodyContact>& contacts) {
  const auto by_area = [](const BodyContact& contact) { return acts_by_area(*contact.joint); };
  if (std::ranges::none_of(contacts, by_area)) return false;
  std::ranges::sort(contacts, {}, joint_order);
  std::vector<BodyContact> inner;
  each_joint(contacts,
             [&](std::span<BodyContact> joint) { set_integration_points(options, joint, inner); });
  std::ranges::move(inner, std::back_inserter(contacts));
  std::ranges::sort(contacts, {}, [](const BodyContact& c) { return c.state.point.key; });
  return true;
}

// Times as far off as another: the key now names another place. And times as far off as faces have
// moved on each other: a corner where there was none, of which two sides that nearly meet make two.
constexpr double kElsewhere = 10.0;

/// Corners of joints that act by area take the history of their place, not that of their key. Two
/// nearly equal sides cross now at one end and now at the other, with the same key; where corners
/// of both faces meet, the joint's corner has the key of either.
void stay_in_place(std::span<const BodyContact> contacts, const CarryOptions& options,
                   std::span<const Contact> before, std::vector<int>& previous) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const BodyContact& contact = contacts[i];
    if (!acts_by_area(*contact.joint) || is_inner(contact.state.point.key)) continue;
    const Pose &a = options.poses[index(contact.a)], &b = options.poses[index(contact.b)];
    const auto away = [&](const Contact& c) { return (c.anchor_a - contact.arm_a).norm(); };
    const double near = kOneCorner * smaller_size(options, contact);
    const bool known = previous[i] >= 0 && hands_on(options, before[index(previous[i])], contact);
    double own = known ? away(before[index(previous[i])]) : std::numeric_limits<double>::infinity();
    if (own <= near) continue;
    for (const Contact& c : of_pair(before, contact)) {
      const Vector3 moved = between(a, b) + (b.shape * c.anchor_b - a.shape * c.anchor_a);
      const double farthest = known ? own / kElsewhere : kElsewhere * (near + moved.norm());
      if (is_inner(c.point.key) || !hands_on(options, c, contact)) continue;
      if (away(c) < std::min(own, farthest)) {
        previous[i] = static_cast<int>(&c - before.data());
        own = away(c);
      }
    }
  }
}

/// An inner point that comes to a closed joint, as one of a law that is given later, has the state
/// of the corner next to it.
void take_over_corners(const CarryOptions& options, std::span<BodyContact> joint) {
  const auto known = [](const BodyContact& c) {
    return c.state.point.previous >= 0 && !is_inner(c.state.point.key);
  };
  if (std::ranges::none_of(joint, known)) return;
  for (BodyContact& contact : joint) {
    Contact& state = contact.state;
    if (!is_inner(state.point.key) || state.point.previous >= 0 || contact.laid) continue;
    const BodyContact& corner = *std::ranges::min_element(joint, {}, [&](const BodyContact& c) {
      if (!known(c)) return std::numeric_limits<double>::infinity();
      return (c.arm_a - contact.arm_a).squaredNorm();
    });
    const double none = kRelativeRounding * smaller_size(options, contact);
    if (!(state.point.gap <= corner.state.point.gap + none)) continue;
    contact.was_closed = corner.was_closed;
    contact.was_bonded = corner.was_bonded;
    state.mode = corner.state.mode;
    state.failed = corner.state.failed;
    state.bonded = corner.state.bonded;
    state.slip = corner.state.slip;
    state.closed_gap = corner.state.closed_gap;
  }
}

/// Springs of the joint as the blocks stand; those of one that is laid have nothing stored yet.
void note_springs(const CarryOptions& options, std::span<const Contact> before,
                  std::span<BodyContact> joint, std::vector<ChangedSprings>& changed) {
  const BodyContact& first = joint.front();
  if (!(first.joint->normal_stiffness > 0.0)) return;
  if (std::ranges::any_of(joint, &BodyContact::laid)) return;
  std::vector<Contact> kept;
  changed.push_back(
      changed_springs(blocks_of(options, first), of_joint(options, before, first, kept), joint));
}

/// Faces that a joint has opened, by dilation or where a block rocks, are parallel no more, and
/// what touches is an edge or a vertex of one of them: strength goes by what the faces share. What
/// has never been part of an area has none, nor has the strip that rounding makes of an edge.
void keep_areas(const CarryOptions& options, std::span<const Contact> before,
                std::span<BodyContact> joint) {
  const Joint& law = *joint.front().joint;
  if (!(std::max({law.cohesion, law.residual_cohesion, law.tension}) > 0.0)) return;
  const double none = edge_area(options, joint.front());
  const auto lost = [&](const BodyContact& contact) {
    const ContactPoint& point = contact.state.point;
    return point.previous >= 0 && !(point.area > none) &&
           before[index(point.previous)].point.area > none;
  };
  if (std::ranges::none_of(joint, lost)) return;
  const JointBlocks blocks = blocks_of(options, joint.front());
  const JointPolygon polygon = joint_polygon(blocks, joint.front());
  const auto shares = area_shares(blocks, polygon, strength_rule(law, polygon), joint);
  for (std::size_t i = 0; i < joint.size(); ++i)
    if (lost(joint[i])) joint[i].state.point.area = shares[i];
}

void share_penalty(std::span<BodyContact> joint) {
  const double area = area_of(joint);
  for (BodyContact& contact : joint)
    contact.penalty_share = shared_penalty(joint.size(), contact.state.point.area, area);
}

geometry::ContactPointList points_of(const std::vector<BodyContact>& contacts) {
  return {contacts.data(), contacts.size(),
          [](const void* owner, std::size_t i) -> const ContactPoint& {
            return static_cast<const BodyContact*>(owner)[i].state.point;
          }};
}

geometry::ContactPointList points_of(std::span<const Contact> contacts) {
  return {contacts.data(), contacts.size(),
          [](const void* owner, std::size_t i) -> const ContactPoint& {
            return static_cast<const Contact*>(owner)[i].point;
          }};
}

/// By one of the blocks, at these poses.
Vector3 turned_normal(const BodyContact& contact, const Pose& a, const Pose& b) {
  return contact.normal_on_a ? a.rotation * contact.along_a : b.rotation * contact.along_b;
}

}  // namespace

double shared_penalty(std::size_t points, double area, double joint_area) {
  constexpr std::size_t kCorners = 4;
  if (points <= kCorners) return 1.0;
  return kCorners * (area > 0.0 ? area / joint_area : 1.0 / static_cast<double>(points));
}

BodyContact make_body_contact(const PosedBlocks& blocks, const ContactPoint& found) {
  LastFace last;
  return make_contact(blocks, found, last);
}

void carry_over(const CarryOptions& options, std::span<const ContactPoint> found,
                std::span<const Contact> before, std::vector<int>& previous,
                std::vector<BodyContact>& contacts) {
  const PosedBlocks blocks{options.scene, options.models, options.poses};
  LastFace last;
  contacts.clear();
  contacts.reserve(found.size());
  for (const ContactPoint& point : found) contacts.push_back(make_contact(blocks, point, last));
  const bool by_area = add_integration_points(options, contacts);
  geometry::match_previous(points_of(contacts), points_of(before), options.reach, previous);
  if (by_area) stay_in_place(contacts, options, before, previous);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    BodyContact& contact = contacts[i];
    contact.state.point.previous = previous[i];
    if (previous[i] >= 0 && hands_on(options, before[index(previous[i])], contact))
      hand_on(before[index(previous[i])], options, contact);
    else
      start_history(options, contact);
    contact.was_bonded = contact.state.bonded;
  }
  const auto has_parts = [](const BodyContact& c) { return c.part_a != 0 || c.part_b != 0; };
  if (std::ranges::any_of(contacts, has_parts)) std::ranges::sort(contacts, {}, joint_order);
  std::vector<ChangedSprings> changed;
  each_joint(contacts, [&](std::span<BodyContact> joint) {
    if (by_area) take_over_corners(options, joint);
    note_springs(options, before, joint, changed);
    keep_areas(options, before, joint);
  });
  keep_stored_energy(changed, options.dynamic);
  std::erase_if(contacts, [](const BodyContact& contact) { return contact.beside_springs; });
  for (BodyContact& contact : contacts) contact.opening = opening(*contact.joint, contact.state);
  each_joint(contacts, share_penalty);
}

ContactGeometry contact_geometry(const BodyContact& contact, const Pose& a, const Pose& b) {
  ContactGeometry result;
  if (contact.crossed) {
    result.edge_a = a.rotation * contact.along_a;
    result.edge_b = b.rotation * contact.along_b;
    result.normal = result.edge_a.cross(result.edge_b).normalized();
  } else {
    result.normal = turned_normal(contact, a, b);
  }
  result.between = between(a, b);
  result.place_a = a.shape * contact.arm_a;
  result.lever_b = b.shape * contact.arm_b;
  result.place_b = result.between + result.lever_b;
  result.gap = (result.place_b - result.place_a).dot(result.normal);
  return result;
}

void uncross_turned_edges(const PairPoses& start, const PairPoses& end, BodyContact& contact) {
  if (!contact.crossed) return;
  const Vector3 before = contact_normal(contact, start.a, start.b);
  const Vector3 after = contact_normal(contact, end.a, end.b);
  if (before.dot(after) > 0.0) return;
  const Vector3& found = contact.state.point.normal;
  const PairPoses& at = found.dot(before) < found.dot(after) ? end : start;
  contact.crossed = false;
  Vector3& along = contact.normal_on_a ? contact.along_a : contact.along_b;
  along = (contact.normal_on_a ? at.a : at.b).rotation.transpose() * found;
}

Vector3 contact_normal(const BodyContact& contact, const Pose& a, const Pose& b) {
  if (!contact.crossed) return turned_normal(contact, a, b);
  const Vector3 edge_a = a.rotation * contact.along_a, edge_b = b.rotation * contact.along_b;
  return edge_a.cross(edge_b).normalized();
}

double ContactGeometry::rounding() const {
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  return 4.0 * kEpsilon * (between.norm() + place_a.norm() + lever_b.norm());
}

Vector3 force_on_b(const Contact& contact) {
  return contact.normal_force * contact.point.normal - contact.shear_force;
}

void set_force_on_b(const Vector3& force, Contact& contact) {
  contact.normal_force = force.dot(contact.point.normal);
  contact.shear_force = contact.normal_force * contact.point.normal - force;
}

}  // namespace quoin::solver
