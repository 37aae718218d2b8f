#pragma once
/// What this process has taken of memory.

#include <sys/resource.h>

#include <fstream>
#include <string>

namespace quoin::scene_file {

/// Most that this process has had in memory so far, MB of 2^20 bytes. Linux starts ru_maxrss at
/// what the process had that started this one, so it is asked only where /proc is missing.
inline double peak_memory_mb() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kilobytes = 0.0;
    if (word == "VmHWM:" && status >> kilobytes) return kilobytes / 1024;
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

}  // namespace quoin::scene_file
