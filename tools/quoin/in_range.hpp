#pragma once
/// A check of options that take a number.

#include <CLI/CLI.hpp>

namespace quoin::commands {

constexpr double kMostSeconds = 1e9;  ///< wall time: 30 years

/// Not CLI::Range, which lets NaN through.
inline CLI::Validator in_range(double least, double most) {
  const auto shown = [](double value) { return CLI::detail::to_string(value); };
  const std::string range = shown(least) + " … " + shown(most);
  return CLI::Validator(
      [=](const std::string& text) {
        double value = 0.0;
        const bool good = CLI::detail::lexical_cast(text, value) && value >= least && value <= most;
        return good ? std::string() : "must lie in " + range + ", is " + text.substr(0, 40);
      },
      range);
}

}  // namespace quoin::commands
