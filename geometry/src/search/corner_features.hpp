#pragma once
/// Nearest features of solids apart from two of their corners alone. Internal.

#include "shape/solid.hpp"

namespace quoin::geometry {

/// Corners that span one feature of P and one of Q; those that are fewer than three stand twice.
struct CornerFeatures {
  std::array<int, 3> p, q;
};

/// Is it worth a try before the search? Just three edges have to end in each vertex.
bool has_plain_corners(const Solid& p, const Solid& q);

/// Of the vertices farthest along `direction` (P) and against it (Q) and of their edges and faces,
/// those that come nearest. Only a proof can tell whether others come nearer.
CornerFeatures corner_features(const Solid& p, const Solid& q, const Vector3& direction);

}  // namespace quoin::geometry
