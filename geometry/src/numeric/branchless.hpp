#pragma once
/// Maxima and minima by hand: the library's become branches, which could not be foreseen.
/// Internal.

#include "simd/sse2.hpp"

namespace quoin::geometry {

inline double greater(double x, double y) {
#ifdef QUOIN_SSE2
  return _mm_cvtsd_f64(_mm_max_pd(_mm_set1_pd(x), _mm_set1_pd(y)));
#else
  return x > y ? x : y;
#endif
}

inline double lesser(double x, double y) { return -greater(-x, -y); }

}  // namespace quoin::geometry
