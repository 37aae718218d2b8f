#include <quoin/geometry/contact_type.hpp>

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

std::string_view name(PairStatus status) {
  switch (status) {
    case PairStatus::Separated:
      return "separated";
    case PairStatus::Touching:
      return "touching";
    case PairStatus::Overlapping:
      return "overlapping";
    case PairStatus::NotConverged:
      return "not-converged";
  }
  return "";
}

std::string_view name(PlaneRule rule) {
  switch (rule) {
    case PlaneRule::Unique:
      return "unique";
    case PlaneRule::ShortestLine:
      return "shortest-line";
    case PlaneRule::LeastOverlap:
      return "least-overlap";
    case PlaneRule::MiddleOfPlanes:
      return "middle-of-planes";
  }
  return "";
}

}  // namespace quoin::geometry
