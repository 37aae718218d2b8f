#pragma once
/// Equilibrium problems of scenes that are already compiled.

#include <quoin/solver/equilibrium.hpp>
#include <span>

#include "scene/compiled_scene.hpp"

namespace quoin::solver {

/// What shear a joint bears in tension: of Mohr and Coulomb's cone, or all its cohesion, as in
/// steps. These forces make no convex set; the least one that holds them is a cone, too.
enum class ShearInTension : std::uint8_t { OfCone, Cohesion };

/// Of blocks where `state` has them; `found`: contact points in the frames of the reference shapes.
/// Those with larger gaps than `reach` says (m, by the contact's two blocks) are left out.
EquilibriumProblem equilibrium_problem(const CompiledScene& compiled, const State& state,
                                       std::span<const geometry::ContactPoint> found, double reach,
                                       ShearInTension shear = ShearInTension::OfCone);

std::vector<Vector6> block_loads(const CompiledScene& compiled, const State& state);

}  // namespace quoin::solver
