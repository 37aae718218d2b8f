#include <quoin/geometry/contact_point.hpp>

namespace quoin::geometry {
namespace {

/// The body's vertices where they stand. TODO: searches that scan in the shape's frame; meanwhile
/// a query of two bodies copies both.
Polyhedron placed(const Body& body) {
  Polyhedron solid(body.shape());
  Points vertices(3, solid.vertex_count());
  for (int v = 0; v < solid.vertex_count(); ++v) vertices.col(v) = body.vertex(v);
  solid.set_vertices(vertices);
  return solid;
}

}  // namespace

double default_tolerance(const Body& a, const Body& b) {
  return default_tolerance(a.shape(), b.shape());
}

NearestFeatures nearest_features(const Body& a, const Body& b, const SearchOptions& options,
                                 const FeatureHint& hint) {
  return nearest_features(placed(a), placed(b), options, hint);
}

NearestFeatures append_contacts_within_reach(const std::array<int, 2>& blocks, const Body& a,
                                             const Body& b, const ContactOptions& options,
                                             const FeatureHint& hint,
                                             std::vector<ContactPoint>& contacts) {
  return append_contacts_within_reach(blocks, placed(a), placed(b), options, hint, contacts);
}

void update_pair_contact(const Body& a, const Body& b, const ContactOptions& options,
                         PairContact& contact) {
  update_pair_contact(placed(a), placed(b), options, contact);
}

}  // namespace quoin::geometry
