#pragma once
/// Four numbers side by side, which the compiler lays into whatever registers the machine has.
/// Internal.

#include "simd/dispatch.hpp"

#pragma GCC diagnostic ignored "-Wpsabi"  // all is built into the functions that use it

namespace quoin::geometry {

/// Four numbers side by side: the compiler makes of them what the machine has.
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

struct PlainFlags {
  static unsigned of_four(const FourFlags& flags) {
    return static_cast<unsigned>((flags[0] & 1) | (flags[1] & 2) | (flags[2] & 4) | (flags[3] & 8));
  }
  static void choose(const FourFlags& flags, const Four& yes, const Four& no, Four& chosen) {
    chosen = flags ? yes : no;
  }
  static void spread(const double& value, Four& all) { all = four(value); }
};
#ifdef QUOIN_WIDE_LANES
struct WideFlags {
  QUOIN_AVX2 static unsigned of_four(const FourFlags& flags) {
    return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(flags)));
  }
  QUOIN_AVX2 static void choose(const FourFlags& flags, const Four& yes, const Four& no,
                                Four& chosen) {
    chosen = _mm256_blendv_pd(no, yes, reinterpret_cast<__m256d>(flags));
  }
  QUOIN_AVX2 static void spread(const double& value, Four& all) {
    all = _mm256_broadcast_sd(&value);
  }
};
#endif

// Functions of different targets hand wide values on by reference only: they return them in
// different places.
template <class Flags>
Four either(const FourFlags& flags, const Four& yes, const Four& no) {
  Four chosen;
  Flags::choose(flags, yes, no, chosen);
  return chosen;
}
template <class Flags>
Four spread(const double& value) {
  Four all;
  Flags::spread(value, all);
  return all;
}

}  // namespace quoin::geometry
