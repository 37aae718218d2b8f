#pragma once
/// Wide instructions chosen at run time: functions with one of the attributes below may use them,
/// and are called only where the machine has them. Sums are written out, so that all variants of a
/// function give the same bits. Not for clang, which does not build the functions of one target
/// into another: plain loops there. Internal.

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define QUOIN_WIDE_LANES
#include <immintrin.h>
// Of gcc 12's own header, its bug 105593:
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wuninitialized"

#define QUOIN_AVX512 __attribute__((target("avx512f,avx512dq,avx512vl,fma,bmi,bmi2")))
#define QUOIN_AVX2 __attribute__((target("avx2,fma,bmi,bmi2")))

namespace quoin::geometry {

inline const bool kHasAvx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                             __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
inline const bool kHasAvx512 = kHasAvx2 && __builtin_cpu_supports("avx512f") &&
                               __builtin_cpu_supports("avx512dq") &&
                               __builtin_cpu_supports("avx512vl");
inline bool has_avx2() { return kHasAvx2; }
inline bool has_avx512() { return kHasAvx512; }
}  // namespace quoin::geometry
#endif
