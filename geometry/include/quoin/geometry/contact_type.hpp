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
std::string_view name(FeatureKind kind);  ///< "vertex", "edge", "face"

/// The vertices of a body within tol of its support plane, ascending, and what they span: a point,
/// a segment or a polygon.
struct SupportSet {
  std::vector<int> vertices;
  FeatureKind kind = FeatureKind::Vertex;
};

}  // namespace quoin::geometry
