#pragma once
/// Blocks shared out over the processes of a run.

#include <quoin/solver/scene.hpp>
#include <span>
#include <vector>

namespace quoin::solver {

/// By point: which of `parts` (0, 1, …) it belongs to. The longest side of the box around all
/// points is cut where the weights on both sides are as the numbers of parts there, and so on with
/// both halves. The same numbers give the same parts. Throws InputError for less than one part, and
/// unless there are as many weights as points.
/// Source: Berger & Bokhari, A partitioning strategy for nonuniform problems on multiprocessors,
/// IEEE Transactions on Computers C-36(5), 1987 (recursive coordinate bisection).
std::vector<int> bisect(std::span<const Vector3> points, std::span<const double> weights,
                        int parts);

/// The same by the centroids of the scene's blocks; fixed and prescribed ones weigh nothing.
std::vector<int> parts_of_blocks(const Scene& scene, int parts);

}  // namespace quoin::solver
