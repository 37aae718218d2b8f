#pragma once
/// Pressure on a joint that bears no tension, from the resultant of its forces.

#include <Eigen/Core>
#include <optional>
#include <span>

namespace quoin::scene_file {

/// The largest pressure (Pa) on the convex polygon with these corners (in any order, m) when the
/// pressure is linear over the part of it that bears, zero elsewhere, and has the resultant `force`
/// (N, above 0) at `centre`: N/A (1 + 6 e/h) of a rectangle with its resultant in the middle third,
/// 2 N/(3 a b) at a distance a from the edge of length b outside it. None where the polygon has no
/// area, or `centre` is within 1e-6 of its size of its boundary, or outside: no pressure bears it.
std::optional<double> no_tension_edge_stress(std::span<const Eigen::Vector2d> corners,
                                             const Eigen::Vector2d& centre, double force);

}  // namespace quoin::scene_file
