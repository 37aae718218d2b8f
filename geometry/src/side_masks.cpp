#include "side_masks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "wide_lanes.hpp"

namespace quoin::geometry {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void narrow_sides(PolygonRows& rows) {
  for (int k = 0; k < rows.count; ++k) {
    rows.side_x[k] = rows.x[k + 1] - rows.x[k];
    rows.side_y[k] = rows.y[k + 1] - rows.y[k];
    rows.length[k] = std::sqrt(rows.side_x[k] * rows.side_x[k] + rows.side_y[k] * rows.side_y[k]);
  }
}

void narrow_masks(const PolygonRows& corners, const PolygonRows& sides, double rounding,
                  SideMasks& masks) {
  std::fill(masks.inside, masks.inside + corners.count, 0);
  std::fill(masks.outside, masks.outside + corners.count, 0);
  masks.margin = kInfinity;
  for (int j = 0; j < sides.count; ++j) {
    const double slack = rounding * sides.length[j];
    double greatest = -kInfinity;
    for (int i = 0; i < corners.count; ++i) {
      const double inside = sides.side_x[j] * (corners.y[i] - sides.y[j]) -
                            sides.side_y[j] * (corners.x[i] - sides.x[j]);
      masks.inside[i] |= static_cast<std::uint64_t>(inside > slack) << j;
      masks.outside[i] |= static_cast<std::uint64_t>(inside < -slack) << j;
      greatest = std::max(greatest, inside);
    }
    masks.margin = std::min(masks.margin, sides.length[j] > 0.0 ? greatest / sides.length[j] : 0.0);
  }
}

#ifdef QUOIN_WIDE_LANES

QUOIN_AVX512 inline void sides_512(PolygonRows& rows) {
  for (int k = 0; k < rows.count; k += 8) {
    const __m512d x = _mm512_sub_pd(_mm512_loadu_pd(rows.x + k + 1), _mm512_load_pd(rows.x + k));
    const __m512d y = _mm512_sub_pd(_mm512_loadu_pd(rows.y + k + 1), _mm512_load_pd(rows.y + k));
    _mm512_store_pd(rows.side_x + k, x);
    _mm512_store_pd(rows.side_y + k, y);
    const __m512d squared = _mm512_add_pd(_mm512_mul_pd(x, x), _mm512_mul_pd(y, y));
    _mm512_store_pd(rows.length + k, _mm512_sqrt_pd(squared));
  }
}

QUOIN_AVX512 inline void masks_512(const PolygonRows& corners, const PolygonRows& sides,
                                   double rounding, SideMasks& masks) {
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

QUOIN_AVX512 void both_512(PolygonRows& p, PolygonRows& q, double rounding, SideMasks& of_p,
                           SideMasks& of_q) {
  sides_512(p);
  sides_512(q);
  masks_512(p, q, rounding, of_p);
  masks_512(q, p, rounding, of_q);
}

QUOIN_AVX2 inline void sides_256(PolygonRows& rows) {
  for (int k = 0; k < rows.count; k += 4) {
    const __m256d x = _mm256_sub_pd(_mm256_loadu_pd(rows.x + k + 1), _mm256_load_pd(rows.x + k));
    const __m256d y = _mm256_sub_pd(_mm256_loadu_pd(rows.y + k + 1), _mm256_load_pd(rows.y + k));
    _mm256_store_pd(rows.side_x + k, x);
    _mm256_store_pd(rows.side_y + k, y);
    const __m256d squared = _mm256_add_pd(_mm256_mul_pd(x, x), _mm256_mul_pd(y, y));
    _mm256_store_pd(rows.length + k, _mm256_sqrt_pd(squared));
  }
}

QUOIN_AVX2 inline void masks_256(const PolygonRows& corners, const PolygonRows& sides,
                                 double rounding, SideMasks& masks) {
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

QUOIN_AVX2 void both_256(PolygonRows& p, PolygonRows& q, double rounding, SideMasks& of_p,
                         SideMasks& of_q) {
  sides_256(p);
  sides_256(q);
  masks_256(p, q, rounding, of_p);
  masks_256(q, p, rounding, of_q);
}

#endif

}  // namespace

void PolygonRows::set_surface(double normal_u, double normal_v, double across) {
  for (int k = count; k < filled(); ++k) {
    x[k] = x[0];
    y[k] = y[0];
  }
  double least = height[0], greatest = height[0];
  for (int k = 1; k < count; ++k) {
    least = std::min(least, height[k]);
    greatest = std::max(greatest, height[k]);
  }
  low = least;
  high = greatest;
  constexpr double kUpright = 1e-3;  // a face seen from its edge has no slope
  slope_x = std::abs(across) < kUpright ? 0.0 : -normal_u / across;
  slope_y = std::abs(across) < kUpright ? 0.0 : -normal_v / across;
}

void find_side_masks(PolygonRows& p, PolygonRows& q, double rounding, SideMasks& of_p,
                     SideMasks& of_q) {
#ifdef QUOIN_WIDE_LANES
  if (has_avx512()) return both_512(p, q, rounding, of_p, of_q);
  if (has_avx2()) return both_256(p, q, rounding, of_p, of_q);
#endif
  narrow_sides(p);
  narrow_sides(q);
  narrow_masks(p, q, rounding, of_p);
  narrow_masks(q, p, rounding, of_q);
}

}  // namespace quoin::geometry
