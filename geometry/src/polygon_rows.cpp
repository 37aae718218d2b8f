#include "polygon_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "support.hpp"
#include "wide_lanes.hpp"

namespace quoin::geometry {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void narrow_corners(const double* vertices, const ContactPlane& plane, PolygonRows& rows) {
  for (int k = 0; k < rows.count; ++k) {
    const double* const v = vertices + 3 * rows.vertex[k];
    const Vector3 step(v[0] - plane.origin.x(), v[1] - plane.origin.y(), v[2] - plane.origin.z());
    rows.x[k] = along(plane.axis_u, step);
    rows.y[k] = along(plane.axis_v, step);
    rows.height[k] = along(plane.normal, step);
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
  rows.low = low;
  rows.high = high;
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

QUOIN_AVX512 inline __m512d along_512(const Vector3& a, const __m512d* step) {
  const __m512d sum = _mm512_add_pd(_mm512_mul_pd(_mm512_set1_pd(a.x()), step[0]),
                                    _mm512_mul_pd(_mm512_set1_pd(a.y()), step[1]));
  return _mm512_add_pd(sum, _mm512_mul_pd(_mm512_set1_pd(a.z()), step[2]));
}

QUOIN_AVX512 void corners_512(const double* vertices, const ContactPlane& plane,
                              PolygonRows& rows) {
  for (int k = 0; k < rows.count; k += 8) {
    const __m256i v = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(rows.vertex + k));
    const __m256i place = _mm256_add_epi32(v, _mm256_add_epi32(v, v));
    __m512d step[3];
    for (int i = 0; i < 3; ++i) {
      const __m512d x = _mm512_i32gather_pd(place, vertices + i, 8);
      step[i] = _mm512_sub_pd(x, _mm512_set1_pd(plane.origin[i]));
    }
    _mm512_store_pd(rows.x + k, along_512(plane.axis_u, step));
    _mm512_store_pd(rows.y + k, along_512(plane.axis_v, step));
    _mm512_store_pd(rows.height + k, along_512(plane.normal, step));
  }
}

/// What stands one lane to the right; beyond the last block comes the first corner.
QUOIN_AVX512 inline __m512d next_512(const double* row, int k, int count) {
  const __m512d after = _mm512_load_pd(row + (k + 8 < count ? k + 8 : 0));
  const __m512d here = _mm512_load_pd(row + k);
  return _mm512_castsi512_pd(
      _mm512_alignr_epi64(_mm512_castpd_si512(after), _mm512_castpd_si512(here), 1));
}

QUOIN_AVX512 void sides_512(PolygonRows& rows) {
  __m512d low = _mm512_load_pd(rows.height), high = low;
  for (int k = 0; k < rows.count; k += 8) {
    const __m512d x = _mm512_sub_pd(next_512(rows.x, k, rows.count), _mm512_load_pd(rows.x + k));
    const __m512d y = _mm512_sub_pd(next_512(rows.y, k, rows.count), _mm512_load_pd(rows.y + k));
    _mm512_store_pd(rows.side_x + k, x);
    _mm512_store_pd(rows.side_y + k, y);
    const __m512d squared = _mm512_add_pd(_mm512_mul_pd(x, x), _mm512_mul_pd(y, y));
    _mm512_store_pd(rows.length + k, _mm512_sqrt_pd(squared));
    low = _mm512_min_pd(low, _mm512_load_pd(rows.height + k));
    high = _mm512_max_pd(high, _mm512_load_pd(rows.height + k));
  }
  rows.low = _mm512_reduce_min_pd(low);
  rows.high = _mm512_reduce_max_pd(high);
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

void lay_corners(const Polyhedron& polyhedron, const ContactPlane& plane, PolygonRows& rows) {
  const double* const vertices = polyhedron.vertices().data();
#ifdef QUOIN_WIDE_LANES
  if (has_avx512()) {
    std::fill(rows.vertex + rows.count, rows.vertex + rows.filled(), rows.vertex[0]);
    corners_512(vertices, plane, rows);
    return sides_512(rows);
  }
#endif
  narrow_corners(vertices, plane, rows);
  find_sides(rows);
}

void find_sides(PolygonRows& rows) {
  for (int k = rows.count; k < rows.filled(); ++k) {
    rows.x[k] = rows.x[0];
    rows.y[k] = rows.y[0];
    rows.height[k] = rows.height[0];
    rows.side_x[k] = rows.side_y[k] = rows.length[k] = 0.0;
  }
#ifdef QUOIN_WIDE_LANES
  if (has_avx512()) return sides_512(rows);
#endif
  narrow_sides(rows);
}

void find_side_masks(const PolygonRows& p, const PolygonRows& q, double rounding, SideMasks& of_p,
                     SideMasks& of_q) {
#ifdef QUOIN_WIDE_LANES
  if (has_avx512()) return both_512(p, q, rounding, of_p, of_q);
  if (has_avx2()) return both_256(p, q, rounding, of_p, of_q);
#endif
  narrow_masks(p, q, rounding, of_p);
  narrow_masks(q, p, rounding, of_q);
}

}  // namespace quoin::geometry
