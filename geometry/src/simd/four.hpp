#pragma once
/// Four numbers side by side as the compiler's own vectors, which it lays into the registers that
/// it compiles for. See kernels/kernels.hpp. Internal.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace quoin::geometry {
namespace {

using Four = double __attribute__((vector_size(32), aligned(16)));
using FourFlags = long long __attribute__((vector_size(32), aligned(16)));  // 0 or -1

struct FourVectors {
  Four x, y, z;
};

inline Four four(double value) { return Four{value, value, value, value}; }
/// Of a row in memory.
using FourInRow = double __attribute__((vector_size(32), aligned(8), may_alias));
inline Four load(const double* row) { return *reinterpret_cast<const FourInRow*>(row); }
inline void store(const Four& v, double* row) { *reinterpret_cast<FourInRow*>(row) = v; }

inline FourVectors operator-(const FourVectors& a, const FourVectors& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline FourVectors operator+(const FourVectors& a, const FourVectors& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline FourVectors operator*(const FourVectors& a, const Four& factor) {
  return {a.x * factor, a.y * factor, a.z * factor};
}

template <int... kPlaces>
Four picked(const Four& v) {
  return __builtin_shufflevector(v, v, kPlaces...);
}
/// The first three numbers moved on by one.
inline FourVectors rotated(const FourVectors& v) {
  return {picked<1, 2, 0, 0>(v.x), picked<1, 2, 0, 0>(v.y), picked<1, 2, 0, 0>(v.z)};
}
inline FourVectors cross(const FourVectors& a, const FourVectors& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Four dot(const FourVectors& a, const FourVectors& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Four larger(const Four& a, const Four& b) { return a > b ? a : b; }
inline Four smaller(const Four& a, const Four& b) { return a < b ? a : b; }
/// In all places.
inline Four greatest(const Four& v) {
  const Four of_two = larger(v, picked<2, 3, 0, 1>(v));
  return larger(of_two, picked<1, 0, 3, 2>(of_two));
}
inline double least(const Four& v) {
  const Four of_two = smaller(v, picked<2, 3, 0, 1>(v));
  return smaller(of_two, picked<1, 0, 3, 2>(of_two))[0];
}
inline Four root(const Four& v) {
#ifdef __AVX2__
  return _mm256_sqrt_pd(v);
#else
  return Four{std::sqrt(v[0]), std::sqrt(v[1]), std::sqrt(v[2]), std::sqrt(v[3])};
#endif
}

/// One bit a number.
inline unsigned bits(const FourFlags& flags) {
#if defined(__AVX2__)
  return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(flags)));
#elif defined(__SSE2__)
  __m128d half[2];
  std::memcpy(half, &flags, sizeof half);
  return static_cast<unsigned>(_mm_movemask_pd(half[0]) | _mm_movemask_pd(half[1]) << 2);
#else
  return static_cast<unsigned>((flags[0] & 1) | (flags[1] & 2) | (flags[2] & 4) | (flags[3] & 8));
#endif
}

inline Four either(const FourFlags& flags, const Four& yes, const Four& no) {
#ifdef __AVX2__
  return _mm256_blendv_pd(no, yes, reinterpret_cast<__m256d>(flags));
#else
  return flags ? yes : no;
#endif
}

/// With their numbers, counted from `first`, in place of the last bits; `count`: a power of two.
inline Four numbered(const Four& v, std::size_t first, std::size_t count) {
  const auto from = static_cast<long long>(first), most = static_cast<long long>(count - 1);
  const FourFlags number{from, from + 1, from + 2, from + 3};
  return reinterpret_cast<Four>((reinterpret_cast<FourFlags>(v) & ~most) | number);
}

/// Four of the rows of a table, turned: all their first numbers, all second ones, …
inline void turn(const double (*rows)[4], const std::uint16_t* row, Four (&turned)[4]) {
  const Four a = load(rows[row[0]]), b = load(rows[row[1]]);
  const Four c = load(rows[row[2]]), d = load(rows[row[3]]);
  const Four ab = __builtin_shufflevector(a, b, 0, 4, 2, 6);
  const Four ab_next = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Four cd = __builtin_shufflevector(c, d, 0, 4, 2, 6);
  const Four cd_next = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  turned[0] = __builtin_shufflevector(ab, cd, 0, 1, 4, 5);
  turned[1] = __builtin_shufflevector(ab_next, cd_next, 0, 1, 4, 5);
  turned[2] = __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
  turned[3] = __builtin_shufflevector(ab_next, cd_next, 2, 3, 6, 7);
}

}  // namespace
}  // namespace quoin::geometry
