#pragma once
/// The kernels of polygon_rows_kernel.hpp in AVX-512: the same bits. Only for files that
/// are compiled for it. Internal.

#include <immintrin.h>

#include "polygon/polygon_rows.hpp"

#include <algorithm>

#include "numeric/floating_point.hpp"

namespace quoin::geometry {
namespace {

inline void masks_512(const PolygonRows& corners, const PolygonRows& sides, double rounding,
                      SideMasks& masks) {
  masks.margin = kInfinity;
  for (int j = 0; j < sides.count; j += 8) {
    const __m512d x = _mm512_load_pd(sides.x + j), y = _mm512_load_pd(sides.y + j);
    const __m512d side_x = _mm512_load_pd(sides.side_x + j);
    const __m512d side_y = _mm512_load_pd(sides.side_y + j);
    const __m512d length = _mm512_load_pd(sides.length + j);
    const __m512d above = _mm512_mul_pd(_mm512_set1_pd(rounding), length);
    const __m512d below = _mm512_mul_pd(_mm512_set1_pd(-rounding), length);
    __m512d greatest = _mm512_set1_pd(-kInfinity);
    for (int i = 0; i < corners.count; ++i) {
      const __m512d along = _mm512_mul_pd(side_x, _mm512_sub_pd(_mm512_set1_pd(corners.y[i]), y));
      const __m512d across = _mm512_mul_pd(side_y, _mm512_sub_pd(_mm512_set1_pd(corners.x[i]), x));
      const __m512d inside = _mm512_sub_pd(along, across);
      const std::uint64_t in = _mm512_cmp_pd_mask(inside, above, _CMP_GT_OQ);
      const std::uint64_t out = _mm512_cmp_pd_mask(inside, below, _CMP_LT_OQ);
      masks.inside[i] = j == 0 ? in : masks.inside[i] | in << j;
      masks.outside[i] = j == 0 ? out : masks.outside[i] | out << j;
      greatest = _mm512_max_pd(greatest, inside);
    }
    const auto valid =
        static_cast<__mmask8>(sides.count - j < 8 ? (1 << (sides.count - j)) - 1 : 255);
    const __mmask8 wide = _mm512_cmp_pd_mask(length, _mm512_setzero_pd(), _CMP_GT_OQ);
    const __m512d reach = _mm512_maskz_div_pd(wide, greatest, length);
    masks.margin = std::min(masks.margin, _mm512_mask_reduce_min_pd(valid, reach));
  }
}

}  // namespace
}  // namespace quoin::geometry
