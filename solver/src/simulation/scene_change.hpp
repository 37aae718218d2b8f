#pragma once
/// What stays when a scene is exchanged for another of the same blocks (Simulation::change).

#include "step/workspace.hpp"

namespace quoin::solver {

/// Throws InputError unless both have the same blocks with the same shapes.
void check_same_blocks(const Scene& before, const Scene& now);

/// State and workspace of `now`, as they were made for its start, take over what goes on from
/// `before`. The energy ledger but for its springs.
void take_over(const CompiledScene& before, const State& state_before, const Workspace& work_before,
               CompiledScene& now, State& state, Workspace& work);

/// By block: whether its velocity is another one.
std::vector<char> set_on(const State& before, const State& now);

/// Blocks that were set on towards what they touched hit it: what they bore there is over. Springs
/// go on with what they have stored. `set_on`, by block: whose contacts are asked.
void part_hit_contacts(std::span<const char> set_on, ContactMethod method, State& state);

}  // namespace quoin::solver
