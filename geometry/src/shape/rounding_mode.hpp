#pragma once
/// Internal.

#include <quoin/geometry/types.hpp>

#include "numeric/floating_point.hpp"

namespace quoin::geometry {

/// Throws InputError unless sums are rounded to nearest. Asked where a shape is made: once for all
/// the questions about it.
inline void check_rounding_mode() {
  if (rounds_to_nearest()) return;
  throw InputError(
      "the rounding mode of floating point is changed, limit round-to-nearest: "
      "std::fesetround(FE_TONEAREST)");
}

}  // namespace quoin::geometry
