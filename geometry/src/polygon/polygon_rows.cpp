#include "polygon/polygon_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "shape/support.hpp"
#include "simd/dispatch.hpp"
#include "simd/lanes.hpp"

namespace quoin::geometry {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void narrow_corners(const double* vertices, const LocalPlane& plane, PolygonRows& rows) {
  for (int k = 0; k < rows.count; ++k) {
    const double* const v = vertices + 3 * rows.vertex[k];
    const Vec3 vertex(v[0], v[1], v[2]);
    const Vector2 place = plane.place(vertex);
    rows.x[k] = place.x();
    rows.y[k] = place.y();
    rows.height[k] = plane.height(vertex);
  }
}

void narrow_sides(PolygonRows& rows) {
  double low = rows.height[0], high = low;
  for (int k = 0; k < rows.count; ++k) {
    rows.side_x[k] = rows.x[k + 1] - rows.x[k];
    rows.side_y[k] = rows.y[k + 1] - rows.y[k];
    rows.length[k] = std::sqrt(rows.side_x[k] * rows.side_x[k] + rows.side_y[k] * rows.side_y[k]);
    low = std::min(low, rows.height[k]);
    high = std::max(high, rows.height[k]);
  }
  rows.low = low + 0.0;
  rows.high = high + 0.0;
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

#ifdef QUOIN_FOUR_WIDE_LANES

QUOIN_AVX2 inline __m256d along_256(const Vec3& a, double shift, __m256d x, __m256d y, __m256d z) {
  const __m256d sum =
      _mm256_add_pd(_mm256_mul_pd(_mm256_set1_pd(a.x), x), _mm256_mul_pd(_mm256_set1_pd(a.y), y));
  return _mm256_add_pd(_mm256_add_pd(sum, _mm256_mul_pd(_mm256_set1_pd(a.z), z)),
                       _mm256_set1_pd(shift));
}

/// From four corners to the next ones; after the last comes the first.
QUOIN_AVX2 inline __m256d to_next_256(const double* row, int k, int count) {
  const __m256d here = _mm256_load_pd(row + k);
  const __m256d after = _mm256_broadcast_sd(row + (k + 4 < count ? k + 4 : 0));
  return _mm256_sub_pd(_mm256_blend_pd(_mm256_permute4x64_pd(here, 0x39), after, 8), here);
}

/// Four more lanes of corner 0.
QUOIN_AVX2 inline void fill_256(PolygonRows& rows, int k) {
  const __m256d none = _mm256_setzero_pd();
  _mm256_store_pd(rows.x + k, _mm256_broadcast_sd(rows.x));
  _mm256_store_pd(rows.y + k, _mm256_broadcast_sd(rows.y));
  _mm256_store_pd(rows.height + k, _mm256_broadcast_sd(rows.height));
  _mm256_store_pd(rows.side_x + k, none);
  _mm256_store_pd(rows.side_y + k, none);
  _mm256_store_pd(rows.length + k, none);
}

QUOIN_AVX2 inline double greatest_256(__m256d v) {
  const __m128d half = _mm_max_pd(_mm256_castpd256_pd128(v), _mm256_extractf128_pd(v, 1));
  return _mm_cvtsd_f64(_mm_max_sd(half, _mm_unpackhi_pd(half, half)));
}

/// Corners and sides, four at a time, in registers: rows are read as they were written. (Gathers
/// would be slower where the processor guards them.)
QUOIN_AVX2 void lay_256(const double* vertices, const LocalPlane& plane, PolygonRows& rows) {
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
  rows.high = greatest_256(high) + 0.0;
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

QUOIN_AVX512 void both_512(const PolygonRows& p, const PolygonRows& q, double rounding,
                           SideMasks& of_p, SideMasks& of_q) {
  masks_512(p, q, rounding, of_p);
  masks_512(q, p, rounding, of_q);
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

QUOIN_AVX2 void both_256(const PolygonRows& p, const PolygonRows& q, double rounding,
                         SideMasks& of_p, SideMasks& of_q) {
  masks_256(p, q, rounding, of_p);
  masks_256(q, p, rounding, of_q);
}

#endif

}  // namespace

void lay_corners(const Solid& polyhedron, const ContactPlane& plane, PolygonRows& rows) {
  const double* const vertices = polyhedron.shape().vertices().data();
  const LocalPlane local(polyhedron, plane);
#ifdef QUOIN_FOUR_WIDE_LANES
  if (has_avx2()) return lay_256(vertices, local, rows);
#endif
  narrow_corners(vertices, local, rows);
  find_sides(rows);
}

void find_sides(PolygonRows& rows) {
  for (int k = rows.count; k < rows.filled(); ++k) {
    rows.x[k] = rows.x[0];
    rows.y[k] = rows.y[0];
    rows.height[k] = rows.height[0];
    rows.side_x[k] = rows.side_y[k] = rows.length[k] = 0.0;
  }
  narrow_sides(rows);
}

void find_side_masks(const PolygonRows& p, const PolygonRows& q, double rounding, SideMasks& of_p,
                     SideMasks& of_q) {
#ifdef QUOIN_FOUR_WIDE_LANES
  const bool few = std::max(p.count, q.count) <= 4;
  if (has_avx512() && !few) return both_512(p, q, rounding, of_p, of_q);
  if (has_avx2()) return both_256(p, q, rounding, of_p, of_q);
#endif
  narrow_masks(p, q, rounding, of_p);
  narrow_masks(q, p, rounding, of_q);
}

}  // namespace quoin::geometry
