#pragma once
/// Numbers as messages and containers have them. Internal.

#include <cstddef>
#include <cstdio>
#include <limits>
#include <quoin/geometry/types.hpp>
#include <string>
#include "numeric/floating_point.hpp"

namespace quoin::geometry {

/// Of vertices, faces and bodies, which are counted in ints; containers count otherwise.
inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// With six digits; "inf" and "nan" as such.
inline std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

/// Throws InputError unless a length (m) is finite and not negative.
inline void require_length(double value, const char* what) {
  if (value >= 0.0 && value <= std::numeric_limits<double>::max()) return;
  throw InputError(std::string(what) + " is " + text(value) +
                   " m, must be finite and not negative");
}

/// Throws InputError unless sums are rounded to nearest. Asked where a shape is made: once for all
/// the questions about it.
inline void check_rounding_mode() {
  if (rounds_to_nearest()) return;
  throw InputError(
      "the rounding mode of floating point is changed, limit round-to-nearest: "
      "std::fesetround(FE_TONEAREST)");
}

}  // namespace quoin::geometry
