#include "contact/joint_failure.hpp"

#include <algorithm>
#include <cmath>

#include "contact/contact_jacobian.hpp"
#include "contact/joint_law.hpp"
#include "contact/joint_section.hpp"

namespace quoin::solver {
namespace {

using Eigen::Vector2d;

constexpr double kStressRounding = 1e-9;  // of the strength: forces are as good as that

/// The contacts of one pair.
struct SolvedJoint {
  std::span<BodyContact> contacts;
  std::span<const LinearContact> linear;
};

/// Place of a contact in the plane of its joint, m.
Vector2d in_plane(const BodyContact& contact, const Vector3& normal) {
  Vector3 t1, t2;
  tangent_frame(contact, normal, t1, t2);
  const Vector3 place = contact.state.point.point();
  return {t1.dot(place), t2.dot(place)};
}

bool part_where_overloaded(const SolvedJoint& joint) {
  const Vector3& normal = joint.contacts.front().state.point.normal;
  std::vector<std::size_t> bonded;
  std::vector<Vector2d> corners;
  std::vector<double> pull;
  for (std::size_t i = 0; i < joint.contacts.size(); ++i) {
    if (!joint.contacts[i].state.bonded) continue;
    bonded.push_back(i);
    corners.push_back(in_plane(joint.contacts[i], normal));
    pull.push_back(-joint.linear[i].force[0]);
  }
  if (bonded.empty()) return false;
  const std::optional<JointSection> section = joint_section(corners);
  std::vector<double> stress;
  if (section) stress = section_stress(*section, corners, pull);
  bool any = false;
  for (std::size_t k = 0; k < bonded.size(); ++k) {
    BodyContact& contact = joint.contacts[bonded[k]];
    const double tension = strength(contact.joint, contact.state).tension;
    if (section && !(stress[k] > (1.0 + kStressRounding) * tension)) continue;
    weaken(contact.joint, contact.state);
    any = true;
  }
  return any;
}

bool fail_where_opened(const SolvedJoint& joint, double limit) {
  bool any = false;
  for (std::size_t i = 0; i < joint.contacts.size(); ++i) {
    BodyContact& contact = joint.contacts[i];
    const LinearContact& c = joint.linear[i];
    const bool opened = c.mode == ContactMode::Open && c.relative[0] > limit;
    if (!opened || contact.state.failed || contact.state.bonded) continue;
    weaken(contact.joint, contact.state);
    any = true;
  }
  return any;
}

/// How far the joint has slid in the step as a whole, m: translation and turn that fit the slips of
/// its contacts best. Slips that the strain of a block makes against each other are not in it.
double slip_as_a_whole(const SolvedJoint& joint) {
  const Vector3& normal = joint.contacts.front().state.point.normal;
  const auto count = static_cast<double>(joint.contacts.size());
  std::vector<Vector2d> slips;
  Vector2d middle = Vector2d::Zero(), mean = Vector2d::Zero();
  for (std::size_t i = 0; i < joint.contacts.size(); ++i) {
    const LinearContact& c = joint.linear[i];
    slips.emplace_back(c.relative.tail<2>() - c.start.tail<2>());
    middle += in_plane(joint.contacts[i], normal) / count;
    mean += slips.back() / count;
  }
  double turn = 0.0, inertia = 0.0;
  for (std::size_t i = 0; i < joint.contacts.size(); ++i) {
    const Vector2d arm = in_plane(joint.contacts[i], normal) - middle;
    turn += arm.x() * slips[i].y() - arm.y() * slips[i].x();
    inertia += arm.squaredNorm();
  }
  const double turned = inertia > 0.0 ? std::abs(turn) / std::sqrt(inertia * count) : 0.0;
  return std::max(mean.norm(), turned);
}

bool slides(const SolvedJoint& joint, const FailureLimits& limits) {
  bool resists = false;
  for (std::size_t i = 0; i < joint.contacts.size(); ++i) {
    const LinearContact& c = joint.linear[i];
    if (c.mode == ContactMode::Open) continue;
    if (c.mode != ContactMode::Slip || !(joint.contacts[i].state.slip + c.slip > limits.slip)) {
      return false;
    }
    resists = resists || (c.law == ContactLaw::Coulomb && c.bound > 0.0);
  }
  return resists && slip_as_a_whole(joint) > limits.rounding;
}

/// What is not closed has nothing to lose by sliding.
bool fail_where_sliding(const SolvedJoint& joint, const FailureLimits& limits) {
  const Joint& law = joint.contacts.front().joint;
  const auto intact = [](const BodyContact& contact) { return !contact.state.failed; };
  if (law.softening_slip > 0.0 || std::ranges::none_of(joint.contacts, intact)) return false;
  if (!slides(joint, limits)) return false;
  bool any = false;
  for (std::size_t i = 0; i < joint.contacts.size(); ++i) {
    BodyContact& contact = joint.contacts[i];
    if (contact.state.failed || joint.linear[i].mode == ContactMode::Open) continue;
    weaken(contact.joint, contact.state);
    any = true;
  }
  return any;
}

}  // namespace

bool fail_overloaded(std::span<BodyContact> contacts, std::span<const LinearContact> linear,
                     const FailureLimits& limits) {
  bool any = false;
  for (std::size_t first = 0, last = 0; first < contacts.size(); first = last) {
    const auto same_pair = [&](const BodyContact& contact) {
      return contact.a == contacts[first].a && contact.b == contacts[first].b;
    };
    while (last < contacts.size() && same_pair(contacts[last])) ++last;
    if (!can_fail(contacts[first].joint)) continue;
    const SolvedJoint joint{contacts.subspan(first, last - first),
                            linear.subspan(first, last - first)};
    any = part_where_overloaded(joint) || any;
    any = fail_where_opened(joint, limits.opening) || any;
    any = fail_where_sliding(joint, limits) || any;
  }
  return any;
}

}  // namespace quoin::solver
