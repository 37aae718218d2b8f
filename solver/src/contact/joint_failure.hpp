#pragma once
/// Which joints a solved step has taken beyond their strength.

#include <span>

#include "contact/contact_history.hpp"
#include "contact/linear_contact.hpp"

namespace quoin::solver {

struct FailureLimits {
  double slip = 0.0;      ///< m: a joint that has slid so far has failed
  double opening = 0.0;   ///< m: likewise a contact without tension
  double rounding = 0.0;  ///< m: a smaller slip is none
};

/// Weakens the contacts that have failed; true when there are any. A joint is all contacts of one
/// pair (neighbours in the list; `linear` has the solved forces, one a contact).
///   tension   bonded contacts part where the stress on the area that is still bonded, linear over
///   it
///             (joint_section), exceeds the tension; all of them where they span no area
///   opening   a contact without tension that has opened
///   sliding   a brittle joint all of whose closed contacts slide fails as a whole: until then,
///   corners
///             at their limit hand on what they cannot bear, and the joint bears the limit of its
///             area
/// Softening joints do not fail by sliding: their strength goes with the slip.
bool fail_overloaded(std::span<BodyContact> contacts, std::span<const LinearContact> linear,
                     const FailureLimits& limits);

}  // namespace quoin::solver
