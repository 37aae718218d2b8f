#pragma once
/// What a solved sub-step leaves in its contacts: forces, modes, slips, anchors.

#include "contact/contact_jacobian.hpp"

namespace quoin::solver {

struct SolvedStep {
  std::span<const BodyContact> contacts;  ///< as they were at the start
  std::span<const LinearContact> linear;  ///< as solved, in their order; held points after them
  std::span<const char> hit;              ///< by slot
};

/// Mean of the step, N.
Vector3 force_on_b(const Contact& contact);
void set_force_on_b(const Vector3& force, Contact& contact);

/// `ended`: the contacts as they end, in their order.
void record(const SolvedStep& solved, const StepPoses& poses, std::vector<Contact>& ended);

}  // namespace quoin::solver
