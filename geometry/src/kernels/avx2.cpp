/// The kernels in AVX2 and FMA: compiled for these. FMA serves the error terms of double-double
/// alone.

#include "kernels/build.hpp"
#include "shape/scan_256.hpp"
#include "simd/lanes_256.hpp"

namespace quoin::geometry {
namespace {

struct Avx2 {
  using FewScan = Scan256;
  using ManyScan = Scan256;
  using Lanes = Lanes256;
};

}  // namespace

constinit const Kernels kAvx2Kernels = Build<Avx2>::kernels("AVX2");

}  // namespace quoin::geometry
