#pragma once
/// What the command has taken of memory.

#include <sys/resource.h>

namespace quoin::commands {

/// Most that this process has had in memory so far, MB of 2^20 bytes.
inline double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

}  // namespace quoin::commands
