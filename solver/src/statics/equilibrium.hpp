#pragma once
/// Equilibrium problems of scenes that are already compiled.

#include <quoin/solver/equilibrium.hpp>
#include <span>

#include "scene/compiled_scene.hpp"

namespace quoin::solver {

/// Of blocks where `state` has them; `found`: contact points in the frames of the reference shapes.
/// Those with larger gaps than `reach` says (m, by the contact's two blocks) are left out.
EquilibriumProblem equilibrium_problem(const CompiledScene& compiled, const State& state,
                                       std::span<const geometry::ContactPoint> found, double reach);

std::vector<Vector6> block_loads(const CompiledScene& compiled, const State& state);

}  // namespace quoin::solver
