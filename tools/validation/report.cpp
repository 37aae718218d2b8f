#include "report.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>

namespace quoin::validation {

void Report::add(const std::string& quantity, double exact, double result, double error,
                 double allowed) {
  const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
  rows_.push_back({case_name_, quantity, exact, result, error, allowed, error <= allowed, seconds});
}

void Report::relative(const std::string& quantity, double exact, double result, double allowed) {
  add(quantity + ", rel.", exact, result, std::abs(result - exact) / std::abs(exact), allowed);
}

void Report::absolute(const std::string& quantity, double exact, double result, double allowed) {
  add(quantity, exact, result, std::abs(result - exact), allowed);
}

void Report::at_least(const std::string& quantity, double threshold, double result) {
  const double missing = result >= threshold ? 0.0 : threshold - result;  // NaN stays NaN
  add(quantity + ", at least", threshold, result, missing, 0.0);
}

void Report::attempt(const std::string& what, const std::function<void()>& run) {
  start_run();
  try {
    run();
  } catch (const std::exception& error) {
    failed(what + ": " + error.what());
  }
}

void Report::failed(const std::string& what) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  add("run broke off: " + what, 0.0, none, none, 0.0);
}

}  // namespace quoin::validation
