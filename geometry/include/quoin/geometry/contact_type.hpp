#pragma once
/// The contact types and which one a pair is in.

#include <cstdint>
#include <quoin/geometry/nearest_features.hpp>
#include <string_view>

namespace quoin::geometry {

enum class ContactType : std::uint8_t {
  VertexVertex,
  VertexEdge,
  VertexFace,
  EdgeEdgeCrossing,
  EdgeEdgeParallel,
  EdgeFace,
  FaceFace
};

std::string_view name(ContactType type);  ///< "vertex-vertex" … "face-face"

}  // namespace quoin::geometry
