#pragma once
/// Which joints a solved step has taken beyond their strength.

#include <span>
#include <vector>

#include "contact/contact_history.hpp"
#include "contact/linear_contact.hpp"

namespace quoin::solver {

/// Weakens the contacts that have failed; true when there are any. A joint is all contacts of one
/// pair (neighbours in the list; `linear` has the solved forces, one a contact).
///   tension   bonded contacts part where the stress exceeds the tension: that of their springs, or
///             of a rigid joint linear over the area that is still bonded (joint_section); all of
///             them where they span no area; with a corner the inner points of its triangles
///   opening   a contact without tension that has opened by more than `opened` (m); one that clings
///             with residual cohesion does so no more in this sub-step
///   sliding   the contacts that are bonded in shear fail together where their forces' resultant in
///             the plane V and moment about its normal T reach (V / V0)^2 + (T / T0)^2 = 1, with
///             V0 = sum (friction N + cohesion area), T0 the same by distance from their centre of
///             strength: the ellipsoid of [Goyal, Ruina & Papadopoulos 1991], exact for V or T
///             alone
/// Softening joints do not fail by sliding: their strength goes with the slip.
bool fail_overloaded(std::span<BodyContact> contacts, std::span<const LinearContact> linear,
                     double opened);

/// Whether any holds more than its strength while a step is solved.
bool may_fail(std::span<const BodyContact> contacts);

// Where a step has no solution as long as joints hold without limit what breaks first is asked for:
// it may spare the others.

/// By contact: of the strength of its joint, what that is loaded with. `largest_force`: of all
/// contacts, N; what is rounding of it loads nothing.
std::vector<double> joint_loads(std::span<BodyContact> contacts,
                                std::span<const LinearContact> linear, double largest_force);

/// As fail_overloaded(), of the joints alone whose contacts are `chosen`, and not what has opened.
bool fail_chosen(std::span<BodyContact> contacts, std::span<const LinearContact> linear,
                 std::span<const char> chosen);

/// As fail_overloaded(), of what has opened alone.
bool fail_opened(std::span<BodyContact> contacts, std::span<const LinearContact> linear,
                 double opened);

}  // namespace quoin::solver
