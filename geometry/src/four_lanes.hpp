#pragma once
/// Four numbers side by side, once for each kind of wide instructions: to be built into functions
/// that are compiled for them as a whole. The same bits in all. Private to the room.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "wide_lanes.hpp"

#pragma GCC diagnostic ignored "-Wpsabi"  // all is built in, nothing is passed on

namespace quoin::geometry {

struct PlainLanes {
  double v[4];

  /// Numbers of a row, by their places in it.
  static PlainLanes picked(const double* row, const std::uint16_t* place) {
    return each([=](int k) { return row[place[k]]; });
  }
  /// Four numbers on a 32-byte border.
  static PlainLanes of(const double* row) {
    return each([row](int k) { return row[k]; });
  }
  static PlainLanes all(double x) {
    return each([x](int) { return x; });
  }
  void store(double* row) const { std::copy(v, v + 4, row); }
  PlainLanes operator+(const PlainLanes& b) const {
    return each([&](int k) { return v[k] + b.v[k]; });
  }
  PlainLanes operator-(const PlainLanes& b) const {
    return each([&](int k) { return v[k] - b.v[k]; });
  }
  PlainLanes operator*(const PlainLanes& b) const {
    return each([&](int k) { return v[k] * b.v[k]; });
  }
  PlainLanes operator/(const PlainLanes& b) const {
    return each([&](int k) { return v[k] / b.v[k]; });
  }
  PlainLanes root() const {
    return each([&](int k) { return std::sqrt(v[k]); });
  }
  PlainLanes smaller(const PlainLanes& b) const {
    return each([&](int k) { return v[k] < b.v[k] ? v[k] : b.v[k]; });
  }
  PlainLanes larger(const PlainLanes& b) const {
    return each([&](int k) { return v[k] > b.v[k] ? v[k] : b.v[k]; });
  }
  double least() const { return *std::min_element(v, v + 4); }
  /// Which are, one bit each.
  unsigned below(const PlainLanes& b) const {
    unsigned bits = 0;
    for (int k = 0; k < 4; ++k) bits |= static_cast<unsigned>(v[k] < b.v[k]) << k;
    return bits;
  }
  /// These where a bit is set, else the others.
  PlainLanes where(unsigned bits, const PlainLanes& other) const {
    return each([&](int k) { return (bits >> k & 1) != 0 ? v[k] : other.v[k]; });
  }

 private:
  template <class Of>
  static PlainLanes each(const Of& of) {
    PlainLanes result;
    for (int k = 0; k < 4; ++k) result.v[k] = of(k);
    return result;
  }
};

#ifdef QUOIN_WIDE_LANES

struct Lanes256 {
  __m256d v;

  QUOIN_AVX2 static Lanes256 picked(const double* row, const std::uint16_t* place) {
    return {_mm256_set_pd(row[place[3]], row[place[2]], row[place[1]], row[place[0]])};
  }
  QUOIN_AVX2 static Lanes256 of(const double* row) { return {_mm256_load_pd(row)}; }
  QUOIN_AVX2 static Lanes256 all(double x) { return {_mm256_set1_pd(x)}; }
  QUOIN_AVX2 void store(double* row) const { _mm256_store_pd(row, v); }
  QUOIN_AVX2 Lanes256 operator+(const Lanes256& b) const { return {_mm256_add_pd(v, b.v)}; }
  QUOIN_AVX2 Lanes256 operator-(const Lanes256& b) const { return {_mm256_sub_pd(v, b.v)}; }
  QUOIN_AVX2 Lanes256 operator*(const Lanes256& b) const { return {_mm256_mul_pd(v, b.v)}; }
  QUOIN_AVX2 Lanes256 operator/(const Lanes256& b) const { return {_mm256_div_pd(v, b.v)}; }
  QUOIN_AVX2 Lanes256 root() const { return {_mm256_sqrt_pd(v)}; }
  QUOIN_AVX2 Lanes256 smaller(const Lanes256& b) const { return {_mm256_min_pd(v, b.v)}; }
  QUOIN_AVX2 Lanes256 larger(const Lanes256& b) const { return {_mm256_max_pd(v, b.v)}; }
  QUOIN_AVX2 double least() const {
    const __m128d half = _mm_min_pd(_mm256_castpd256_pd128(v), _mm256_extractf128_pd(v, 1));
    return _mm_cvtsd_f64(_mm_min_sd(half, _mm_unpackhi_pd(half, half)));
  }
  QUOIN_AVX2 unsigned below(const Lanes256& b) const {
    return static_cast<unsigned>(_mm256_movemask_pd(_mm256_cmp_pd(v, b.v, _CMP_LT_OQ)));
  }
  QUOIN_AVX2 Lanes256 where(unsigned bits, const Lanes256& other) const {
    const __m256i each = _mm256_set_epi64x(8, 4, 2, 1);
    const __m256i set = _mm256_and_si256(_mm256_set1_epi64x(bits), each);
    return {_mm256_blendv_pd(other.v, v, _mm256_castsi256_pd(_mm256_cmpeq_epi64(set, each)))};
  }
};

#endif

}  // namespace quoin::geometry
