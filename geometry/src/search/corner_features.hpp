#pragma once
/// Nearest features of solids apart from two of their corners alone. Internal.

#include "certify/certificate.hpp"

namespace quoin::geometry {

/// Is it worth a try before the search? Just three edges have to end in each vertex.
inline bool has_plain_corners(const Solid& a, const Solid& b) {
  constexpr int kFew = 16;
  return a.topology().three_faces_at_vertices() && b.topology().three_faces_at_vertices() &&
         std::max(a.padded_count(), b.padded_count()) <= kFew;
}

/// Of the vertices farthest along the line between the middles (A) and against it (B) and of their
/// edges and faces, those that come nearest, tried as the answer. Only the proof can tell whether
/// others come nearer.
Trial certify_corners(const Solid& a, const Solid& b, const Lengths& length,
                      NearestFeatures& answer);

}  // namespace quoin::geometry
