#pragma once
/// Four numbers side by side as the compiler's own vectors, which it lays into the registers that
/// it compiles for. See kernels/kernels.hpp. Internal.

#ifdef __AVX2__
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
inline FourVectors operator-(const FourVectors& a, const FourVectors& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline FourVectors operator+(const FourVectors& a, const FourVectors& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline FourVectors operator*(const FourVectors& a, const Four& factor) {
  return {a.x * factor, a.y * factor, a.z * factor};
}

/// The first three numbers moved on by one.
inline Four rotated(const Four& v) { return Four{v[1], v[2], v[0], v[0]}; }
inline FourVectors rotated(const FourVectors& v) {
  return {rotated(v.x), rotated(v.y), rotated(v.z)};
}
inline FourVectors cross(const FourVectors& a, const FourVectors& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Four dot(const FourVectors& a, const FourVectors& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// One bit a number.
inline unsigned bits(const FourFlags& flags) {
#ifdef __AVX2__
  return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(flags)));
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

}  // namespace
}  // namespace quoin::geometry
