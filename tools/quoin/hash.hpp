#pragma once
/// A hash of bytes by which a file that was changed is known.

#include <cstdint>
#include <span>

namespace quoin::commands {

constexpr std::uint64_t kHashOfNothing = 14695981039346656037U;

/// FNV-1a [Fowler, Noll & Vo], 64 bits, of what `hash` is of and these bytes after it.
inline std::uint64_t hashed(std::span<const char> bytes, std::uint64_t hash) {
  for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 1099511628211U;
  return hash;
}

}  // namespace quoin::commands
