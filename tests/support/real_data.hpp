#pragma once
/// Assemblies of other authors, which are not part of this repository.

#include <cstdlib>
#include <filesystem>
#include <string>

#include "support/catch.hpp"

namespace quoin::tests {

/// The folder named by the environment variable QUOIN_REAL_DATA; empty, and said so, without it:
/// the test then ends.
inline std::string real_data() {
  const char* folder = std::getenv("QUOIN_REAL_DATA");
  if (folder == nullptr ||
      !std::filesystem::exists(std::filesystem::path(folder) / "arch_assembly.json")) {
    WARN("skipped: QUOIN_REAL_DATA names no folder with arch_assembly.json");
    return "";
  }
  return std::filesystem::absolute(folder).string();
}

}  // namespace quoin::tests
