/// The kernels in AVX-512 (F, DQ, VL): compiled for it. Small solids are scanned 256 bits at a
/// time, with more registers than AVX2 has: beside instructions of 512 bits a machine has fewer
/// units for all the others.

#include "kernels/build.hpp"
#include "polygon/polygon_rows_256.hpp"
#include "polygon/polygon_rows_512.hpp"
#include "shape/scan_256.hpp"
#include "shape/scan_512.hpp"
#include "simd/lanes_256.hpp"

namespace quoin::geometry {
namespace {

struct Avx512 {
  using FewScan = Scan256;
  using ManyScan = Scan512;
  using Lanes = Lanes256;
  static void lay(const double* vertices, const LocalPlane& plane, PolygonRows& rows) {
    lay_256(vertices, plane, rows);
  }
  static void find_masks(const PolygonRows& corners, const PolygonRows& sides, double rounding,
                         SideMasks& masks) {
    const bool few = std::max(corners.count, sides.count) <= 4;
    few ? masks_256(corners, sides, rounding, masks) : masks_512(corners, sides, rounding, masks);
  }
};

}  // namespace

constinit const Kernels kAvx512Kernels = Build<Avx512>::kernels("AVX-512");

}  // namespace quoin::geometry
