#pragma once
/// The part that two polygons in a contact plane share. Private to the room.

#include <quoin/geometry/polyhedron.hpp>
#include <span>

#include "contact_plane.hpp"
#include "polygon_rows.hpp"
#include "small_vector.hpp"
#include "support.hpp"

namespace quoin::geometry {

/// A corner of the part that two patches share: a vertex of one on the other, or two crossed edges.
struct SharedCorner {
  Vector2 place;
  double height_p = 0.0, height_q = 0.0;
  Feature feature_p, feature_q;
  double share = 0.0;  ///< of the shared area, m2
};
using SharedCorners = SmallVector<SharedCorner, 32>;

/// The convex polygon around places: indices in counter-clockwise order, its area.
struct SharedPolygon {
  SmallVector<int, 32> order;
  double area = 0.0;
  Vector2 centroid = Vector2::Zero();
};

/// Also shares the area out over the corners, so that the shares have the polygon's area and
/// centroid.
void find_polygon(SharedCorners& corners, SharedPolygon& polygon);

/// Indices of the convex hull of places, counter-clockwise (monotone chain, [Andrew 1979]).
void hull_order(std::span<const Vector2> places, SmallVector<int, 32>& order);

/// How two polygons lie over each other.
struct Overlay {
  double margin = 0.0;    ///< overlap_margin, m
  bool in_order = false;  ///< the corners were added counter-clockwise around the shared polygon
};

/// Adds the corners that two polygons share; `rounding` (m) is how far outside still counts as on
/// the border.
Overlay append_shared_of_polygons(const PolygonRows& p, const PolygonRows& q, double rounding,
                                  SharedCorners& corners);

/// What two whole faces that carry the answer share, laid once for the proof, the witnesses and the
/// contact points. Of other features only `corners` and `polygon` are filled.
struct SharedPart {
  int face_p = -1, face_q = -1;
  Support top_p, top_q;
  double clear = 0.0;  ///< m, at least tol: just the vertices of the faces are so near the tops
  ContactPlane plane;
  PolygonRows p, q;
  SharedCorners corners;
  Overlay overlay;
  SharedPolygon polygon;
};

/// Lays both faces into the plane and adds the corners they share; false: they have too many.
bool lay_faces(const Polyhedron& p, const Polyhedron& q, double gap, SharedPart& part);

/// As above, of the corners of two faces.
void find_polygon(SharedPart& part);

/// How far outside a patch still counts as on its border, m: what rounding leaves of a place.
double border_rounding(const Polyhedron& p, const Polyhedron& q, double gap);

}  // namespace quoin::geometry
