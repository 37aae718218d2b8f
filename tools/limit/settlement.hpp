#pragma once
/// How far a support can go down. The structure follows it: a path, run by the solver.

#include "limit/loading.hpp"

namespace quoin::limit_analysis {

/// The fixed block Vary::name sinks along gravity from `from` to `to`, m, in steps that halve where
/// rest is lost, each of them a slow dynamic run and a static one. What rests counts where forces
/// that hold it are proved. `stands`: the last geometry at rest, `falls`: the next one, each proved
/// by itself as it stands there, in which all blocks count as rigid. `seconds`: of wall time.
/// Throws std::invalid_argument for a block that is not fixed.
Limit settle(const VariedScene& scenes, double tolerance, double seconds, const Progress& progress,
             Reached& reached);

}  // namespace quoin::limit_analysis
