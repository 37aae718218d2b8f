#pragma once
/// The end of a bench program's main().

#include <cstdio>
#include <exception>

namespace quoin::bench {

/// Calls run(); what it throws is told on standard error and gives exit code 1.
template <class Run>
int guarded(const char* program, const Run& run) {
  try {
    run();
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program, error.what());
    return 1;
  }
}

}  // namespace quoin::bench
