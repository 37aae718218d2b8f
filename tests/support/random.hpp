#pragma once
/// Random numbers of the tests: those of the families, and what the environment asks for.

#include <cstdlib>

#include "referee/pairs/random.hpp"

namespace quoin::tests {

using namespace referee;  // Random, pairs, exact answers

/// A number from the environment, or the value given: QUOIN_SEED, QUOIN_CASES.
inline std::uint64_t environment_number(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

}  // namespace quoin::tests
