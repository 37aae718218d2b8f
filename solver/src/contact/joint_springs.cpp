#include "contact/joint_springs.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "base/rounding.hpp"
#include "contact/joint_law.hpp"

namespace quoin::solver {
namespace {

// Chosen. Of the squared length of the smaller block (cube root of its volume), for all contacts of
// a joint: what stands on an edge or a corner beside all faces has a spring, too.
constexpr double kLeastArea = 0.01;
constexpr double kWhole = 0.999;  // of the corners' part: contacts stand at all of them

/// Where contacts do not stand at all corners each has its part of the least area.
void raise_to_least(const JointBlocks& blocks, std::span<BodyContact> joint) {
  const double length = std::cbrt(std::min(blocks.model_a.volume, blocks.model_b.volume));
  const double least = kLeastArea * length * length / static_cast<double>(joint.size());
  for (BodyContact& contact : joint)
    contact.state.spring_area = std::max(contact.state.spring_area, least);
}

/// Of a gap, m: the joint's opening is that of the contact.
double normal_stretch(const Joint& joint, const Contact& contact, double gap) {
  const double stretch = gap - opening(joint, contact);
  return contact.bonded ? stretch : std::min(stretch, 0.0);
}

/// `gap` (m) and `normal`: as the contact's blocks have it.
StoredEnergy stored(const JointBlocks& blocks, const Joint& joint, const Contact& contact,
                    double gap, const Vector3& normal) {
  StoredEnergy energy;
  const double stretch = normal_stretch(joint, contact, gap);
  energy.normal = 0.5 * joint.normal_stiffness * contact.spring_area * stretch * stretch;
  if (contact.mode == ContactMode::Open) return energy;
  energy.shear = 0.5 * joint.shear_stiffness * contact.spring_area *
                 shear_stretch(blocks.a, blocks.b, normal, contact).squaredNorm();
  return energy;
}

void add(const StoredEnergy& one, StoredEnergy& sum) {
  sum.normal += one.normal;
  sum.shear += one.shear;
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

using Kind = double StoredEnergy::*;

/// On the area that a joint has kept.
double kept(const ChangedSprings& changed, Kind kind) {
  if (!(changed.now.*kind < changed.whole.*kind)) return changed.had.*kind;
  return changed.now.*kind / (changed.whole.*kind) * changed.had.*kind;
}

double lack(const ChangedSprings& changed, Kind kind) {
  return std::max(0.0, changed.now.*kind - kept(changed, kind));
}

/// Of what joints lack, how much there is of what they had on area that is lost.
double covered(std::span<const ChangedSprings> joints, Kind kind) {
  double lost = 0.0, lacks = 0.0;
  for (const ChangedSprings& changed : joints) {
    lost += changed.had.*kind - kept(changed, kind);
    lacks += lack(changed, kind);
  }
  return lost < lacks ? lost / lacks : 1.0;
}

/// Of the stretches by the whole overlap, where `share` of what is lacking is there.
double share_left(const ChangedSprings& changed, Kind kind, double share) {
  const double now = changed.now.*kind;
  const double energy = kept(changed, kind) + share * lack(changed, kind);
  return now > (1.0 + kRelativeRounding) * energy ? std::sqrt(energy / now) : 1.0;
}

}  // namespace

Vector3 shear_stretch(const Pose& a, const Pose& b, const Vector3& normal, const Contact& contact) {
  const Vector3 apart = between(a, b) + (b.shape * contact.anchor_b - a.shape * contact.anchor_a);
  return apart - apart.dot(normal) * normal;
}

void set_spring_areas(const JointBlocks& blocks, const JointPolygon& polygon,
                      std::span<BodyContact> joint) {
  const bool spans = polygon.area > 0.0;
  const std::vector<double> shares = area_shares(blocks, polygon, kSecondDegree, joint);
  const double of_corners = std::accumulate(shares.begin(), shares.end(), 0.0);
  const bool whole = spans && of_corners > kWhole * 2.0 * kSecondDegree.corner * polygon.area;
  for (std::size_t i = 0; i < joint.size(); ++i) {
    BodyContact& contact = joint[i];
    contact.state.spring_area = spans ? shares[i] : contact.state.point.area;
    contact.beside_springs = whole && !(contact.state.spring_area > 0.0);
  }
  if (!whole) raise_to_least(blocks, joint);
}

ChangedSprings changed_springs(const JointBlocks& blocks, std::span<const Contact> before,
                               std::span<BodyContact> joint) {
  for (BodyContact& contact : joint) {
    if (contact.state.mode != ContactMode::Open) continue;
    level_anchors(blocks, contact_normal(contact, blocks.a, blocks.b), contact.state);
  }
  ChangedSprings changed{blocks, joint, {}, {}, {}};
  const Joint& law = *joint.front().joint;
  for (Contact contact : before) {
    const geometry::ContactPoint& point = contact.point;
    add(stored(blocks, law, contact, point.gap, point.normal), changed.had);
    contact.spring_offset = 0.0;
    add(stored(blocks, law, contact, point.gap, point.normal), changed.whole);
  }
  for (const BodyContact& contact : joint) {
    const ContactGeometry now = contact_geometry(contact, blocks.a, blocks.b);
    add(stored(blocks, law, contact.state, now.gap, now.normal), changed.now);
  }
  return changed;
}

void keep_stored_energy(std::span<const ChangedSprings> joints, bool dynamic) {
  constexpr Kind kNormal = &StoredEnergy::normal, kShear = &StoredEnergy::shear;
  const double of_normal = dynamic ? covered(joints, kNormal) : 1.0;
  const double of_shear = dynamic ? covered(joints, kShear) : 1.0;
  for (const ChangedSprings& changed : joints) {
    const auto& [blocks, joint, had, whole, now] = changed;
    const double normal = share_left(changed, kNormal, of_normal);
    const double shear = share_left(changed, kShear, of_shear);
    if (normal < 1.0) offset_springs(blocks, normal, joint);
    if (shear < 1.0) reduce_shear(blocks, shear, joint);
    // One that is kept.
    BodyContact& part = *std::ranges::find(joint, false, &BodyContact::beside_springs);
    part.spring_loss =
        had.normal + had.shear - normal * normal * now.normal - shear * shear * now.shear;
  }
}

void begin_spring(const JointBlocks& blocks, BodyContact& contact) {
  const ContactGeometry start = contact_geometry(contact, blocks.a, blocks.b);
  contact.state.spring_offset = std::min(start.gap, 0.0);
  level_anchors(blocks, start.normal, contact.state);
}

}  // namespace quoin::solver
