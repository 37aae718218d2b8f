#pragma once
/// Which function of time left the numbers.

#include <quoin/solver/simulation.hpp>
#include <string>

namespace quoin::scene_file {

/// "; motion of "table" at 0.5 s is not finite": of gravity, loads, motions and held points the
/// first that is not within a step that begins at `time`. Nothing where all are.
std::string not_finite(const solver::Scene& scene, double time, const solver::StepOptions& options);

}  // namespace quoin::scene_file
