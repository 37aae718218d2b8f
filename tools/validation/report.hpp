#pragma once
/// Rows of the validation table: a result beside its exact value and the error that is allowed.

#include <chrono>
#include <functional>
#include <string>
#include <vector>

namespace quoin::validation {

struct Row {
  std::string case_name;  ///< "V01"
  std::string quantity;   ///< what, of which run, unit; "rel." when the error is relative
  double exact = 0.0;
  double result = 0.0;
  double error = 0.0;
  double allowed = 0.0;
  bool ok = false;       ///< error <= allowed; NaN is not ok
  double seconds = 0.0;  ///< since start_run()
};

/// Collects the rows of one case.
class Report {
 public:
  explicit Report(std::string case_name) : case_name_(std::move(case_name)) { start_run(); }

  void start_run() { start_ = Clock::now(); }

  /// start_run(), then `run`; when it throws, a row that is not ok says what broke off.
  void attempt(const std::string& what, const std::function<void()>& run);

  /// |result - exact| / |exact| <= allowed.
  void relative(const std::string& quantity, double exact, double result, double allowed);
  /// |result - exact| <= allowed.
  void absolute(const std::string& quantity, double exact, double result, double allowed);
  /// result >= threshold; the error is what is missing.
  void at_least(const std::string& quantity, double threshold, double result);
  /// A run that broke off.
  void failed(const std::string& what);

  const std::vector<Row>& rows() const { return rows_; }

 private:
  using Clock = std::chrono::steady_clock;
  void add(const std::string& quantity, double exact, double result, double error, double allowed);

  std::string case_name_;
  std::vector<Row> rows_;
  Clock::time_point start_;
};

}  // namespace quoin::validation
