#pragma once
/// The scans behind support.hpp, once for each kind of wide instructions: to be built into loops
/// that are compiled for them as a whole. Internal.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <type_traits>

#include "numeric/vec3.hpp"
#include "shape/support.hpp"
#include "simd/dispatch.hpp"
#include "simd/four.hpp"

namespace quoin::geometry {

/// Rows of a shape's offsets. The scans take directions in the shape's frame: `local` turns them.
struct Rows {
  const double *x, *y, *z;
  int padded;
  int count;
  const Solid* solid;
  explicit Rows(const Solid&& of) = delete;
  explicit Rows(const Solid& of)
      : x(of.shape().offsets()),
        y(x + of.padded_count()),
        z(y + of.padded_count()),
        padded(of.padded_count()),
        count(of.vertex_count()),
        solid(&of) {}
  Vec3 local(const Vec3& direction) const { return solid->turned_back(direction); }
  Vec3 offset(int v) const { return {x[v], y[v], z[v]}; }
  Vec3 placed(int v) const { return solid->turn(offset(v)); }  ///< the same turned as the body is
  double along(int v, const Vec3& d) const { return dot(offset(v), d); }
};

/// Rows of a body that is not turned, for loops where asking each time would cost.
struct StraightRows : Rows {
  using Rows::Rows;
  static Vec3 local(const Vec3& direction) { return direction; }
  Vec3 placed(int v) const { return offset(v); }
};

inline Support narrow_support(const Rows& rows, const Vec3& d) {
  Support best{0, rows.along(0, d)};
  for (int v = 1; v < rows.padded; ++v) {
    const double value = rows.along(v, d);
    if (value > best.value) best = {v, value};
  }
  best.value += 0.0;  // one zero only: -0 would tell the variants apart
  return best;
}

inline void narrow_beyond(const Rows& rows, const Vec3& d, double value, VertexSet& vertices) {
  for (int v = 0; v < rows.count; ++v) {
    if (rows.along(v, d) >= value) vertices.push_back(v);
  }
}

inline int narrow_count(const Rows& rows, const Vec3& d, double value) {
  int count = 0;
  for (int v = 0; v < rows.count; ++v) {
    count += rows.along(v, d) >= value ? 1 : 0;
  }
  return count;
}

#ifdef QUOIN_WIDE_LANES

struct Wide512 {
  __m512d x, y, z;
  QUOIN_AVX512 explicit Wide512(const Vec3& d)
      : x(_mm512_set1_pd(d.x)), y(_mm512_set1_pd(d.y)), z(_mm512_set1_pd(d.z)) {}
  QUOIN_AVX512 Wide512(__m512d a, __m512d b, __m512d c) : x(a), y(b), z(c) {}
  QUOIN_AVX512 __m512d along(const Rows& rows, int v) const {
    const __m512d sum = _mm512_add_pd(_mm512_mul_pd(_mm512_load_pd(rows.x + v), x),
                                      _mm512_mul_pd(_mm512_load_pd(rows.y + v), y));
    return _mm512_add_pd(sum, _mm512_mul_pd(_mm512_load_pd(rows.z + v), z));
  }
  QUOIN_AVX512 Wide512 reversed() const {
    const __m512d sign = _mm512_set1_pd(-0.0);
    return {_mm512_xor_pd(x, sign), _mm512_xor_pd(y, sign), _mm512_xor_pd(z, sign)};
  }
  /// Which of the vertices v … v + 7 reach the limit.
  QUOIN_AVX512 unsigned reaching(const Rows& rows, int v, __m512d limit) const {
    const unsigned mask = _mm512_cmp_pd_mask(along(rows, v), limit, _CMP_GE_OQ);
    return rows.count - v < 8 ? mask & ((1u << (rows.count - v)) - 1u) : mask;
  }
};

/// Largest of eight lanes, in all lanes.
QUOIN_AVX512 inline __m512d greatest_lane(__m512d v) {
  v = _mm512_max_pd(v, _mm512_shuffle_f64x2(v, v, 0x4e));
  v = _mm512_max_pd(v, _mm512_shuffle_f64x2(v, v, 0xb1));
  return _mm512_max_pd(v, _mm512_permute_pd(v, 0x55));
}

QUOIN_AVX512 inline unsigned equal_lanes(__m512d a, __m512d b) {
  return _mm512_cmp_pd_mask(a, b, _CMP_EQ_OQ);
}

/// Up to 8 vertices; up to 16; up to 32: all products in registers, one mask of the greatest.
QUOIN_AVX512 inline Support support_of_eight(__m512d value) {
  const __m512d greatest = greatest_lane(value);
  return {__builtin_ctz(equal_lanes(value, greatest) | 0x100u) & 7,
          _mm512_cvtsd_f64(greatest) + 0.0};
}

QUOIN_AVX512 inline Support support_of_16(const Rows& rows, const Wide512& wide) {
  const __m512d a = wide.along(rows, 0), b = wide.along(rows, 8);
  const __m512d greatest = greatest_lane(_mm512_max_pd(a, b));
  const unsigned equal = equal_lanes(a, greatest) | equal_lanes(b, greatest) << 8;
  return {std::countr_zero(equal) & 15, _mm512_cvtsd_f64(greatest) + 0.0};
}

QUOIN_AVX512 inline Support support_of_32(const Rows& rows, const Wide512& wide) {
  const __m512d a = wide.along(rows, 0), b = wide.along(rows, 8), c = wide.along(rows, 16);
  const __m512d e = rows.padded > 24 ? wide.along(rows, 24) : c;
  const __m512d greatest = greatest_lane(_mm512_max_pd(_mm512_max_pd(a, b), _mm512_max_pd(c, e)));
  const unsigned equal = equal_lanes(a, greatest) | equal_lanes(b, greatest) << 8 |
                         equal_lanes(c, greatest) << 16 | equal_lanes(e, greatest) << 24;
  return {std::countr_zero(equal) & 31, _mm512_cvtsd_f64(greatest) + 0.0};
}

/// Up to 64, where the last block stands for those that are missing: its first place counts.
QUOIN_AVX512 inline Support support_of_64(const Rows& rows, const Wide512& wide) {
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

QUOIN_AVX512 inline Support support_512(const Rows& rows, const Wide512& wide) {
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

QUOIN_AVX512 inline void beyond_512(const Rows& rows, const Vec3& d, double value,
                                    VertexSet& vertices) {
  const Wide512 wide(d);
  const __m512d limit = _mm512_set1_pd(value);
  for (int v = 0; v < rows.count; v += 8) {
    unsigned mask = wide.reaching(rows, v, limit);
    for (; mask != 0; mask &= mask - 1) vertices.push_back(v + __builtin_ctz(mask));
  }
}

QUOIN_AVX512 inline int count_512(const Rows& rows, const Vec3& d, double value) {
  const Wide512 wide(d);
  const __m512d limit = _mm512_set1_pd(value);
  int count = 0;
  for (int v = 0; v < rows.count; v += 8)
    count += __builtin_popcount(wide.reaching(rows, v, limit));
  return count;
}

struct Wide256 {
  __m256d x, y, z;
  QUOIN_AVX2 explicit Wide256(const Vec3& d)
      : x(_mm256_set1_pd(d.x)), y(_mm256_set1_pd(d.y)), z(_mm256_set1_pd(d.z)) {}
  QUOIN_AVX2 Wide256(__m256d a, __m256d b, __m256d c) : x(a), y(b), z(c) {}
  QUOIN_AVX2 __m256d along(const Rows& rows, int v) const {
    const __m256d sum = _mm256_add_pd(_mm256_mul_pd(_mm256_load_pd(rows.x + v), x),
                                      _mm256_mul_pd(_mm256_load_pd(rows.y + v), y));
    return _mm256_add_pd(sum, _mm256_mul_pd(_mm256_load_pd(rows.z + v), z));
  }
  QUOIN_AVX2 Wide256 reversed() const {
    const __m256d sign = _mm256_set1_pd(-0.0);
    return {_mm256_xor_pd(x, sign), _mm256_xor_pd(y, sign), _mm256_xor_pd(z, sign)};
  }
  /// Which of the vertices v … v + 3 reach the limit.
  QUOIN_AVX2 unsigned reaching(const Rows& rows, int v, __m256d limit) const {
    const __m256d hit = _mm256_cmp_pd(along(rows, v), limit, _CMP_GE_OQ);
    const auto mask = static_cast<unsigned>(_mm256_movemask_pd(hit));
    return rows.count - v < 4 ? mask & ((1u << (rows.count - v)) - 1u) : mask;
  }
};

/// Greatest of four lanes, in all lanes.
QUOIN_AVX2 inline __m256d greatest_lane(__m256d v) {
  v = _mm256_max_pd(v, _mm256_permute2f128_pd(v, v, 1));
  return _mm256_max_pd(v, _mm256_permute_pd(v, 5));
}

/// All products in registers, one mask of the greatest. `Fours`: of four vertices.
template <int Fours>
QUOIN_AVX2 Support support_of_few(const Rows& rows, const Wide256& wide) {
  __m256d value[Fours], most = value[0] = wide.along(rows, 0);
  for (int k = 1; k < Fours; ++k) {
    value[k] = wide.along(rows, 4 * k);
    most = _mm256_max_pd(most, value[k]);
  }
  most = greatest_lane(most);
  std::uint32_t equal = 0;
  for (int k = 0; k < Fours; ++k) {
    const __m256d same = _mm256_cmp_pd(value[k], most, _CMP_EQ_OQ);
    equal |= static_cast<std::uint32_t>(_mm256_movemask_pd(same)) << 4 * k;
  }
  return {std::countr_zero(equal) & 31, _mm256_cvtsd_f64(most) + 0.0};
}

QUOIN_AVX2 inline Support support_256(const Rows& rows, const Wide256& wide) {
  if (rows.padded == 8) return support_of_few<2>(rows, wide);
  if (rows.padded == 16) return support_of_few<4>(rows, wide);
  if (rows.padded == 24) return support_of_few<6>(rows, wide);
  if (rows.padded == 32) return support_of_few<8>(rows, wide);
  __m256d best = wide.along(rows, 0), odd = wide.along(rows, 4);
  __m256d block = _mm256_setzero_pd(), odd_block = _mm256_set1_pd(4);  // exact in doubles
  for (int v = 8; v < rows.padded; v += 8) {
    const __m256d a = wide.along(rows, v), b = wide.along(rows, v + 4);
    const __m256d more_a = _mm256_cmp_pd(a, best, _CMP_GT_OQ);
    const __m256d more_b = _mm256_cmp_pd(b, odd, _CMP_GT_OQ);
    best = _mm256_max_pd(a, best);
    odd = _mm256_max_pd(b, odd);
    block = _mm256_blendv_pd(block, _mm256_set1_pd(v), more_a);
    odd_block = _mm256_blendv_pd(odd_block, _mm256_set1_pd(v + 4), more_b);
  }
  // The lowest index among the greatest: lanes count within a block.
  const __m256d greatest = greatest_lane(_mm256_max_pd(best, odd));
  const __m256d lane = _mm256_set_pd(3, 2, 1, 0), none = _mm256_set1_pd(1 << 30);
  const __m256d even_index =
      _mm256_blendv_pd(none, _mm256_add_pd(block, lane), _mm256_cmp_pd(best, greatest, _CMP_EQ_OQ));
  const __m256d odd_index = _mm256_blendv_pd(none, _mm256_add_pd(odd_block, lane),
                                             _mm256_cmp_pd(odd, greatest, _CMP_EQ_OQ));
  const __m256d sign = _mm256_set1_pd(-0.0);
  const __m256d lowest = greatest_lane(_mm256_xor_pd(_mm256_min_pd(even_index, odd_index), sign));
  return {static_cast<int>(-_mm256_cvtsd_f64(lowest)) & ((1 << 30) - 1),
          _mm256_cvtsd_f64(greatest) + 0.0};
}

/// `Fours`: of four vertices.
template <int Fours>
QUOIN_AVX2 bool alone_256(const Rows& rows, const Vec3& d, const Carriers& carriers, Support& top) {
  const Wide256 wide(d);
  __m256d value[Fours], most = value[0] = wide.along(rows, 0);
  for (int k = 1; k < Fours; ++k) {
    value[k] = wide.along(rows, 4 * k);
    most = _mm256_max_pd(most, value[k]);
  }
  most = greatest_lane(most);
  const __m256d flat = _mm256_sub_pd(most, _mm256_set1_pd(carriers.flat));
  const __m256d clear = _mm256_sub_pd(most, _mm256_set1_pd(carriers.clear));
  std::uint32_t highest = 0, near = 0, beyond = 0, set = 0;
  const auto bits = [](__m256d mask, int k) QUOIN_AVX2 {
    return static_cast<std::uint32_t>(_mm256_movemask_pd(mask)) << 4 * k;
  };
  for (int k = 0; k < Fours; ++k) {
    highest |= bits(_mm256_cmp_pd(value[k], most, _CMP_EQ_OQ), k);
    near |= bits(_mm256_cmp_pd(value[k], flat, _CMP_GE_OQ), k);
    beyond |= bits(_mm256_cmp_pd(value[k], clear, _CMP_GE_OQ), k);
  }
  for (const int v : carriers.set) set |= std::uint32_t{1} << v;
  const std::uint32_t valid = ~std::uint32_t{0} >> (32 - rows.count);
  top = {std::countr_zero(highest) & 31, _mm256_cvtsd_f64(most) + 0.0};
  return (near & valid) == set && (beyond & valid) == set;
}

QUOIN_AVX2 inline void beyond_256(const Rows& rows, const Vec3& d, double value,
                                  VertexSet& vertices) {
  const Wide256 wide(d);
  const __m256d limit = _mm256_set1_pd(value);
  for (int v = 0; v < rows.count; v += 4) {
    unsigned mask = wide.reaching(rows, v, limit);
    for (; mask != 0; mask &= mask - 1) vertices.push_back(v + __builtin_ctz(mask));
  }
}

/// `Fours`: of four vertices.
template <int Fours>
QUOIN_AVX2 int count_of_few(const Rows& rows, const Wide256& wide, __m256d limit) {
  std::uint32_t reached = 0;
  for (int k = 0; k < Fours; ++k) {
    const __m256d hit = _mm256_cmp_pd(wide.along(rows, 4 * k), limit, _CMP_GE_OQ);
    reached |= static_cast<std::uint32_t>(_mm256_movemask_pd(hit)) << 4 * k;
  }
  return std::popcount(reached & (~std::uint32_t{0} >> (32 - rows.count)));
}

QUOIN_AVX2 inline int count_256(const Rows& rows, const Vec3& d, double value) {
  const Wide256 wide(d);
  const __m256d limit = _mm256_set1_pd(value);
  if (rows.padded == 8) return count_of_few<2>(rows, wide, limit);
  if (rows.padded == 16) return count_of_few<4>(rows, wide, limit);
  if (rows.padded == 24) return count_of_few<6>(rows, wide, limit);
  if (rows.padded == 32) return count_of_few<8>(rows, wide, limit);
  int count = 0;
  for (int v = 0; v < rows.count; v += 4)
    count += __builtin_popcount(wide.reaching(rows, v, limit));
  return count;
}

#endif

/// So few that scans of 256 bits are worth more: beside instructions of 512 bits the machine has
/// fewer units for all the others.
inline bool few_vertices(const Solid& p, const Solid& q) {
  return std::max(p.padded_count(), q.padded_count()) <= 32;
}

/// The scans of one kind of instructions under one name each. Directions are those of the shape's
/// frame, of a pair those of the world.
struct PlainScan {
  static constexpr bool kFused = false;
  using Flags = PlainFlags;
  static Support support(const Rows& rows, const Vec3& d) { return narrow_support(rows, d); }
  template <class AnyRows>
  static PairSupport support_pair(const AnyRows& p, const AnyRows& q, const Vec3& d) {
    return {narrow_support(p, p.local(d)), narrow_support(q, q.local(-d))};
  }
  static int count_beyond(const Rows& rows, const Vec3& d, double value) {
    return narrow_count(rows, d, value);
  }
  static bool carried_alone(const Rows& rows, const Vec3& d, const Carriers& carriers,
                            Support& top) {
    top = narrow_support(rows, d);
    const auto only = [&](double value) {
      int within = 0;
      for (const int v : carriers.set) within += rows.along(v, d) >= value;
      return within == std::ssize(carriers.set) && narrow_count(rows, d, value) == within;
    };
    return only(top.value - carriers.flat) && only(top.value - carriers.clear);
  }
};

#ifdef QUOIN_WIDE_LANES
struct Scan512 {
  static constexpr bool kFused = true;
  using Flags = WideFlags;
  QUOIN_AVX512 static Support support(const Rows& rows, const Vec3& d) {
    return support_512(rows, Wide512(d));
  }
  template <class AnyRows>
  QUOIN_AVX512 static PairSupport support_pair(const AnyRows& p, const AnyRows& q, const Vec3& d) {
    if constexpr (std::is_same_v<AnyRows, StraightRows>) {
      const Wide512 wide(d);
      return {support_512(p, wide), support_512(q, wide.reversed())};
    }
    return {support_512(p, Wide512(p.local(d))), support_512(q, Wide512(q.local(-d)))};
  }
  QUOIN_AVX512 static int count_beyond(const Rows& rows, const Vec3& d, double value) {
    return count_512(rows, d, value);
  }
};
struct Scan256 {
  static constexpr bool kFused = true;
  using Flags = WideFlags;
  QUOIN_AVX2 static Support support(const Rows& rows, const Vec3& d) {
    return support_256(rows, Wide256(d));
  }
  template <class AnyRows>
  QUOIN_AVX2 static PairSupport support_pair(const AnyRows& p, const AnyRows& q, const Vec3& d) {
    if constexpr (std::is_same_v<AnyRows, StraightRows>) {
      const Wide256 wide(d);
      return {support_256(p, wide), support_256(q, wide.reversed())};
    }
    return {support_256(p, Wide256(p.local(d))), support_256(q, Wide256(q.local(-d)))};
  }
  QUOIN_AVX2 static int count_beyond(const Rows& rows, const Vec3& d, double value) {
    return count_256(rows, d, value);
  }
  QUOIN_AVX2 static bool carried_alone(const Rows& rows, const Vec3& d, const Carriers& carriers,
                                       Support& top) {
    if (rows.padded == 8) return alone_256<2>(rows, d, carriers, top);
    if (rows.padded == 16) return alone_256<4>(rows, d, carriers, top);
    if (rows.padded == 24) return alone_256<6>(rows, d, carriers, top);
    if (rows.padded == 32) return alone_256<8>(rows, d, carriers, top);
    top = support_256(rows, Wide256(d));
    const auto only = [&](double value) QUOIN_AVX2 {
      int within = 0;
      for (const int v : carriers.set) within += rows.along(v, d) >= value;
      return within == std::ssize(carriers.set) && count_256(rows, d, value) == within;
    };
    return only(top.value - carriers.flat) && only(top.value - carriers.clear);
  }
};
#endif

}  // namespace quoin::geometry
