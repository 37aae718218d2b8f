#pragma once
/// A check of options that take wall time, s.

#include <CLI/CLI.hpp>

namespace quoin::commands {

enum class Zero { Allowed, Refused };

/// At most 30 years.
inline CLI::Validator wall_seconds(Zero zero) {
  return CLI::Validator(
      [zero](const std::string& text) {
        constexpr double kMost = 1e9;
        double value = 0.0;
        const bool good = CLI::detail::lexical_cast(text, value) && value <= kMost &&
                          (value > 0.0 || (zero == Zero::Allowed && value == 0.0));
        const char* range = zero == Zero::Allowed ? "lie in 0" : "be greater than 0, and lie in 0";
        return good ? std::string()
                    : "must " + std::string(range) + " … 1e9 s, is " + text.substr(0, 40);
      },
      "SECONDS");
}

}  // namespace quoin::commands
