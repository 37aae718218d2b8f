#pragma once
/// Formulas of time and place, by muParser.

#include <map>
#include <memory>
#include <quoin/geometry/types.hpp>
#include <string>

namespace quoin::scene_file {

/// Numbers that formulas may use by name, beside pi, deg (pi/180) and g (9.81 m/s2).
using Parameters = std::map<std::string, double>;

/// A formula of t and, where it is allowed, stage_time (s) or x, y, z (m): + - * / ^, sin, cos,
/// tan, sqrt, exp, abs, min, max, a < b ? c : d, …
class Formula {
 public:
  /// What it may name beside parameters: nothing; t; t and stage_time; t and x, y, z.
  enum class Clock { None, Run, RunAndStage, RunAndPlace };

  /// Throws std::invalid_argument saying what is wrong with the expression.
  Formula(std::string expression, const Parameters& parameters, Clock clock = Clock::Run);
  Formula(const Formula& other);
  Formula& operator=(const Formula& other);
  Formula(Formula&&) noexcept;
  Formula& operator=(Formula&&) noexcept;
  ~Formula();

  double at(double time, double stage_time = 0.0) const;
  double at(const geometry::Vector3& place, double time) const;  ///< of x, y, z and t
  bool names_time() const;

  /// Whether a parameter may be called so: a word that is not pi, deg, t, stage_time or a function.
  /// (g, 9.81, may be another number where somebody wants that.)
  static bool may_name(const std::string& parameter);

 private:
  struct Parsed;
  std::string expression_;
  Parameters parameters_;
  Clock clock_;
  std::unique_ptr<Parsed> parsed_;
};

}  // namespace quoin::scene_file
