#pragma once
/// Pairs as text that makes them again, to the last bit.

#include <string>

#include "referee/pairs/solids.hpp"

namespace quoin::referee {

/// A line of tests/pairs/*.jsonl without its answer: for `quoin contact` and `quoin referee`.
std::string pair_as_json(const SolidPair& pair, const std::string& id);
/// Programs that ask quoin for it.
std::string pair_as_cpp(const SolidPair& pair);
std::string pair_as_c(const SolidPair& pair);

}  // namespace quoin::referee
