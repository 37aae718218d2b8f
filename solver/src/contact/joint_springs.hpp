#pragma once
/// The springs of a joint with stiffness per area: on which areas they act, and what they store
/// where these change.
///
/// They act at the corners and at inner points (joint_area.hpp). The part of the corners which a
/// block lifts does not go over to others, and they have it when they come down.
///
/// Springs go by their whole overlap, E = sum k A o^2 / 2. Where areas have changed since the last
/// step, or contacts have come in that overlap, that may be more than they have stored. Then all
/// stretches are reduced by one factor, so that the energy is the same: the gap at which a spring
/// is unstressed is offset. As soon as there is energy for it the springs have their whole overlap
/// again.

#include "contact/joint_area.hpp"

namespace quoin::solver {

/// Place of anchor b less that of anchor a, along the plane of the contact, m.
Vector3 shear_stretch(const Pose& a, const Pose& b, const Vector3& normal, const Contact& contact);

/// Sets Contact::spring_area of the contacts of one pair that a search found. Those that have no
/// part of the area and touch where others do are beside these (BodyContact::beside_springs).
void set_spring_areas(const JointBlocks& blocks, const JointPolygon& polygon,
                      std::span<BodyContact> joint);

/// Offsets of the springs, and shear stretches, with no more energy than was stored; in statics the
/// whole overlaps. `before`: contacts of the pair as the last step left them.
void keep_stored_energy(const JointBlocks& blocks, std::span<const Contact> before, bool dynamic,
                        std::span<BodyContact> joint);

/// A contact that an attempt has missed: its spring is unstressed as the step starts, where the
/// blocks stand now.
void begin_spring(const JointBlocks& blocks, BodyContact& contact);

}  // namespace quoin::solver
