#pragma once
/// Error of a case against its time step or its penalty: the order, and where it stops.

#include <functional>
#include <string>
#include <vector>

namespace quoin::validation {

/// What is refined: the time step is halved, the penalty multiplied by ten.
enum class Refined : std::uint8_t { TimeStep, Penalty };

struct Series {
  std::string case_name;  ///< "V11"
  std::string quantity;   ///< what, of which run, unit; "rel." when the error is relative
  Refined refined = Refined::TimeStep;
  std::vector<double> values{};  ///< s or N/m, from coarse to fine
  std::vector<double> errors{};
  double expected_order = 0.0;  ///< 0: right to rounding from the coarsest value on
  double floor = 0.0;           ///< errors below it are of rounding and tolerance, not of the step
  std::string failure{};        ///< a run that broke off; errors end before it
  double seconds = 0.0;

  /// Of the error in the refined step (1 / penalty): least squares over the errors above the floor;
  /// NaN where fewer than two are.
  double order() const;
  /// First value whose error is below the floor; NaN when none is.
  double stops_at() const;
  /// Orders at least expected_order - 0.3 down to the floor, and nothing above it afterwards.
  bool ok() const;
};

/// Collects the series of one case.
class Convergence {
 public:
  explicit Convergence(std::string case_name) : case_name_(std::move(case_name)) {}

  struct Study {
    std::string quantity;
    double first = 0.0;  ///< s or N/m
    int count = 6;
    double expected_order = 0.0;
    double floor = 0.0;
  };
  using Error = std::function<double(double value)>;

  void halve_time_step(const Study& study, const Error& error);
  void raise_penalty(const Study& study, const Error& error);

  const std::vector<Series>& series() const { return series_; }

 private:
  void run(const Study& study, Refined refined, const Error& error);
  std::string case_name_;
  std::vector<Series> series_;
};

}  // namespace quoin::validation
