#include "search/corner_features.hpp"

#include <algorithm>

namespace quoin::geometry {

bool has_plain_corners(const Solid& p, const Solid& q) {
  constexpr int kFew = 16;
  return p.topology().three_faces_at_vertices() && q.topology().three_faces_at_vertices() &&
         std::max(p.padded_count(), q.padded_count()) <= kFew;
}

}  // namespace quoin::geometry
