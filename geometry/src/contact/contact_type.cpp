#include <cmath>
#include <quoin/geometry/contact_type.hpp>

#include "numeric/numbers.hpp"
#include "polygon/line_normal.hpp"
#include "polygon/projected_feature.hpp"

namespace quoin::geometry {

void find_support_set(const Body& body, const Vector3& normal, double tolerance, SupportSet& set) {
  require_length(tolerance, "support set: tolerance");
  const Placement& stands = body.placement();
  if (!std::isfinite(normal.sum() + stands.linear.sum() + stands.translation.sum()))
    throw InputError("support set: the normal or the placement is not finite");
  const Solid polyhedron(body, Vector3::Zero());
  VertexSet vertices;
  find_vertices_beyond(polyhedron, normal, support(polyhedron, normal).value - tolerance, vertices);
  set.vertices.assign(vertices.begin(), vertices.end());
  set.kind = span_kind(polyhedron, vertices, tolerance);
}

ContactType contact_type(const Body& body_a, const Body& body_b, const SupportSet& set_a,
                         const SupportSet& set_b, double tolerance) {
  require_length(tolerance, "contact type: tolerance");
  if (set_a.vertices.empty() || set_b.vertices.empty())
    throw InputError("contact type: a support set is empty");
  const PlacedPair pair(body_a, body_b);
  VertexSet vertices_a, vertices_b;
  for (const int v : set_a.vertices) vertices_a.push_back(v);
  for (const int v : set_b.vertices) vertices_b.push_back(v);
  return type_of(pair.a, pair.b, vertices_a, vertices_b, set_a.kind, set_b.kind, tolerance);
}

}  // namespace quoin::geometry
