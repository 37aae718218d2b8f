#pragma once
/// Two whole faces of few corners on each other, where nothing is in doubt: the ordinary case of
/// blocks that lie flush, in straight code. Internal.

#include "polygon/contact_polygon.hpp"

namespace quoin::geometry {

/// Lays both faces of `part` into its plane: the corners they share, their area, centroid and
/// shares. False, and nothing of use in `part`: too many corners, too little area, or a corner of
/// one within `rounding` (m) of a side of the other. The same bits whatever the machine.
bool overlay_faces(const Solid& p, const Solid& q, double rounding, ContactPolygon& part);

}  // namespace quoin::geometry
