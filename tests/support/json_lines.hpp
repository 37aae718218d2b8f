#pragma once
/// Cases that are data: a JSON object a line.

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "support/catch.hpp"

namespace quoin::tests {

/// Tries each line of a file, of which there must be at least so many.
void for_each_line(const char* path, int least, const auto& tried) {
  std::ifstream file(path);
  int count = 0;
  for (std::string text; std::getline(file, text); ++count) {
    INFO(text);
    tried(nlohmann::json::parse(text));
  }
  CHECK(count >= least);
}

}  // namespace quoin::tests
