#include "polygon/line_normal.hpp"

namespace quoin::geometry {

Vec3 wide_cross(Side e, Side f) { return cross(e.wide(), f.wide()).rounded(); }

}  // namespace quoin::geometry
