#pragma once
/// Contacts of all processes on each of them, for what is not shared out.

#include "contact/linear_contact.hpp"
#include "distributed/agreement.hpp"

namespace quoin::solver {

/// By number, with all that they hold but their pair. `contacts`: of this process.
std::vector<LinearContact> gather(const Agreement& agreement, const Slots& slots,
                                  std::span<const LinearContact> contacts);

/// Pairs of slots, ascending.
std::vector<std::pair<int, int>> gather(const Agreement& agreement, const Slots& slots,
                                        std::span<const std::pair<int, int>> pairs);

/// What was done to all of them goes back to those of this process.
void take_back(std::span<const LinearContact> all, std::span<LinearContact> contacts);

}  // namespace quoin::solver
