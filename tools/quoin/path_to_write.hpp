#pragma once
/// A check of options that name a file or folder to be written.

#include <CLI/CLI.hpp>

namespace quoin::commands {

/// An empty word, as of a variable that is not set, would lose what is to be written.
inline CLI::Validator path_to_write() {
  return CLI::Validator(
      [](const std::string& text) { return text.empty() ? "must not be empty" : std::string(); },
      "PATH");
}

}  // namespace quoin::commands
