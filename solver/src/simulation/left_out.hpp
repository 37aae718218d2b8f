#pragma once
/// What a scene does not need: told in words, one line each.

#include <quoin/solver/simulation.hpp>

#include "scene/compiled_scene.hpp"

namespace quoin::solver {

/// Each line names what is not done and why; only what the code really leaves out stands here.
std::vector<std::string> left_out(const CompiledScene& compiled, const StepOptions& options);

}  // namespace quoin::solver
