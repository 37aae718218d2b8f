#pragma once
/// A bolt that is grouted along its length, as ties between the blocks that it passes through.

#include <quoin/solver/scene.hpp>

namespace quoin::scene_file {

/// `points` equally spaced points of `whole` (>= 2), each bonded to the block that it lies in (the
/// ends to those of `whole`, where it names any), and between neighbours in different blocks a tie
/// with the stiffness of its part of the length. Throws geometry::InputError for a point that lies
/// in no block.
std::vector<solver::Tie> grouted_tie(const solver::Scene& scene, const solver::Tie& whole,
                                     int points);

}  // namespace quoin::scene_file
