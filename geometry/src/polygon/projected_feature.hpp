#pragma once
/// Convex patches of two polyhedra laid into one contact plane, and where they cover each other.
/// Internal.

#include <quoin/geometry/contact_type.hpp>

#include "numeric/late_init.hpp"
#include "polygon/contact_plane.hpp"
#include "polygon/contact_polygon.hpp"
#include "shape/support.hpp"

namespace quoin::geometry {

struct ProjectedCorner {
  int vertex = 0;       ///< -1: none
  int edge = -1;        ///< from this corner to the next; -1: none of the topology
  Vector2 place;        ///< in the contact plane, m
  double height = 0.0;  ///< along the normal, m
};

/// A vertex, an edge or a face laid into the contact plane; counter-clockwise seen against the
/// normal.
struct ProjectedFeature {
  SmallVector<ProjectedCorner, 16> corners;
  Feature label;  ///< the feature it is; for a vertex or an edge see `face`
  int face = 0;   ///< the face that names points on it: its own, or the most facing
  Vector2 slope = Vector2::Zero();  ///< of its surface: height = corner height + slope · step
  double surface_height(const Vector2& place) const {
    return corners[0].height + slope.dot(place - corners[0].place);
  }
};

/// Of some faces the one whose normal has the greatest product with `direction`; -1: none.
int facing_face(const Solid& polyhedron, std::span<const int> faces, const Vector3& direction);

/// Lays a feature of a polyhedron into the plane. `outward` is +1 for P, -1 for Q: the side that
/// faces the other.
void lay_feature(const Solid& polyhedron, const Feature& feature, const ContactPlane& plane,
                 double outward, ProjectedFeature& patch);

/// Is a set (ascending) just the vertices of a feature, so that it is laid as that? Those of a face
/// must all be corners of its label, and go round a convex polygon (LabelFit::outside).
bool is_just(const Solid& polyhedron, const Feature& feature, const VertexSet& vertices);

/// Lays a support set into the plane; just the vertices of a face as its label has them.
void lay_support_set(const Solid& polyhedron, const VertexSet& vertices, FeatureKind kind,
                     const ContactPlane& plane, double outward, ProjectedFeature& patch);

/// Lays what of a solid lies within `depth` (m) of its support plane: vertices, and where sides of
/// its surface go deeper (`vertex` -1). `face` names what is found on it.
void lay_top(const Solid& polyhedron, int face, const ContactPlane& plane, double outward,
             double depth, ProjectedFeature& patch);

/// Do all corners of a laid polygon lie in its plane within `rounding` (m)? Then a place on it is
/// one of the solid. Vertices within tol of a support plane need not belong to one label.
bool is_flat(const ProjectedFeature& patch, double rounding);

/// What a support set spans: a point no longer than `tolerance`, a segment no wider, or a polygon.
FeatureKind span_kind(const Solid& polyhedron, const VertexSet& vertices, double tolerance);

/// Do the vertices of a face span a polygon?
bool is_wide(const Solid& polyhedron, int face, double tolerance);

/// The same of both faces.
inline bool are_wide(const Solid& p, const Solid& q, const ContactPolygon& part, double tolerance) {
  return is_wide(p, part.face_p, tolerance) && is_wide(q, part.face_q, tolerance);
}

/// The feature of the topology that best names a support set.
Feature name_support_set(const Solid& polyhedron, const VertexSet& vertices, FeatureKind kind,
                         const Vector3& outward);

/// The contact type that two support sets make.
ContactType type_of(const Solid& p, const Solid& q, const VertexSet& set_p, const VertexSet& set_q,
                    FeatureKind kind_p, FeatureKind kind_q, double tolerance);

/// The two vertices of a segment: the pair of the set that lies farthest apart.
std::array<int, 2> segment_ends(const Solid& polyhedron, const VertexSet& vertices);

}  // namespace quoin::geometry
