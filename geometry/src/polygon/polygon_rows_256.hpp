#pragma once
/// The kernels of polygon_rows_kernel.hpp in AVX2: the same bits. Only for files that
/// are compiled for it. Internal.

#include <immintrin.h>

#include "polygon/polygon_rows.hpp"

#include <algorithm>

#include "numeric/floating_point.hpp"
#include "simd/lanes_256.hpp"

namespace quoin::geometry {
namespace {

inline __m256d along_256(const Vec3& a, double shift, __m256d x, __m256d y, __m256d z) {
  const __m256d sum =
      _mm256_add_pd(_mm256_mul_pd(_mm256_set1_pd(a.x), x), _mm256_mul_pd(_mm256_set1_pd(a.y), y));
  return _mm256_add_pd(_mm256_add_pd(sum, _mm256_mul_pd(_mm256_set1_pd(a.z), z)),
                       _mm256_set1_pd(shift));
}

/// From four corners to the next ones; after the last comes the first.
inline __m256d to_next_256(const double* row, int k, int count) {
  const __m256d here = _mm256_load_pd(row + k);
  const __m256d after = _mm256_broadcast_sd(row + (k + 4 < count ? k + 4 : 0));
  return _mm256_sub_pd(_mm256_blend_pd(_mm256_permute4x64_pd(here, 0x39), after, 8), here);
}

/// Four more lanes of corner 0.
inline void fill_256(PolygonRows& rows, int k) {
  const __m256d none = _mm256_setzero_pd();
  _mm256_store_pd(rows.x + k, _mm256_broadcast_sd(rows.x));
  _mm256_store_pd(rows.y + k, _mm256_broadcast_sd(rows.y));
  _mm256_store_pd(rows.height + k, _mm256_broadcast_sd(rows.height));
  _mm256_store_pd(rows.side_x + k, none);
  _mm256_store_pd(rows.side_y + k, none);
  _mm256_store_pd(rows.length + k, none);
}

/// Corners and sides, four at a time, in registers: rows are read as they were written. (Gathers
/// would be slower where the processor guards them.)
inline void lay_256(const double* vertices, const LocalPlane& plane, PolygonRows& rows) {
  const __m256i three = _mm256_set_epi64x(0, -1, -1, -1);
  __m256d low = _mm256_set1_pd(kInfinity), high = _mm256_set1_pd(-kInfinity);
  for (int k = 0; k < rows.count; k += 4) {
    __m256d corner[4];
    for (int i = 0; i < 4; ++i) {
      const int v = rows.vertex[k + i < rows.count ? k + i : 0];
      corner[i] = _mm256_maskload_pd(vertices + 3 * v, three);
    }
    const __m256d xz_01 = _mm256_unpacklo_pd(corner[0], corner[1]);
    const __m256d xz_23 = _mm256_unpacklo_pd(corner[2], corner[3]);
    const __m256d y_01 = _mm256_unpackhi_pd(corner[0], corner[1]);
    const __m256d y_23 = _mm256_unpackhi_pd(corner[2], corner[3]);
    const __m256d x =
        _mm256_sub_pd(_mm256_permute2f128_pd(xz_01, xz_23, 0x20), _mm256_set1_pd(plane.base.x));
    const __m256d y =
        _mm256_sub_pd(_mm256_permute2f128_pd(y_01, y_23, 0x20), _mm256_set1_pd(plane.base.y));
    const __m256d z =
        _mm256_sub_pd(_mm256_permute2f128_pd(xz_01, xz_23, 0x31), _mm256_set1_pd(plane.base.z));
    const __m256d height = along_256(plane.normal, plane.shift_height, x, y, z);
    _mm256_store_pd(rows.x + k, along_256(plane.axis_u, plane.shift_u, x, y, z));
    _mm256_store_pd(rows.y + k, along_256(plane.axis_v, plane.shift_v, x, y, z));
    _mm256_store_pd(rows.height + k, height);
    low = _mm256_min_pd(low, height);
    high = _mm256_max_pd(high, height);
  }
  rows.low = Lanes256{low}.least() + 0.0;  // one zero only: -0 would tell the variants apart
  rows.high = Lanes256{high}.greatest() + 0.0;
  for (int k = 0; k < rows.count; k += 4) {
    const __m256d side_x = to_next_256(rows.x, k, rows.count);
    const __m256d side_y = to_next_256(rows.y, k, rows.count);
    const __m256d squared =
        _mm256_add_pd(_mm256_mul_pd(side_x, side_x), _mm256_mul_pd(side_y, side_y));
    _mm256_store_pd(rows.side_x + k, side_x);
    _mm256_store_pd(rows.side_y + k, side_y);
    _mm256_store_pd(rows.length + k, _mm256_sqrt_pd(squared));
  }
  if ((rows.count + 3) / 4 % 2 != 0) fill_256(rows, (rows.count + 3) / 4 * 4);
}

inline void masks_256(const PolygonRows& corners, const PolygonRows& sides, double rounding,
                      SideMasks& masks) {
  masks.margin = kInfinity;
  for (int j = 0; j < sides.count; j += 4) {
    const __m256d x = _mm256_load_pd(sides.x + j), y = _mm256_load_pd(sides.y + j);
    const __m256d side_x = _mm256_load_pd(sides.side_x + j);
    const __m256d side_y = _mm256_load_pd(sides.side_y + j);
    const __m256d length = _mm256_load_pd(sides.length + j);
    const __m256d above = _mm256_mul_pd(_mm256_set1_pd(rounding), length);
    const __m256d below = _mm256_mul_pd(_mm256_set1_pd(-rounding), length);
    __m256d greatest = _mm256_set1_pd(-kInfinity);
    for (int i = 0; i < corners.count; ++i) {
      const __m256d along = _mm256_mul_pd(side_x, _mm256_sub_pd(_mm256_set1_pd(corners.y[i]), y));
      const __m256d across = _mm256_mul_pd(side_y, _mm256_sub_pd(_mm256_set1_pd(corners.x[i]), x));
      const __m256d inside = _mm256_sub_pd(along, across);
      const auto in =
          static_cast<std::uint64_t>(_mm256_movemask_pd(_mm256_cmp_pd(inside, above, _CMP_GT_OQ)));
      const auto out =
          static_cast<std::uint64_t>(_mm256_movemask_pd(_mm256_cmp_pd(inside, below, _CMP_LT_OQ)));
      masks.inside[i] = j == 0 ? in : masks.inside[i] | in << j;
      masks.outside[i] = j == 0 ? out : masks.outside[i] | out << j;
      greatest = _mm256_max_pd(greatest, inside);
    }
    alignas(32) double reach[4];
    _mm256_store_pd(reach, _mm256_div_pd(greatest, length));
    for (int k = 0; k < std::min(4, sides.count - j); ++k) {
      masks.margin = std::min(masks.margin, sides.length[j + k] > 0.0 ? reach[k] : 0.0);
    }
  }
}

}  // namespace
}  // namespace quoin::geometry
