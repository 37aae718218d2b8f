#pragma once
/// Which joints fail where a step has no solution as long as all of them hold.

#include "iteration/open_close.hpp"
#include "step/sub_step.hpp"

namespace quoin::solver {

struct BodyContact;

/// Weakens what the solved forces load most beyond strength, or else what has opened; true when
/// there is anything. `solved`: what the contacts are from. Forces that grow for ever are taken
/// where the first joint has its strength.
bool fail_weakest(const SubStep& step, const OpenCloseResult& solved,
                  std::span<BodyContact> contacts, std::span<const LinearContact> linear);

}  // namespace quoin::solver
