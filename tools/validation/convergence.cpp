#include "convergence.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <limits>

namespace quoin::validation {
namespace {

constexpr double kOrderSlack = 0.3;  // of an observed order: few points, events inside steps

}  // namespace

double Series::order() const {
  const double sign = refined == Refined::Penalty ? -1.0 : 1.0;
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (std::size_t i = 0; i < errors.size() && errors[i] > floor; ++i) {
    const double step = sign * std::log(values[i]), error = std::log(errors[i]);
    n += 1.0;
    x += step;
    y += error;
    xx += step * step;
    xy += step * error;
  }
  return n < 2.0 ? std::numeric_limits<double>::quiet_NaN() : (n * xy - x * y) / (n * xx - x * x);
}

double Series::stops_at() const {
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (errors[i] <= floor) return values[i];
  }
  return std::numeric_limits<double>::quiet_NaN();
}

bool Series::ok() const {
  if (!failure.empty() || errors.empty()) return false;
  const auto at_floor = [this](double error) { return error <= floor; };
  const auto reached = std::find_if(errors.begin(), errors.end(), at_floor);
  if (!std::all_of(reached, errors.end(), at_floor)) return false;
  if (expected_order == 0.0 || reached - errors.begin() < 2) return reached == errors.begin();
  return order() >= expected_order - kOrderSlack;
}

void Convergence::halve_time_step(const Study& study, const Error& error) {
  run(study, Refined::TimeStep, error);
}

void Convergence::raise_penalty(const Study& study, const Error& error) {
  run(study, Refined::Penalty, error);
}

void Convergence::run(const Study& study, Refined refined, const Error& error) {
  const auto start = std::chrono::steady_clock::now();
  Series series{case_name_, study.quantity, refined};
  series.expected_order = study.expected_order;
  series.floor = study.floor;
  const double factor = refined == Refined::Penalty ? 10.0 : 0.5;
  try {
    for (int i = 0; i < study.count; ++i) {
      series.values.push_back(study.first * std::pow(factor, i));
      series.errors.push_back(std::abs(error(series.values.back())));
    }
  } catch (const std::exception& broke_off) {
    series.failure = broke_off.what();
  }
  series.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  series_.push_back(series);
}

}  // namespace quoin::validation
