#pragma once
/// The cross product in a plane. Internal.

#include "polygon/contact_plane.hpp"

namespace quoin::geometry {

/// Twice the area of the triangle (0, a, b), positive where b lies to the left of a.
inline double cross2(const Vector2& a, const Vector2& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace quoin::geometry
