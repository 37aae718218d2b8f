#pragma once
/// Contact points from the middle of their pair into the frame that is asked for. Internal.

#include <quoin/geometry/contact_point.hpp>
#include <span>

#include "shape/solid.hpp"

namespace quoin::geometry {

/// `middle`: of the pair, in the world, m.
void move(const Solid& a, const Solid& b, const Vector3& middle, PointFrame frame,
          std::span<ContactPoint> points);

}  // namespace quoin::geometry
