#include <quoin/geometry/contact_type.hpp>

#include "certify/line_normal.hpp"
#include "contact/projected_feature.hpp"

namespace quoin::geometry {

std::string_view name(ContactType type) {
  switch (type) {
    case ContactType::VertexVertex:
      return "vertex-vertex";
    case ContactType::VertexEdge:
      return "vertex-edge";
    case ContactType::VertexFace:
      return "vertex-face";
    case ContactType::EdgeEdgeCrossing:
      return "edge-edge-crossing";
    case ContactType::EdgeEdgeParallel:
      return "edge-edge-parallel";
    case ContactType::EdgeFace:
      return "edge-face";
    case ContactType::FaceFace:
      return "face-face";
  }
  return "";
}

std::string_view name(FeatureKind kind) {
  switch (kind) {
    case FeatureKind::Vertex:
      return "vertex";
    case FeatureKind::Edge:
      return "edge";
    case FeatureKind::Face:
      return "face";
  }
  return "";
}

ContactType type_of(const Solid& p, const Solid& q, const VertexSet& set_p, const VertexSet& set_q,
                    FeatureKind kind_p, FeatureKind kind_q, double tolerance) {
  const auto [low, high] = std::minmax(kind_p, kind_q);
  if (low == FeatureKind::Vertex) {
    if (high == FeatureKind::Vertex) return ContactType::VertexVertex;
    return high == FeatureKind::Edge ? ContactType::VertexEdge : ContactType::VertexFace;
  }
  if (low == FeatureKind::Face) return ContactType::FaceFace;
  if (high == FeatureKind::Face) return ContactType::EdgeFace;
  const std::array<int, 2> e = segment_ends(p, set_p), f = segment_ends(q, set_q);
  return parallel(Side(p, e[0], e[1]), Side(q, f[0], f[1]), tolerance)
             ? ContactType::EdgeEdgeParallel
             : ContactType::EdgeEdgeCrossing;
}

void find_support_set(const Body& body, const Vector3& normal, double tolerance, SupportSet& set) {
  const Solid polyhedron(body, Vector3::Zero());
  VertexSet vertices;
  find_vertices_beyond(polyhedron, normal, support(polyhedron, normal).value - tolerance, vertices);
  set.vertices.assign(vertices.begin(), vertices.end());
  set.kind = span_kind(polyhedron, vertices, tolerance);
}

ContactType contact_type(const Body& body_a, const Body& body_b, const SupportSet& set_a,
                         const SupportSet& set_b, double tolerance) {
  const auto [middle, a, b] = PlacedPair(body_a, body_b);
  VertexSet vertices_a, vertices_b;
  for (const int v : set_a.vertices) vertices_a.push_back(v);
  for (const int v : set_b.vertices) vertices_b.push_back(v);
  return type_of(a, b, vertices_a, vertices_b, set_a.kind, set_b.kind, tolerance);
}

}  // namespace quoin::geometry
