#pragma once
/// Shared corners of two solids as contact points. Internal.

#include <cstdint>
#include <quoin/geometry/contact_point.hpp>

#include "polygon/contact_polygon.hpp"

namespace quoin::geometry {

inline double gap_of(const SharedCorner& corner) { return corner.height_q - corner.height_p; }

/// Both features in one number, in the order of ContactKey.
inline std::int64_t key_number(const Feature& feature_p, const Feature& feature_q, bool reversed) {
  const auto number = [](const Feature& feature) {
    return static_cast<std::int64_t>(feature.kind) << 29 | feature.index;
  };
  const std::int64_t p = number(feature_p), q = number(feature_q);
  return reversed ? q << 32 | p : p << 32 | q;
}

/// Adds corners in `plane`, no two with the same names, as contact points, sorted by key.
/// `reversed`: P is the caller's B.
void append_corners(const std::array<int, 2>& blocks, bool reversed, const NearestFeatures& nearest,
                    ContactType type, const ContactPlane& plane, const SharedCorners& corners,
                    std::vector<ContactPoint>& contacts);

/// `middle`: of the pair, in the world, m.
void move(const Solid& a, const Solid& b, const Vector3& middle, PointFrame frame,
          std::span<ContactPoint> points);

}  // namespace quoin::geometry
