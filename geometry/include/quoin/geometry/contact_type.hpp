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

/// The vertices of `body` within `tolerance` (m) of its support plane along `normal` (unit),
/// ascending, and what they span: a point, a segment or a polygon.
/// Throws InputError for a normal, a placement or a tolerance that is not finite, and for a
/// negative tolerance.
struct SupportSet {
  std::vector<int> vertices;
  FeatureKind kind = FeatureKind::Vertex;
};
void find_support_set(const Body& body, const Vector3& normal, double tolerance, SupportSet& set);

/// The type that follows from the two support sets along `normal` (A to B). Two edges are parallel
/// when sin(angle) × shorter length <= tolerance (m).
/// Throws InputError for an empty set and as find_support_set does for the tolerance.
ContactType contact_type(const Body& a, const Body& b, const SupportSet& set_a,
                         const SupportSet& set_b, double tolerance);

}  // namespace quoin::geometry
