#pragma once
/// The springs of a joint with stiffness per area: on which areas they act, and what they store
/// where these change.
///
/// They act at the corners and at inner points (joint_area.hpp). The part of the corners which a
/// block lifts does not go over to others, and they have it when they come down.
///
/// Springs go by their whole overlap, E = sum k A o^2 / 2. Where areas have changed since the last
/// step, or contacts have come in that overlap, that may be more than they have stored. What joints
/// had on area that they have lost goes to those that have gained, as where a block slides from one
/// support to the next. If it is too little, all stretches of a joint are reduced by one factor:
/// the gap at which a spring is unstressed is offset. As soon as there is energy for it the springs
/// have their whole overlap again.

#include "contact/joint_area.hpp"

namespace quoin::solver {

/// Place of anchor b less that of anchor a, along the plane of the contact, m.
Vector3 shear_stretch(const Pose& a, const Pose& b, const Vector3& normal, const Contact& contact);

/// Sets Contact::spring_area of the contacts of one pair that a search found. Those that have no
/// part of the area and touch where others do are beside these (BodyContact::beside_springs).
void set_spring_areas(const JointBlocks& blocks, const JointPolygon& polygon,
                      std::span<BodyContact> joint);

/// In springs, J.
struct StoredEnergy {
  double normal = 0.0, shear = 0.0;
};

/// A joint whose springs act on other areas than in the last step.
struct ChangedSprings {
  JointBlocks blocks;
  std::span<BodyContact> joint;
  StoredEnergy had;    ///< as the last step left them
  StoredEnergy whole;  ///< as that would have been by the whole overlaps
  StoredEnergy now;    ///< by the whole overlaps on the areas as they are
};
/// `before`: contacts of the pair as the last step left them. Anchors of what was open come to lie
/// beside each other.
ChangedSprings changed_springs(const JointBlocks& blocks, std::span<const Contact> before,
                               std::span<BodyContact> joint);

/// Offsets of the springs, and shear stretches, with no more energy than was stored in all; in
/// statics the whole overlaps.
void keep_stored_energy(std::span<const ChangedSprings> joints, bool dynamic);

/// A contact that an attempt has missed: its spring is unstressed as the step starts, where the
/// blocks stand now.
void begin_spring(const JointBlocks& blocks, BodyContact& contact);

}  // namespace quoin::solver
