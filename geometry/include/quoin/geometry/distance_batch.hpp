#pragma once
/// Nearest features of the caller's own pairs, many in one call: for a code that asks for distances
/// alone, step after step.

#include <quoin/geometry/executor.hpp>
#include <quoin/geometry/nearest_features.hpp>
#include <quoin/geometry/pair_batch.hpp>
#include <span>

namespace quoin::geometry {

/// What nearest_features(bodies[pair.a], bodies[pair.b], options, answer.hint) gives, to the bit,
/// for each pair, in place of its answer of the last call (one as made: a cold search). Pairs may
/// come in any order and more than once; `answers` are as many. `executor`: null: the caller's
/// thread alone; the answers depend neither on the number of workers nor on the other pairs.
/// Throws InputError, before any answer is touched, for a pair that does not name two bodies, for
/// another number of answers and for a body named whose placement is none. What an executor throws
/// leaves each answer the old one or the new one.
void update_nearest_features(std::span<const Body> bodies, std::span<const BlockPair> pairs,
                             std::span<NearestFeatures> answers, const SearchOptions& options = {},
                             Executor* executor = nullptr);

}  // namespace quoin::geometry
