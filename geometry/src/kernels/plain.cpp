/// The kernels for every machine.

#include "kernels/build.hpp"
#include "polygon/polygon_rows_kernel.hpp"
#include "simd/lanes.hpp"

namespace quoin::geometry {
namespace {

struct Plain {
  using FewScan = PlainScan;
  using ManyScan = PlainScan;
  using Lanes = PlainLanes;
  static void lay(const double* vertices, const LocalPlane& plane, PolygonRows& rows) {
    lay_narrow(vertices, plane, rows);
  }
  static void find_masks(const PolygonRows& corners, const PolygonRows& sides, double rounding,
                         SideMasks& masks) {
    narrow_masks(corners, sides, rounding, masks);
  }
};

}  // namespace

constinit const Kernels kPlainKernels = Build<Plain>::kernels("plain");

}  // namespace quoin::geometry
