#pragma once
/// Numbers of blocks, slots and contacts are ints; containers count otherwise.

#include <cstddef>

namespace quoin::solver {

inline std::size_t index(int i) { return static_cast<std::size_t>(i); }

}  // namespace quoin::solver
