#pragma once
/// Shared corners of two solids as contact points. Internal.

#include <quoin/geometry/contact_point.hpp>

#include "polygon/contact_polygon.hpp"

namespace quoin::geometry {

inline double gap_of(const SharedCorner& corner) { return corner.height_q - corner.height_p; }

/// Adds corners in `plane`, no two with the same names, as contact points, sorted by key.
/// `reversed`: P is the caller's B.
void append_corners(const std::array<int, 2>& blocks, bool reversed, const NearestFeatures& nearest,
                    ContactType type, const ContactPlane& plane, const SharedCorners& corners,
                    std::vector<ContactPoint>& contacts);

}  // namespace quoin::geometry
