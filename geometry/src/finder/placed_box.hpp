#pragma once
/// Placements as they come in: whether they are such, and the boxes of bodies in the world.

#include <quoin/geometry/body.hpp>
#include <string>

namespace quoin::geometry {

/// Throws InputError naming `body` unless all twelve numbers are finite, none is larger than
/// kLargestCoordinate, and the determinant is positive.
void require_placement(const Placement& placement, int body);

/// Throws InputError unless a length (m) is finite and not negative.
void require_length(double value, const std::string& what);

bool same_placement(const Placement& x, const Placement& y);

/// Contains the body's solid in spite of rounding, m.
Box placed_box(const Polyhedron& shape, const Placement& placement);

}  // namespace quoin::geometry
