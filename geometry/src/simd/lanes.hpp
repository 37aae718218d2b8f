#pragma once
/// Four numbers side by side, once for each kind of wide instructions: to be built into functions
/// that are compiled for them as a whole. The same bits in all. Internal.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "simd/dispatch.hpp"

#pragma GCC diagnostic ignored "-Wpsabi"  // all is built in, nothing is passed on

namespace quoin::geometry {

struct PlainLanes {
  double v[4];

  struct Flags {
    unsigned all;
    unsigned bits() const { return all; }
  };
  static Flags only(std::size_t lane) { return {1u << lane}; }
  static Flags flags(unsigned bits) { return {bits}; }  ///< the lowest four

  /// Numbers of a row, by their places in it.
  static PlainLanes picked(const double* row, const std::uint16_t* place) {
    return each([=](int k) { return row[place[k]]; });
  }
  /// Four of the rows of a table, turned: all their first numbers, all second ones, …
  static void turn(const double (*rows)[4], const std::uint16_t* row, PlainLanes (&turned)[4]) {
    for (int k = 0; k < 4; ++k) {
      turned[k] = each([=](int i) { return rows[row[i]][k]; });
    }
  }
  static PlainLanes of(double a, double b, double c, double d) { return {{a, b, c, d}}; }
  /// Four numbers on a 32-byte border.
  static PlainLanes of(const double* row) {
    return each([row](int k) { return row[k]; });
  }
  static PlainLanes all(double x) {
    return each([x](int) { return x; });
  }
  /// Four places of three coordinates as rows.
  static void turned(const double* const (&place)[4], PlainLanes& x, PlainLanes& y, PlainLanes& z) {
    for (int k = 0; k < 4; ++k) {
      x.v[k] = place[k][0];
      y.v[k] = place[k][1];
      z.v[k] = place[k][2];
    }
  }
  /// Lanes 1, 2, 3 and the first of those that follow.
  PlainLanes shifted(const PlainLanes& after) const { return {{v[1], v[2], v[3], after.v[0]}}; }
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
  PlainLanes size() const {
    return each([&](int k) { return std::abs(v[k]); });
  }
  PlainLanes smaller(const PlainLanes& b) const {
    return each([&](int k) { return v[k] < b.v[k] ? v[k] : b.v[k]; });
  }
  PlainLanes larger(const PlainLanes& b) const {
    return each([&](int k) { return v[k] > b.v[k] ? v[k] : b.v[k]; });
  }
  double least() const { return *std::min_element(v, v + 4); }
  double greatest() const { return *std::max_element(v, v + 4); }
  double sum() const { return (v[0] + v[2]) + (v[1] + v[3]); }
  /// Which are.
  Flags below(const PlainLanes& b) const {
    unsigned bits = 0;
    for (int k = 0; k < 4; ++k) bits |= static_cast<unsigned>(v[k] < b.v[k]) << k;
    return {bits};
  }
  /// These where a flag is set, else the others.
  PlainLanes where(const Flags& flags, const PlainLanes& other) const {
    return each([&](int k) { return (flags.all >> k & 1) != 0 ? v[k] : other.v[k]; });
  }
  /// With its number, counted from `first`, in place of the last bits.
  PlainLanes numbered(std::size_t first, std::size_t count) const {
    return each([&](int k) {
      const auto bits = std::bit_cast<std::uint64_t>(v[k]) & ~(count - 1);
      return std::bit_cast<double>(bits | (first + static_cast<std::size_t>(k)));
    });
  }

 private:
  template <class Of>
  static PlainLanes each(const Of& of) {
    PlainLanes result;
    for (int k = 0; k < 4; ++k) result.v[k] = of(k);
    return result;
  }
};

// Without optimisation nothing is built in, and functions of different targets would return wide
// values in different places: plain loops there.
#if defined(QUOIN_WIDE_LANES) && defined(__OPTIMIZE__)
#define QUOIN_FOUR_WIDE_LANES

struct Lanes256 {
  __m256d v;

  struct Flags {
    __m256d all;
    QUOIN_AVX2 unsigned bits() const { return static_cast<unsigned>(_mm256_movemask_pd(all)); }
  };
  QUOIN_AVX2 static Flags flags(unsigned bits) {
    const __m256i each = _mm256_set_epi64x(8, 4, 2, 1);
    const __m256i set = _mm256_and_si256(_mm256_set1_epi64x(bits), each);
    return {_mm256_castsi256_pd(_mm256_cmpeq_epi64(set, each))};
  }
  QUOIN_AVX2 static Flags only(std::size_t lane) {
    const __m256i lanes = _mm256_set_epi64x(3, 2, 1, 0);
    return {_mm256_castsi256_pd(
        _mm256_cmpeq_epi64(lanes, _mm256_set1_epi64x(static_cast<long long>(lane))))};
  }

  QUOIN_AVX2 static Lanes256 picked(const double* row, const std::uint16_t* place) {
    return {_mm256_set_pd(row[place[3]], row[place[2]], row[place[1]], row[place[0]])};
  }
  QUOIN_AVX2 static void turn(const double (*rows)[4], const std::uint16_t* row,
                              Lanes256 (&turned)[4]) {
    const double *const a = rows[row[0]], *const b = rows[row[1]];
    const double *const c = rows[row[2]], *const d = rows[row[3]];
    for (int k = 0; k < 4; k += 2) {
      const __m256d ac = two_halves(a + k, c + k), bd = two_halves(b + k, d + k);
      turned[k] = {_mm256_unpacklo_pd(ac, bd)};
      turned[k + 1] = {_mm256_unpackhi_pd(ac, bd)};
    }
  }
  QUOIN_AVX2 static Lanes256 of(double a, double b, double c, double d) {
    return {_mm256_set_pd(d, c, b, a)};
  }
  QUOIN_AVX2 static Lanes256 of(const double* row) { return {_mm256_load_pd(row)}; }
  QUOIN_AVX2 static Lanes256 all(double x) { return {_mm256_set1_pd(x)}; }
  QUOIN_AVX2 static void turned(const double* const (&place)[4], Lanes256& x, Lanes256& y,
                                Lanes256& z) {
    const __m256i three = _mm256_set_epi64x(0, -1, -1, -1);
    const __m256d a = _mm256_maskload_pd(place[0], three), b = _mm256_maskload_pd(place[1], three);
    const __m256d c = _mm256_maskload_pd(place[2], three), d = _mm256_maskload_pd(place[3], three);
    const __m256d xz_ab = _mm256_unpacklo_pd(a, b), xz_cd = _mm256_unpacklo_pd(c, d);
    x.v = _mm256_permute2f128_pd(xz_ab, xz_cd, 0x20);
    y.v = _mm256_permute2f128_pd(_mm256_unpackhi_pd(a, b), _mm256_unpackhi_pd(c, d), 0x20);
    z.v = _mm256_permute2f128_pd(xz_ab, xz_cd, 0x31);
  }
  QUOIN_AVX2 Lanes256 shifted(const Lanes256& after) const {
    return {_mm256_permute4x64_pd(_mm256_blend_pd(v, after.v, 1), 0x39)};
  }
  QUOIN_AVX2 void store(double* row) const { _mm256_store_pd(row, v); }
  QUOIN_AVX2 Lanes256 operator+(const Lanes256& b) const { return {_mm256_add_pd(v, b.v)}; }
  QUOIN_AVX2 Lanes256 operator-(const Lanes256& b) const { return {_mm256_sub_pd(v, b.v)}; }
  QUOIN_AVX2 Lanes256 operator*(const Lanes256& b) const { return {_mm256_mul_pd(v, b.v)}; }
  QUOIN_AVX2 Lanes256 operator/(const Lanes256& b) const { return {_mm256_div_pd(v, b.v)}; }
  QUOIN_AVX2 Lanes256 root() const { return {_mm256_sqrt_pd(v)}; }
  QUOIN_AVX2 Lanes256 size() const { return {_mm256_andnot_pd(_mm256_set1_pd(-0.0), v)}; }
  QUOIN_AVX2 Lanes256 smaller(const Lanes256& b) const { return {_mm256_min_pd(v, b.v)}; }
  QUOIN_AVX2 Lanes256 larger(const Lanes256& b) const { return {_mm256_max_pd(v, b.v)}; }
  QUOIN_AVX2 double least() const {
    const __m128d half = _mm_min_pd(_mm256_castpd256_pd128(v), _mm256_extractf128_pd(v, 1));
    return _mm_cvtsd_f64(_mm_min_sd(half, _mm_unpackhi_pd(half, half)));
  }
  QUOIN_AVX2 double greatest() const {
    const __m128d half = _mm_max_pd(_mm256_castpd256_pd128(v), _mm256_extractf128_pd(v, 1));
    return _mm_cvtsd_f64(_mm_max_sd(half, _mm_unpackhi_pd(half, half)));
  }
  QUOIN_AVX2 double sum() const {
    const __m128d half = _mm_add_pd(_mm256_castpd256_pd128(v), _mm256_extractf128_pd(v, 1));
    return _mm_cvtsd_f64(_mm_add_sd(half, _mm_unpackhi_pd(half, half)));
  }
  QUOIN_AVX2 Flags below(const Lanes256& b) const { return {_mm256_cmp_pd(v, b.v, _CMP_LT_OQ)}; }
  QUOIN_AVX2 Lanes256 where(const Flags& flags, const Lanes256& other) const {
    return {_mm256_blendv_pd(other.v, v, flags.all)};
  }
  QUOIN_AVX2 Lanes256 numbered(std::size_t first, std::size_t count) const {
    const __m256i number = _mm256_add_epi64(_mm256_set1_epi64x(static_cast<long long>(first)),
                                            _mm256_set_epi64x(3, 2, 1, 0));
    const __m256i bits = _mm256_andnot_si256(_mm256_set1_epi64x(static_cast<long long>(count - 1)),
                                             _mm256_castpd_si256(v));
    return {_mm256_castsi256_pd(_mm256_or_si256(bits, number))};
  }

 private:
  QUOIN_AVX2 static __m256d two_halves(const double* low, const double* high) {
    return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_load_pd(low)), _mm_load_pd(high), 1);
  }
};

#endif

}  // namespace quoin::geometry
