#pragma once
/// The contacts of a step with their history: who touches whom, where on the bodies, with what
/// force.

#include <span>
#include <tuple>

#include "block/block_terms.hpp"

namespace quoin::solver {

/// A contact held by the bodies: material points and a normal that turns with one of them, so that
/// gap and slip can be followed exactly through a step.
struct BodyContact {
  Contact state;               ///< forces, mode, anchors; `point` as detected
  int a = 0, b = 0;            ///< blocks
  int part_a = 0, part_b = 0;  ///< of these: ReferencePart
  bool normal_on_a = false;    ///< whose rotation carries the normal: the face's block
  bool crossed = false;        ///< two edges: the normal is that of both
  bool axis_is_y = false;      ///< axis()
  bool was_closed = false;     ///< at the end of the last step
  bool was_bonded = false;
  bool laid = false;                ///< in this step
  bool beside_springs = false;      ///< no part of its joint
  bool parted = false;              ///< in this attempt, so that it clings no more
  Vector3 arm_a = Vector3::Zero();  ///< reference arms of the contact point, m
  Vector3 arm_b = Vector3::Zero();
  /// What the normal is made from, in the turning frames of A and of B: where edges are crossed one
  /// of each, signed so that along_a × along_b is from A to B; else the normal itself, in the frame
  /// of the block that carries it.
  Vector3 along_a = Vector3::Zero(), along_b = Vector3::Zero();
  const Joint* joint = nullptr;  ///< of the scene
  double penalty_share = 1.0;    ///< of the method's spring: shared_penalty()
  double opening = 0.0;          ///< gap at which it was closed at the start of the step, m
  double spring_loss = 0.0;      ///< of the joint's springs, as areas have changed since, J

  /// Not along the normal: fixes the tangents of the step.
  Vector3 axis() const { return axis_is_y ? Vector3::UnitY() : Vector3::UnitX(); }
};

/// Reference arm of a place as seen from the centroid.
Vector3 reference_arm(const Pose& pose, const Vector3& from_centroid);

/// Joint of two blocks' materials.
const Joint& joint_between(const Scene& scene, int a, int b);

/// How a block lies, as far as joints that have no history yet are concerned.
enum Laying : char {
  kMet,    ///< what it touches it has come to: residual strength
  kLaid,   ///< in this step: what it touches has peak strength
  kStands  ///< laid, and without unknowns ever since: likewise with others that do
};

inline bool are_laid(std::span<const char> laying, int a, int b) {
  const char of_a = laying[static_cast<std::size_t>(a)], of_b = laying[static_cast<std::size_t>(b)];
  return of_a == kLaid || of_b == kLaid || (of_a == kStands && of_b == kStands);
}

struct CarryOptions {
  const Scene& scene;
  std::span<const Pose> poses;
  std::span<const BlockModel> models;
  double reach = 0.0;  ///< m: no history goes over to a contact farther away
  /// By block: Laying. A contact without history is a bond where its blocks are laid; else the two
  /// have met, with residual strength.
  std::span<const char> laid;
  bool dynamic = true;  ///< springs whose areas have changed make no energy
};

/// New list from what geometry found now, with the history of `before` handed on
/// (geometry::match_previous). Places in `found` are in the frames of the reference shapes
/// (PointFrame::Bodies): arms, gaps and levers are as good wherever the blocks stand. `previous`:
/// memory.
void carry_over(const CarryOptions& options, std::span<const geometry::ContactPoint> found,
                std::span<const Contact> before, std::vector<int>& previous,
                std::vector<BodyContact>& contacts);

/// Share of the spring of a method that one contact of its joint has: one of more than four points
/// has that of four, shared out by area. `joint_area`: of all its points, m2.
double shared_penalty(std::size_t points, double area, double joint_area);

/// What contacts of these blocks are made from.
struct PosedBlocks {
  const Scene& scene;
  std::span<const BlockModel> models;
  std::span<const Pose> poses;
};

/// The contact as held by the bodies at these poses, without history. Places of `found` as above.
BodyContact make_body_contact(const PosedBlocks& blocks, const geometry::ContactPoint& found);

/// Vectors of a contact at given poses of its two blocks.
struct ContactGeometry {
  Vector3 normal = Vector3::UnitX();
  Vector3 edge_a = Vector3::Zero(), edge_b = Vector3::Zero();    ///< of crossed edges
  Vector3 place_a = Vector3::Zero(), place_b = Vector3::Zero();  ///< from A's centroid, m
  Vector3 between = Vector3::Zero();                             ///< from A's centroid to B's, m
  Vector3 lever_b = Vector3::Zero();                             ///< from B's centroid, m
  double gap = 0.0;

  /// What double arithmetic makes of the gap: 4 eps of what goes in, m.
  double rounding() const;
};
ContactGeometry contact_geometry(const BodyContact& contact, const Pose& a, const Pose& b);
/// Where the two blocks of a contact stand.
struct PairPoses {
  const Pose &a, &b;
};
/// Edges that turn past each other in a step have a normal that turns over, whose mean is none.
/// They are crossed no more then: the normal is the pair's, as found, and turns with one block.
void uncross_turned_edges(const PairPoses& start, const PairPoses& end, BodyContact& contact);

/// Its normal alone.
Vector3 contact_normal(const BodyContact& contact, const Pose& a, const Pose& b);

/// Mean of the step, N.
Vector3 force_on_b(const Contact& contact);
void set_force_on_b(const Vector3& force, Contact& contact);

/// Of one pair of convex parts.
inline bool same_joint(const BodyContact& x, const BodyContact& y) {
  return x.a == y.a && x.b == y.b && x.part_a == y.part_a && x.part_b == y.part_b;
}

/// The order of body contacts: the joints one after the other, each by key.
inline auto joint_order(const BodyContact& contact) {
  return std::tuple(contact.a, contact.b, contact.part_a, contact.part_b, contact.state.point.key);
}

/// Calls visit(contacts) for those of each pair of convex parts: neighbours in the list.
template <class Visit>
void each_joint(std::span<BodyContact> contacts, const Visit& visit) {
  for (std::size_t first = 0, last = 0; first < contacts.size(); first = last) {
    while (last < contacts.size() && same_joint(contacts[last], contacts[first])) ++last;
    visit(contacts.subspan(first, last - first));
  }
}

}  // namespace quoin::solver
