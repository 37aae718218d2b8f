#pragma once
/// Eight numbers side by side, once for each kind of wide instructions: to be built into functions
/// that are compiled for them as a whole. The same bits in all. Private to the room.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "wide_lanes.hpp"

#pragma GCC diagnostic ignored "-Wpsabi"  // all is built in, nothing is passed on

namespace quoin::geometry {

struct PlainEight {
  double v[8];

  /// Numbers of a row, by their places in it.
  static PlainEight picked(const double* row, const std::uint16_t* place) {
    return each([=](int k) { return row[place[k]]; });
  }
  /// Eight numbers on a 64-byte border.
  static PlainEight of(const double* row) {
    return each([row](int k) { return row[k]; });
  }
  static PlainEight all(double x) {
    return each([x](int) { return x; });
  }
  void store(double* row) const { std::copy(v, v + 8, row); }
  PlainEight operator+(const PlainEight& b) const {
    return each([&](int k) { return v[k] + b.v[k]; });
  }
  PlainEight operator-(const PlainEight& b) const {
    return each([&](int k) { return v[k] - b.v[k]; });
  }
  PlainEight operator*(const PlainEight& b) const {
    return each([&](int k) { return v[k] * b.v[k]; });
  }
  PlainEight operator/(const PlainEight& b) const {
    return each([&](int k) { return v[k] / b.v[k]; });
  }
  PlainEight root() const {
    return each([&](int k) { return std::sqrt(v[k]); });
  }
  PlainEight smaller(const PlainEight& b) const {
    return each([&](int k) { return v[k] < b.v[k] ? v[k] : b.v[k]; });
  }
  PlainEight larger(const PlainEight& b) const {
    return each([&](int k) { return v[k] > b.v[k] ? v[k] : b.v[k]; });
  }
  double least() const { return *std::min_element(v, v + 8); }
  /// Which are, one bit each.
  unsigned below(const PlainEight& b) const {
    unsigned bits = 0;
    for (int k = 0; k < 8; ++k) bits |= static_cast<unsigned>(v[k] < b.v[k]) << k;
    return bits;
  }
  /// These where a bit is set, else the others.
  PlainEight where(unsigned bits, const PlainEight& other) const {
    return each([&](int k) { return (bits >> k & 1) != 0 ? v[k] : other.v[k]; });
  }

 private:
  template <class Of>
  static PlainEight each(const Of& of) {
    PlainEight result;
    for (int k = 0; k < 8; ++k) result.v[k] = of(k);
    return result;
  }
};

#ifdef QUOIN_WIDE_LANES

struct Eight512 {
  __m512d v;

  QUOIN_AVX512 static Eight512 picked(const double* row, const std::uint16_t* place) {
    return {_mm512_set_pd(row[place[7]], row[place[6]], row[place[5]], row[place[4]], row[place[3]],
                          row[place[2]], row[place[1]], row[place[0]])};
  }
  QUOIN_AVX512 static Eight512 of(const double* row) { return {_mm512_load_pd(row)}; }
  QUOIN_AVX512 static Eight512 all(double x) { return {_mm512_set1_pd(x)}; }
  QUOIN_AVX512 void store(double* row) const { _mm512_store_pd(row, v); }
  QUOIN_AVX512 Eight512 operator+(const Eight512& b) const { return {_mm512_add_pd(v, b.v)}; }
  QUOIN_AVX512 Eight512 operator-(const Eight512& b) const { return {_mm512_sub_pd(v, b.v)}; }
  QUOIN_AVX512 Eight512 operator*(const Eight512& b) const { return {_mm512_mul_pd(v, b.v)}; }
  QUOIN_AVX512 Eight512 operator/(const Eight512& b) const { return {_mm512_div_pd(v, b.v)}; }
  QUOIN_AVX512 Eight512 root() const { return {_mm512_sqrt_pd(v)}; }
  QUOIN_AVX512 Eight512 smaller(const Eight512& b) const { return {_mm512_min_pd(v, b.v)}; }
  QUOIN_AVX512 Eight512 larger(const Eight512& b) const { return {_mm512_max_pd(v, b.v)}; }
  QUOIN_AVX512 double least() const { return _mm512_reduce_min_pd(v); }
  QUOIN_AVX512 unsigned below(const Eight512& b) const {
    return _mm512_cmp_pd_mask(v, b.v, _CMP_LT_OQ);
  }
  QUOIN_AVX512 Eight512 where(unsigned bits, const Eight512& other) const {
    return {_mm512_mask_mov_pd(other.v, static_cast<__mmask8>(bits), v)};
  }
};

struct Eight256 {
  __m256d low, high;

  QUOIN_AVX2 static Eight256 picked(const double* row, const std::uint16_t* place) {
    return {_mm256_set_pd(row[place[3]], row[place[2]], row[place[1]], row[place[0]]),
            _mm256_set_pd(row[place[7]], row[place[6]], row[place[5]], row[place[4]])};
  }
  QUOIN_AVX2 static Eight256 of(const double* row) {
    return {_mm256_load_pd(row), _mm256_load_pd(row + 4)};
  }
  QUOIN_AVX2 static Eight256 all(double x) { return {_mm256_set1_pd(x), _mm256_set1_pd(x)}; }
  QUOIN_AVX2 void store(double* row) const {
    _mm256_store_pd(row, low);
    _mm256_store_pd(row + 4, high);
  }
  QUOIN_AVX2 Eight256 operator+(const Eight256& b) const {
    return {_mm256_add_pd(low, b.low), _mm256_add_pd(high, b.high)};
  }
  QUOIN_AVX2 Eight256 operator-(const Eight256& b) const {
    return {_mm256_sub_pd(low, b.low), _mm256_sub_pd(high, b.high)};
  }
  QUOIN_AVX2 Eight256 operator*(const Eight256& b) const {
    return {_mm256_mul_pd(low, b.low), _mm256_mul_pd(high, b.high)};
  }
  QUOIN_AVX2 Eight256 operator/(const Eight256& b) const {
    return {_mm256_div_pd(low, b.low), _mm256_div_pd(high, b.high)};
  }
  QUOIN_AVX2 Eight256 root() const { return {_mm256_sqrt_pd(low), _mm256_sqrt_pd(high)}; }
  QUOIN_AVX2 Eight256 smaller(const Eight256& b) const {
    return {_mm256_min_pd(low, b.low), _mm256_min_pd(high, b.high)};
  }
  QUOIN_AVX2 Eight256 larger(const Eight256& b) const {
    return {_mm256_max_pd(low, b.low), _mm256_max_pd(high, b.high)};
  }
  QUOIN_AVX2 double least() const {
    alignas(32) double four[4];
    _mm256_store_pd(four, _mm256_min_pd(low, high));
    return std::min(std::min(four[0], four[1]), std::min(four[2], four[3]));
  }
  QUOIN_AVX2 unsigned below(const Eight256& b) const {
    const int first = _mm256_movemask_pd(_mm256_cmp_pd(low, b.low, _CMP_LT_OQ));
    const int second = _mm256_movemask_pd(_mm256_cmp_pd(high, b.high, _CMP_LT_OQ));
    return static_cast<unsigned>(first | second << 4);
  }
  QUOIN_AVX2 Eight256 where(unsigned bits, const Eight256& other) const {
    return {_mm256_blendv_pd(other.low, low, lanes(bits)),
            _mm256_blendv_pd(other.high, high, lanes(bits >> 4))};
  }

 private:
  QUOIN_AVX2 static __m256d lanes(unsigned bits) {
    const __m256i each = _mm256_set_epi64x(8, 4, 2, 1);
    const __m256i set = _mm256_and_si256(_mm256_set1_epi64x(bits), each);
    return _mm256_castsi256_pd(_mm256_cmpeq_epi64(set, each));
  }
};

#endif

}  // namespace quoin::geometry
