#pragma once
/// Nearest features for the functions that go on from them. Internal.

#include <quoin/geometry/nearest_features.hpp>

#include "numeric/late_init.hpp"
#include "polygon/contact_polygon.hpp"

namespace quoin::geometry {

/// As the public one, from the middle of the pair, into an answer as made; `faces` (may be null) is
/// filled where both contact features are whole faces and nothing was in doubt, in the canonical
/// order.
void find_nearest_features(const Solid& a, const Solid& b, const SearchOptions& options,
                           const FeatureHint& hint, LateInit<ContactPolygon>* faces,
                           NearestFeatures& answer);

/// From the middle of the pair into the world, or back (`way` -1).
inline void move(const PlacedPair& pair, NearestFeatures& nearest, double way = 1.0) {
  if (pair.as_shapes) return;  // zeros keep their signs
  nearest.point_a += way * pair.middle;
  nearest.point_b += way * pair.middle;
}

}  // namespace quoin::geometry
