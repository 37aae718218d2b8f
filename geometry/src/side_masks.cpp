#include "side_masks.hpp"

#include <algorithm>
#include <limits>

#include "wide_lanes.hpp"

namespace quoin::geometry {
namespace {

std::uint64_t valid_bits(int count) {
  return count == PolygonRows::kMost ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
}

void narrow_masks(const PolygonRows& sides, const PolygonRows& points, double rounding,
                  SideMask* masks) {
  for (int j = 0; j < sides.count; ++j) {
    const double slack = rounding * sides.length[j];
    SideMask mask{0, 0, -std::numeric_limits<double>::infinity()};
    for (int i = 0; i < points.count; ++i) {
      const double inside = sides.side_x[j] * (points.y[i] - sides.y[j]) -
                            sides.side_y[j] * (points.x[i] - sides.x[j]);
      mask.inside |= static_cast<std::uint64_t>(inside > slack) << i;
      mask.outside |= static_cast<std::uint64_t>(inside < -slack) << i;
      mask.greatest = std::max(mask.greatest, inside);
    }
    masks[j] = mask;
  }
}

#ifdef QUOIN_WIDE_LANES

QUOIN_AVX512 void masks_512(const PolygonRows& sides, const PolygonRows& points, double rounding,
                            SideMask* masks) {
  const std::uint64_t valid = valid_bits(points.count);
  for (int j = 0; j < sides.count; ++j) {
    const __m512d x = _mm512_set1_pd(sides.x[j]), y = _mm512_set1_pd(sides.y[j]);
    const __m512d side_x = _mm512_set1_pd(sides.side_x[j]);
    const __m512d side_y = _mm512_set1_pd(sides.side_y[j]);
    const double slack = rounding * sides.length[j];
    const __m512d above = _mm512_set1_pd(slack), below = _mm512_set1_pd(-slack);
    SideMask mask{0, 0, 0.0};
    __m512d greatest = _mm512_set1_pd(-std::numeric_limits<double>::infinity());
    for (int i = 0; i < points.count; i += 8) {
      const __m512d along = _mm512_mul_pd(side_x, _mm512_sub_pd(_mm512_load_pd(points.y + i), y));
      const __m512d across = _mm512_mul_pd(side_y, _mm512_sub_pd(_mm512_load_pd(points.x + i), x));
      const __m512d inside = _mm512_sub_pd(along, across);
      mask.inside |= std::uint64_t{_mm512_cmp_pd_mask(inside, above, _CMP_GT_OQ)} << i;
      mask.outside |= std::uint64_t{_mm512_cmp_pd_mask(inside, below, _CMP_LT_OQ)} << i;
      greatest = _mm512_max_pd(greatest, inside);
    }
    masks[j] = {mask.inside & valid, mask.outside & valid, _mm512_reduce_max_pd(greatest)};
  }
}

QUOIN_AVX2 void masks_256(const PolygonRows& sides, const PolygonRows& points, double rounding,
                          SideMask* masks) {
  const std::uint64_t valid = valid_bits(points.count);
  for (int j = 0; j < sides.count; ++j) {
    const __m256d x = _mm256_set1_pd(sides.x[j]), y = _mm256_set1_pd(sides.y[j]);
    const __m256d side_x = _mm256_set1_pd(sides.side_x[j]);
    const __m256d side_y = _mm256_set1_pd(sides.side_y[j]);
    const double slack = rounding * sides.length[j];
    const __m256d above = _mm256_set1_pd(slack), below = _mm256_set1_pd(-slack);
    SideMask mask{0, 0, 0.0};
    __m256d greatest = _mm256_set1_pd(-std::numeric_limits<double>::infinity());
    for (int i = 0; i < points.count; i += 4) {
      const __m256d along = _mm256_mul_pd(side_x, _mm256_sub_pd(_mm256_load_pd(points.y + i), y));
      const __m256d across = _mm256_mul_pd(side_y, _mm256_sub_pd(_mm256_load_pd(points.x + i), x));
      const __m256d inside = _mm256_sub_pd(along, across);
      const int in = _mm256_movemask_pd(_mm256_cmp_pd(inside, above, _CMP_GT_OQ));
      const int out = _mm256_movemask_pd(_mm256_cmp_pd(inside, below, _CMP_LT_OQ));
      mask.inside |= static_cast<std::uint64_t>(in) << i;
      mask.outside |= static_cast<std::uint64_t>(out) << i;
      greatest = _mm256_max_pd(greatest, inside);
    }
    const __m128d half =
        _mm_max_pd(_mm256_castpd256_pd128(greatest), _mm256_extractf128_pd(greatest, 1));
    masks[j] = {mask.inside & valid, mask.outside & valid,
                _mm_cvtsd_f64(_mm_max_sd(half, _mm_unpackhi_pd(half, half)))};
  }
}

#endif

}  // namespace

void find_side_masks(const PolygonRows& sides, const PolygonRows& points, double rounding,
                     SideMask* masks) {
#ifdef QUOIN_WIDE_LANES
  if (has_avx512()) return masks_512(sides, points, rounding, masks);
  if (has_avx2()) return masks_256(sides, points, rounding, masks);
#endif
  narrow_masks(sides, points, rounding, masks);
}

}  // namespace quoin::geometry
