#pragma once
/// Four numbers side by side, in one register of AVX2: as PlainLanes, to the bit. Only for files
/// that are compiled for it. Internal.

#include <immintrin.h>

#include <cstddef>
#include <cstdint>

namespace quoin::geometry {
namespace {

struct Lanes256 {
  __m256d v;

  struct Flags {
    __m256d all;
    unsigned bits() const { return static_cast<unsigned>(_mm256_movemask_pd(all)); }
    Flags operator&(const Flags& b) const { return {_mm256_and_pd(all, b.all)}; }
    Flags operator|(const Flags& b) const { return {_mm256_or_pd(all, b.all)}; }
    Flags operator^(const Flags& b) const { return {_mm256_xor_pd(all, b.all)}; }
    Flags without(const Flags& b) const { return {_mm256_andnot_pd(b.all, all)}; }
  };
  static Flags only(std::size_t lane) {
    const __m256i lanes = _mm256_set_epi64x(3, 2, 1, 0);
    return {_mm256_castsi256_pd(
        _mm256_cmpeq_epi64(lanes, _mm256_set1_epi64x(static_cast<long long>(lane))))};
  }

  static Lanes256 picked(const double* row, const std::uint16_t* place) {
    return {_mm256_set_pd(row[place[3]], row[place[2]], row[place[1]], row[place[0]])};
  }
  static void turn(const double (*rows)[4], const std::uint16_t* row, Lanes256 (&turned)[4]) {
    const double *const a = rows[row[0]], *const b = rows[row[1]];
    const double *const c = rows[row[2]], *const d = rows[row[3]];
    for (int k = 0; k < 4; k += 2) {
      const __m256d ac = two_halves(a + k, c + k), bd = two_halves(b + k, d + k);
      turned[k] = {_mm256_unpacklo_pd(ac, bd)};
      turned[k + 1] = {_mm256_unpackhi_pd(ac, bd)};
    }
  }
  static Lanes256 of(double a, double b, double c, double d) { return {_mm256_set_pd(d, c, b, a)}; }
  static Lanes256 of(const double* row) { return {_mm256_load_pd(row)}; }
  static Lanes256 all(double x) { return {_mm256_set1_pd(x)}; }
  static void turned(const double* const (&place)[4], Lanes256& x, Lanes256& y, Lanes256& z) {
    const __m256i three = _mm256_set_epi64x(0, -1, -1, -1);
    const __m256d a = _mm256_maskload_pd(place[0], three), b = _mm256_maskload_pd(place[1], three);
    const __m256d c = _mm256_maskload_pd(place[2], three), d = _mm256_maskload_pd(place[3], three);
    const __m256d xz_ab = _mm256_unpacklo_pd(a, b), xz_cd = _mm256_unpacklo_pd(c, d);
    x.v = _mm256_permute2f128_pd(xz_ab, xz_cd, 0x20);
    y.v = _mm256_permute2f128_pd(_mm256_unpackhi_pd(a, b), _mm256_unpackhi_pd(c, d), 0x20);
    z.v = _mm256_permute2f128_pd(xz_ab, xz_cd, 0x31);
  }
  void store(double* row) const { _mm256_store_pd(row, v); }
  Lanes256 operator+(const Lanes256& b) const { return {_mm256_add_pd(v, b.v)}; }
  Lanes256 operator-(const Lanes256& b) const { return {_mm256_sub_pd(v, b.v)}; }
  Lanes256 operator*(const Lanes256& b) const { return {_mm256_mul_pd(v, b.v)}; }
  Lanes256 operator/(const Lanes256& b) const { return {_mm256_div_pd(v, b.v)}; }
  Lanes256 root() const { return {_mm256_sqrt_pd(v)}; }
  Lanes256 size() const { return {_mm256_andnot_pd(_mm256_set1_pd(-0.0), v)}; }
  Lanes256 smaller(const Lanes256& b) const { return {_mm256_min_pd(v, b.v)}; }
  Lanes256 larger(const Lanes256& b) const { return {_mm256_max_pd(v, b.v)}; }
  double least() const {
    const __m128d half = _mm_min_pd(_mm256_castpd256_pd128(v), _mm256_extractf128_pd(v, 1));
    return _mm_cvtsd_f64(_mm_min_sd(half, _mm_unpackhi_pd(half, half)));
  }
  Flags below(const Lanes256& b) const { return {_mm256_cmp_pd(v, b.v, _CMP_LT_OQ)}; }
  Lanes256 where(const Flags& flags, const Lanes256& other) const {
    return {_mm256_blendv_pd(other.v, v, flags.all)};
  }
  Lanes256 numbered(std::size_t first, std::size_t count) const {
    const __m256i number = _mm256_add_epi64(_mm256_set1_epi64x(static_cast<long long>(first)),
                                            _mm256_set_epi64x(3, 2, 1, 0));
    const __m256i bits = _mm256_andnot_si256(_mm256_set1_epi64x(static_cast<long long>(count - 1)),
                                             _mm256_castpd_si256(v));
    return {_mm256_castsi256_pd(_mm256_or_si256(bits, number))};
  }

 private:
  static __m256d two_halves(const double* low, const double* high) {
    return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_load_pd(low)), _mm_load_pd(high), 1);
  }
};

}  // namespace
}  // namespace quoin::geometry
