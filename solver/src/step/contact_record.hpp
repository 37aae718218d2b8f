#pragma once
/// What a solved sub-step leaves in its contacts: forces, modes, slips, anchors.

#include "contact/contact_jacobian.hpp"

namespace quoin::solver {

/// `hit`: by slot. `linear`: the contacts as solved, in their order.
std::vector<BodyContact> contacts_at_end(std::span<const BodyContact> contacts,
                                         std::span<const LinearContact> linear,
                                         std::span<const char> hit, const StepPoses& poses);

}  // namespace quoin::solver
