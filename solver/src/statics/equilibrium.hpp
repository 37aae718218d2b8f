#pragma once
/// Equilibrium problems of scenes that are already compiled.

#include <quoin/solver/equilibrium.hpp>
#include <span>

#include "scene/compiled_scene.hpp"

namespace quoin::solver {

/// Where strength acts: at points that share the area; at those of steps, in which joints that are
/// judged as a whole have corners alone; at the core of joints with tension.
enum class StrengthPoints : std::uint8_t { ShareArea, OfSteps, OfCore };

/// Of blocks where `state` has them; `found`: contact points in the frames of the reference shapes.
/// Those with larger gaps than `reach` says (m, by the contact's two blocks) are left out.
EquilibriumProblem equilibrium_problem(const CompiledScene& compiled, const State& state,
                                       std::span<const geometry::ContactPoint> found, double reach,
                                       StrengthPoints points = StrengthPoints::ShareArea);

std::vector<Vector6> block_loads(const CompiledScene& compiled, const State& state);

}  // namespace quoin::solver
