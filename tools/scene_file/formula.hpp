#pragma once
/// Formulas of time, by muParser.

#include <map>
#include <memory>
#include <string>

namespace quoin::scene_file {

/// Numbers that formulas may use by name, beside pi, deg (pi/180) and g (9.81 m/s2).
using Parameters = std::map<std::string, double>;

/// A formula of t (s): + - * / ^, sin, cos, tan, sqrt, exp, abs, min, max, a < b ? c : d, …
class Formula {
 public:
  /// Throws std::invalid_argument saying what is wrong with the expression.
  Formula(std::string expression, const Parameters& parameters);
  Formula(const Formula& other);
  Formula& operator=(const Formula& other);
  Formula(Formula&&) noexcept;
  Formula& operator=(Formula&&) noexcept;
  ~Formula();

  double at(double time) const;

  /// Whether a parameter may be called so: a word that is not pi, deg, t or a function. (g, 9.81,
  /// may be another number where somebody wants that.)
  static bool may_name(const std::string& parameter);

 private:
  struct Parsed;
  std::string expression_;
  Parameters parameters_;
  std::unique_ptr<Parsed> parsed_;
};

}  // namespace quoin::scene_file
