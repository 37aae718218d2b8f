/// The kernels in AVX2 and FMA: compiled for these. FMA serves the error terms of double-double
/// alone.

#include "kernels/build.hpp"

namespace quoin::geometry {

constinit const Kernels kAvx2Kernels = Build::kernels("AVX2");

}  // namespace quoin::geometry
