#pragma once
/// What messages about bad input call numbers and blocks.

#include <charconv>
#include <cstddef>
#include <quoin/solver/scene.hpp>
#include <string>

namespace quoin::solver {

/// The shortest text that is read back to the same bits.
inline std::string text_of(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

inline std::string label(const Block& block, int index) {
  return "block " + std::to_string(index) + (block.name.empty() ? "" : " (" + block.name + ")");
}

/// A block's index as one of `count`; throws InputError, the message after `what`.
inline std::size_t checked_block(int block, std::size_t count, const std::string& what = {}) {
  if (block >= 0 && static_cast<std::size_t>(block) < count) return static_cast<std::size_t>(block);
  throw InputError(what + "block " + std::to_string(block) + " does not exist (the scene has " +
                   std::to_string(count) + ")");
}

}  // namespace quoin::solver
