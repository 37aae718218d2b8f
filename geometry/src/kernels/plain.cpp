/// The kernels for every machine.

#include "kernels/build.hpp"

namespace quoin::geometry {

constinit const Kernels kPlainKernels = Build::kernels("plain");

}  // namespace quoin::geometry
