#pragma once
/// What the arithmetic of this library needs: IEEE 754 doubles as written, rounded to nearest.
/// Internal.

#include <cfloat>
#include <limits>

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || \
    (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error \
    "quoin needs IEEE 754 arithmetic: compile it without -ffast-math (-Ofast, -ffinite-math-only)"
#endif

namespace quoin::geometry {

static_assert(std::numeric_limits<double>::is_iec559 && FLT_EVAL_METHOD == 0,
              "quoin needs doubles that are rounded after each step: on x86 use -mfpmath=sse");

inline constexpr double kEpsilon = std::numeric_limits<double>::epsilon();  ///< 2^-52
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Are sums rounded to nearest at run time? Two sums, each of which another mode rounds otherwise.
inline bool rounds_to_nearest() {
  const volatile double one = 1.0, little = kEpsilon / 4;
  return one + little == 1.0 && -one - little == -1.0 && one - little == 1.0;
}

inline double greater(double x, double y) { return x > y ? x : y; }
inline double lesser(double x, double y) { return x < y ? x : y; }

}  // namespace quoin::geometry
