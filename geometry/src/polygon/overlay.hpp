#pragma once
/// Where two convex features laid into one contact plane lie over each other. Internal.

#include "polygon/projected_feature.hpp"

namespace quoin::geometry {

/// Adds the corners of what two laid features share: corners of P on Q, corners of Q on P, and
/// where sides cross. `rounding` (m) is how far outside still counts as on the border. In time
/// O((n + m) log(n + m)).
void append_shared_corners(const ProjectedFeature& p, const ProjectedFeature& q, double rounding,
                           SharedCorners& corners);

/// The same, and returns overlap_margin of the two: nearly for nothing. Between two polygons no
/// corner of which lies within rounding of the other's border, the corners come in order.
double lay_over(const ProjectedFeature& p, const ProjectedFeature& q, double rounding,
                SharedCorners& corners);

/// How far one feature could be shifted in the plane before the two part, m: the distance of the
/// origin from the border of their Minkowski difference; negative: a bound of how far they are
/// apart. In time O(n + m), by rotating calipers [Toussaint 1983].
double overlap_margin(const ProjectedFeature& p, const ProjectedFeature& q);

/// Where two features that rounding keeps apart come nearest: a corner of one of them.
Vector2 nearest_place(const ProjectedFeature& p, const ProjectedFeature& q);

}  // namespace quoin::geometry
