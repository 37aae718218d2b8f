#pragma once
/// The scans of scan.hpp in AVX-512: the same bits. Only for files that are compiled for it.
/// Internal.

#include <immintrin.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <type_traits>

#include "shape/scan.hpp"

namespace quoin::geometry {
namespace {

struct Wide512 {
  __m512d x, y, z;
  explicit Wide512(const Vec3& d)
      : x(_mm512_set1_pd(d.x)), y(_mm512_set1_pd(d.y)), z(_mm512_set1_pd(d.z)) {}
  Wide512(__m512d a, __m512d b, __m512d c) : x(a), y(b), z(c) {}
  __m512d along(const Rows& rows, int v) const {
    const __m512d sum = _mm512_add_pd(_mm512_mul_pd(_mm512_load_pd(rows.x + v), x),
                                      _mm512_mul_pd(_mm512_load_pd(rows.y + v), y));
    return _mm512_add_pd(sum, _mm512_mul_pd(_mm512_load_pd(rows.z + v), z));
  }
  Wide512 reversed() const {
    const __m512d sign = _mm512_set1_pd(-0.0);
    return {_mm512_xor_pd(x, sign), _mm512_xor_pd(y, sign), _mm512_xor_pd(z, sign)};
  }
  /// Which of the vertices v … v + 7 reach the limit.
  unsigned reaching(const Rows& rows, int v, __m512d limit) const {
    const unsigned mask = _mm512_cmp_pd_mask(along(rows, v), limit, _CMP_GE_OQ);
    return rows.count - v < 8 ? mask & ((1u << (rows.count - v)) - 1u) : mask;
  }
};

/// Largest of eight lanes, in all lanes.
inline __m512d greatest_lane(__m512d v) {
  v = _mm512_max_pd(v, _mm512_shuffle_f64x2(v, v, 0x4e));
  v = _mm512_max_pd(v, _mm512_shuffle_f64x2(v, v, 0xb1));
  return _mm512_max_pd(v, _mm512_permute_pd(v, 0x55));
}

inline unsigned equal_lanes(__m512d a, __m512d b) {
  return _mm512_cmp_pd_mask(a, b, _CMP_EQ_OQ);
}

/// Up to 8 vertices; up to 16; up to 32: all products in registers, one mask of the greatest.
inline Support support_of_eight(__m512d value) {
  const __m512d greatest = greatest_lane(value);
  return {__builtin_ctz(equal_lanes(value, greatest) | 0x100u) & 7,
          _mm512_cvtsd_f64(greatest) + 0.0};
}

inline Support support_of_16(const Rows& rows, const Wide512& wide) {
  const __m512d a = wide.along(rows, 0), b = wide.along(rows, 8);
  const __m512d greatest = greatest_lane(_mm512_max_pd(a, b));
  const unsigned equal = equal_lanes(a, greatest) | equal_lanes(b, greatest) << 8;
  return {std::countr_zero(equal) & 15, _mm512_cvtsd_f64(greatest) + 0.0};
}

inline Support support_of_32(const Rows& rows, const Wide512& wide) {
  const __m512d a = wide.along(rows, 0), b = wide.along(rows, 8), c = wide.along(rows, 16);
  const __m512d e = rows.padded > 24 ? wide.along(rows, 24) : c;
  const __m512d greatest = greatest_lane(_mm512_max_pd(_mm512_max_pd(a, b), _mm512_max_pd(c, e)));
  const unsigned equal = equal_lanes(a, greatest) | equal_lanes(b, greatest) << 8 |
                         equal_lanes(c, greatest) << 16 | equal_lanes(e, greatest) << 24;
  return {std::countr_zero(equal) & 31, _mm512_cvtsd_f64(greatest) + 0.0};
}

/// Up to 64, where the last block stands for those that are missing: its first place counts.
inline Support support_of_64(const Rows& rows, const Wide512& wide) {
  __m512d value[8], most = value[0] = wide.along(rows, 0);
  for (int k = 1; k < 8; ++k) {
    value[k] = wide.along(rows, std::min(8 * k, rows.padded - 8));
    most = _mm512_max_pd(most, value[k]);
  }
  most = greatest_lane(most);
  std::uint64_t equal = 0;
  for (int k = 0; k < 8; ++k) equal |= std::uint64_t{equal_lanes(value[k], most)} << 8 * k;
  return {std::countr_zero(equal) & 63, _mm512_cvtsd_f64(most) + 0.0};
}

inline Support support_512(const Rows& rows, const Wide512& wide) {
  if (rows.padded == 8) return support_of_eight(wide.along(rows, 0));
  if (rows.padded == 16) return support_of_16(rows, wide);
  if (rows.padded <= 32) return support_of_32(rows, wide);
  if (rows.padded <= 64) return support_of_64(rows, wide);
  __m512d best = wide.along(rows, 0);
  // Two chains of blocks, even and odd, so that the comparisons do not wait for each other;
  // no branch hangs on the values.
  __m512d odd = wide.along(rows, 8);
  __m512i block = _mm512_setzero_si512(), odd_block = _mm512_set1_epi64(8);
  int v = 16;
  for (; v + 8 < rows.padded; v += 16) {
    const __m512d a = wide.along(rows, v), b = wide.along(rows, v + 8);
    const __mmask8 more_a = _mm512_cmp_pd_mask(a, best, _CMP_GT_OQ);
    const __mmask8 more_b = _mm512_cmp_pd_mask(b, odd, _CMP_GT_OQ);
    best = _mm512_mask_mov_pd(best, more_a, a);
    odd = _mm512_mask_mov_pd(odd, more_b, b);
    block = _mm512_mask_set1_epi64(block, more_a, v);
    odd_block = _mm512_mask_set1_epi64(odd_block, more_b, v + 8);
  }
  if (v < rows.padded) {
    const __m512d a = wide.along(rows, v);
    const __mmask8 more = _mm512_cmp_pd_mask(a, best, _CMP_GT_OQ);
    best = _mm512_mask_mov_pd(best, more, a);
    block = _mm512_mask_set1_epi64(block, more, v);
  }
  // The lowest index among the greatest: lanes count within a block.
  const __m512d greatest = greatest_lane(_mm512_max_pd(best, odd));
  const __m512i lane = _mm512_set_epi64(7, 6, 5, 4, 3, 2, 1, 0);
  const __m512i none = _mm512_set1_epi64(1 << 30);
  const __m512i even_index =
      _mm512_mask_add_epi64(none, _mm512_cmp_pd_mask(best, greatest, _CMP_EQ_OQ), block, lane);
  const __m512i odd_index =
      _mm512_mask_add_epi64(none, _mm512_cmp_pd_mask(odd, greatest, _CMP_EQ_OQ), odd_block, lane);
  const long long lowest = _mm512_reduce_min_epi64(_mm512_min_epi64(even_index, odd_index));
  return {static_cast<int>(lowest) & ((1 << 30) - 1), _mm512_cvtsd_f64(greatest) + 0.0};
}

inline void beyond_512(const Rows& rows, const Vec3& d, double value,
                                    VertexSet& vertices) {
  const Wide512 wide(d);
  const __m512d limit = _mm512_set1_pd(value);
  for (int v = 0; v < rows.count; v += 8) {
    unsigned mask = wide.reaching(rows, v, limit);
    for (; mask != 0; mask &= mask - 1) vertices.push_back(v + __builtin_ctz(mask));
  }
}

inline int count_512(const Rows& rows, const Vec3& d, double value) {
  const Wide512 wide(d);
  const __m512d limit = _mm512_set1_pd(value);
  int count = 0;
  for (int v = 0; v < rows.count; v += 8)
    count += __builtin_popcount(wide.reaching(rows, v, limit));
  return count;
}

struct Scan512 {
  static constexpr bool kFused = true;
  static Support support(const Rows& rows, const Vec3& d) {
    return support_512(rows, Wide512(d));
  }
  static void beyond(const Rows& rows, const Vec3& d, double value, VertexSet& vertices) {
    beyond_512(rows, d, value, vertices);
  }
  template <class AnyRows>
  static PairSupport support_pair(const AnyRows& p, const AnyRows& q, const Vec3& d) {
    if constexpr (std::is_same_v<AnyRows, StraightRows>) {
      const Wide512 wide(d);
      return {support_512(p, wide), support_512(q, wide.reversed())};
    }
    return {support_512(p, Wide512(p.local(d))), support_512(q, Wide512(q.local(-d)))};
  }
  static int count_beyond(const Rows& rows, const Vec3& d, double value) {
    return count_512(rows, d, value);
  }
};

}  // namespace
}  // namespace quoin::geometry
