#pragma once
/// Which joints a solved step has taken beyond their strength.

#include <span>

#include "contact/contact_history.hpp"
#include "contact/linear_contact.hpp"

namespace quoin::solver {

/// Weakens the contacts that have failed; true when there are any. A joint is all contacts of one
/// pair (neighbours in the list; `linear` has the solved forces, one a contact).
///   tension   bonded contacts part where the stress on the area that is still bonded, linear over
///   it
///             (joint_section), exceeds the tension; all of them where they span no area
///   opening   a contact without tension that has opened by more than `opened` (m); one that clings
///             with residual cohesion does so no more in this sub-step
///   sliding   the contacts that are bonded in shear fail together where their forces' resultant V
///   in the
///             plane and moment T about its normal reach (V / V0)^2 + (T / T0)^2 = 1, with
///             V0 = sum (friction N + cohesion area), T0 the same by distance from their centre of
///             strength: the ellipsoid of [Goyal, Ruina & Papadopoulos 1991], exact for V or T
///             alone
/// Softening joints do not fail by sliding: their strength goes with the slip.
bool fail_overloaded(std::span<BodyContact> contacts, std::span<const LinearContact> linear,
                     double opened);

}  // namespace quoin::solver
