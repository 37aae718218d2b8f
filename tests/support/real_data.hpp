#pragma once
/// Assemblies of other authors, which are not part of this repository.

#include <cstdlib>
#include <filesystem>
#include <string>

#include "support/catch.hpp"

namespace quoin::tests {

/// The folder named by the environment variable QUOIN_REAL_DATA; the test fails without it.
inline std::string real_data() {
  const char* folder = std::getenv("QUOIN_REAL_DATA");
  REQUIRE(folder != nullptr);
  REQUIRE(std::filesystem::exists(std::filesystem::path(folder) / "arch_assembly.json"));
  return std::filesystem::absolute(folder).string();
}

}  // namespace quoin::tests
