#pragma once
/// What a monitor of a group of blocks shows.

#include <span>

#include "scene_file/comparison.hpp"

namespace quoin::scene_file {

/// Momentum, angular momentum, mean stress and mean strain of these blocks as they are; absent ones
/// count for nothing.
MonitorValue group_value(const solver::Simulation& simulation, std::span<const int> blocks);

}  // namespace quoin::scene_file
