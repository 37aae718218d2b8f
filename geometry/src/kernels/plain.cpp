/// The kernels for every machine.

#include "kernels/build.hpp"
#include "simd/lanes.hpp"

namespace quoin::geometry {
namespace {

struct Plain {
  using FewScan = PlainScan;
  using ManyScan = PlainScan;
  using Lanes = PlainLanes;
};

}  // namespace

constinit const Kernels kPlainKernels = Build<Plain>::kernels("plain");

}  // namespace quoin::geometry
