#include "step/contact_record.hpp"

#include "base/index.hpp"
#include "contact/joint_law.hpp"
#include "contact/joint_springs.hpp"
#include "step/linearise.hpp"

namespace quoin::solver {
namespace {

constexpr double kSameStretch = 1e-9;  // relative: what differs by less is rounding of places

/// Both anchors to where the contact is now, `stretch` (place of b minus place of a) apart. The
/// anchor of a vertex stays on it.
void move_anchor(const Pose& a, const Pose& b, const ContactGeometry& now, const Vector3& stretch,
                 const BodyContact& contact, Contact& ended) {
  const Vector3 normal_part = now.gap * now.normal;
  if (contact.normal_on_a) {
    ended.anchor_b = contact.arm_b;
    ended.anchor_a = reference_arm(a, now.place_b - normal_part - stretch);
  } else {
    ended.anchor_a = contact.arm_a;
    ended.anchor_b = reference_arm(b, now.place_a + normal_part + stretch - now.between);
  }
}

/// The anchor follows: what stretch is left is the spring's at its limit (none for a multiplier).
Vector3 stretch_left(const Vector3& shear_force, const LinearContact& c, const Vector3& moved) {
  if (!c.compliant || !(c.shear_spring > 0.0)) return Vector3::Zero();
  return stretch_kept(c, moved) * shear_force / c.shear_spring;
}

/// What a spring of a joint with stiffness has stored goes by `stretch`; the anchors, held by
/// blocks that turn, have it but for the second order of the turn, and less well on crossed edges.
void keep_stretch(const Pose& a, const Pose& b, const ContactGeometry& now, const Vector3& stretch,
                  const BodyContact& contact, Contact& state) {
  const Vector3 along = stretch - stretch.dot(now.normal) * now.normal;
  const double size = along.norm();
  const Vector3 has = shear_stretch(a, b, now.normal, state);
  if (!(size > 0.0) || (has - along).norm() <= kSameStretch * size) return;
  move_anchor(a, b, now, stretch.norm() / size * along, contact, state);
}

void record_contact(const LinearContact& c, const StepPoses& poses, const BodyContact& contact,
                    Contact& state) {
  const Pose &a = poses.end[index(contact.a)], &b = poses.end[index(contact.b)];
  const ContactGeometry now = contact_geometry(contact, a, b);
  const Vector3 before =
      contact_normal(contact, poses.start[index(contact.a)], poses.start[index(contact.b)]);
  Vector3 t1, t2;
  tangent_frame(contact, 0.5 * (before + now.normal), t1, t2);
  state.mode = c.mode;
  state.next_normal_force = c.force[0];
  state.next_shear_force = -(c.force[1] * t1 + c.force[2] * t2);
  state.point.point_a = a.centroid + now.place_a;
  state.point.point_b = a.centroid + now.place_b;
  state.point.normal = now.normal;
  state.point.gap = now.gap;
  set_force_on_b(c.jacobian_b.rigid.leftCols<3>().transpose() * c.force, state);
  const Vector3 moved = moved_by(poses, contact, c);
  state.slip += slip_in_step(c, moved);
  const double softening = contact.joint->softening_slip;
  if (!state.failed && softening > 0.0 && state.slip >= softening) weaken(*contact.joint, state);
  if (c.mode == ContactMode::Open) return;
  if (c.mode == ContactMode::Slip || (!contact.was_closed && !c.compliant)) {
    move_anchor(a, b, now, stretch_left(state.next_shear_force, c, moved), contact, state);
  } else if (state.spring_area > 0.0) {
    const Vector3 end = c.start + moved;
    keep_stretch(a, b, now, end[1] * t1 + end[2] * t2, contact, state);
  }
}

}  // namespace

Vector3 force_on_b(const Contact& contact) {
  return contact.normal_force * contact.point.normal - contact.shear_force;
}

void set_force_on_b(const Vector3& force, Contact& contact) {
  contact.normal_force = force.dot(contact.point.normal);
  contact.shear_force = contact.normal_force * contact.point.normal - force;
}

void record(const SolvedStep& solved, const StepPoses& poses, std::vector<Contact>& ended) {
  const auto is_hit = [&](int slot) { return slot >= 0 && solved.hit[index(slot)]; };
  ended.clear();
  ended.reserve(solved.contacts.size());
  for (std::size_t i = 0; i < solved.contacts.size(); ++i) {
    const LinearContact& c = solved.linear[i];
    Contact& state = ended.emplace_back(solved.contacts[i].state);
    state.impact = is_hit(c.slot_a) || is_hit(c.slot_b);
    record_contact(c, poses, solved.contacts[i], state);
  }
}

}  // namespace quoin::solver
