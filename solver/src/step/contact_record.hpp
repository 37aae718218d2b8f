#pragma once
/// What a solved sub-step leaves in its contacts: forces, modes, slips, anchors.

#include "contact/contact_jacobian.hpp"

namespace quoin::solver {

/// `linear`: the contacts as solved, in their order; held points after them. `moved`: see
/// set_moved(). `hit`: by slot. `contacts`: as they were at the start, and as they end.
void record(std::span<const LinearContact> linear, std::span<const Vector3> moved,
            std::span<const char> hit, const StepPoses& poses, std::span<BodyContact> contacts);

}  // namespace quoin::solver
