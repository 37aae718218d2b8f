#pragma once
/// The scans of scan.hpp in AVX2: the same bits. Only for files that are compiled for it.
/// Internal.

#include <immintrin.h>

#include <bit>
#include <cstdint>
#include <type_traits>

#include "shape/scan.hpp"

namespace quoin::geometry {
namespace {

struct Wide256 {
  __m256d x, y, z;
  explicit Wide256(const Vec3& d)
      : x(_mm256_set1_pd(d.x)), y(_mm256_set1_pd(d.y)), z(_mm256_set1_pd(d.z)) {}
  Wide256(__m256d a, __m256d b, __m256d c) : x(a), y(b), z(c) {}
  __m256d along(const Rows& rows, int v) const {
    const __m256d sum = _mm256_add_pd(_mm256_mul_pd(_mm256_load_pd(rows.x + v), x),
                                      _mm256_mul_pd(_mm256_load_pd(rows.y + v), y));
    return _mm256_add_pd(sum, _mm256_mul_pd(_mm256_load_pd(rows.z + v), z));
  }
  Wide256 reversed() const {
    const __m256d sign = _mm256_set1_pd(-0.0);
    return {_mm256_xor_pd(x, sign), _mm256_xor_pd(y, sign), _mm256_xor_pd(z, sign)};
  }
  /// Which of the vertices v … v + 3 reach the limit.
  unsigned reaching(const Rows& rows, int v, __m256d limit) const {
    const __m256d hit = _mm256_cmp_pd(along(rows, v), limit, _CMP_GE_OQ);
    const auto mask = static_cast<unsigned>(_mm256_movemask_pd(hit));
    return rows.count - v < 4 ? mask & ((1u << (rows.count - v)) - 1u) : mask;
  }
};

/// Greatest of four lanes, in all lanes.
inline __m256d greatest_lane(__m256d v) {
  v = _mm256_max_pd(v, _mm256_permute2f128_pd(v, v, 1));
  return _mm256_max_pd(v, _mm256_permute_pd(v, 5));
}

/// All products in registers, one mask of the greatest. `Fours`: of four vertices.
template <int Fours>
Support support_of_few(const Rows& rows, const Wide256& wide) {
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

inline Support support_256(const Rows& rows, const Wide256& wide) {
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
bool alone_256(const Rows& rows, const Vec3& d, const Carriers& carriers, Support& top) {
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
  const auto bits = [](__m256d mask, int k) {
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

inline void beyond_256(const Rows& rows, const Vec3& d, double value, VertexSet& vertices) {
  const Wide256 wide(d);
  const __m256d limit = _mm256_set1_pd(value);
  for (int v = 0; v < rows.count; v += 4) {
    unsigned mask = wide.reaching(rows, v, limit);
    for (; mask != 0; mask &= mask - 1) vertices.push_back(v + __builtin_ctz(mask));
  }
}

/// `Fours`: of four vertices.
template <int Fours>
int count_of_few(const Rows& rows, const Wide256& wide, __m256d limit) {
  std::uint32_t reached = 0;
  for (int k = 0; k < Fours; ++k) {
    const __m256d hit = _mm256_cmp_pd(wide.along(rows, 4 * k), limit, _CMP_GE_OQ);
    reached |= static_cast<std::uint32_t>(_mm256_movemask_pd(hit)) << 4 * k;
  }
  return std::popcount(reached & (~std::uint32_t{0} >> (32 - rows.count)));
}

inline int count_256(const Rows& rows, const Vec3& d, double value) {
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

struct Scan256 {
  static constexpr bool kFused = true;
  static Support support(const Rows& rows, const Vec3& d) { return support_256(rows, Wide256(d)); }
  static void beyond(const Rows& rows, const Vec3& d, double value, VertexSet& vertices) {
    beyond_256(rows, d, value, vertices);
  }
  template <class AnyRows>
  static PairSupport support_pair(const AnyRows& p, const AnyRows& q, const Vec3& d) {
    if constexpr (std::is_same_v<AnyRows, StraightRows>) {
      const Wide256 wide(d);
      return {support_256(p, wide), support_256(q, wide.reversed())};
    }
    return {support_256(p, Wide256(p.local(d))), support_256(q, Wide256(q.local(-d)))};
  }
  static int count_beyond(const Rows& rows, const Vec3& d, double value) {
    return count_256(rows, d, value);
  }
  static bool carried_alone(const Rows& rows, const Vec3& d, const Carriers& carriers,
                            Support& top) {
    if (rows.padded == 8) return alone_256<2>(rows, d, carriers, top);
    if (rows.padded == 16) return alone_256<4>(rows, d, carriers, top);
    if (rows.padded == 24) return alone_256<6>(rows, d, carriers, top);
    if (rows.padded == 32) return alone_256<8>(rows, d, carriers, top);
    top = support_256(rows, Wide256(d));
    const auto only = [&](double value) {
      int within = 0;
      for (const int v : carriers.set) within += rows.along(v, d) >= value;
      return within == std::ssize(carriers.set) && count_256(rows, d, value) == within;
    };
    return only(top.value - carriers.flat) && only(top.value - carriers.clear);
  }
};

}  // namespace
}  // namespace quoin::geometry
