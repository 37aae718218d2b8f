#pragma once
/// The part that two polygons in a contact plane share. Internal.

#include "numeric/floating_point.hpp"
#include "numeric/small_vector.hpp"
#include "polygon/contact_plane.hpp"
#include "shape/solid.hpp"
#include "shape/support.hpp"

namespace quoin::geometry {

/// A corner of the part that two patches share: a vertex of one on the other, or two crossed edges.
struct SharedCorner {
  Vector2 place;
  double height_p = 0.0, height_q = 0.0;
  Feature feature_p, feature_q;
  /// Of two crossed sides, as laid: how far the shorter one reaches across the longer, m.
  double across = kInfinity;
  double share = 0.0;  ///< of the shared area, m2
};
using SharedCorners = SmallVector<SharedCorner, 32>;

/// The convex polygon around places.
struct SharedPolygon {
  double area = 0.0;
  Vector2 centroid = Vector2::Zero();
};

/// Indices of the corners that are corners of the convex polygon around all, counter-clockwise.
void find_order(const SharedCorners& corners, SmallVector<int, 32>& order);

/// Also shares the area out over the corners, so that the shares have the polygon's area and
/// centroid.
void find_polygon(SharedCorners& corners, SharedPolygon& polygon);

/// Of the rounding: a place so near to a polygon counts as on its border. What rounding moves the
/// sides by reaches as far at a corner of 84 degrees; sharper ones get no more.
inline constexpr double kBesideBorder = 1.5;

/// What two whole faces that carry the answer share, laid once for the proof, the witnesses and the
/// contact points. Of other features only `corners` and `polygon` are filled.
struct ContactPolygon {
  int face_p = -1, face_q = -1;
  Support top_p, top_q;
  double clear = 0.0;  ///< m, at least tol: just the vertices of the faces are so near the tops
  ContactPlane plane;
  SharedCorners corners;
  double margin = 0.0;    ///< overlap_margin, m
  bool measured = false;  ///< `polygon` and the shares are known
  SharedPolygon polygon;
  bool convex = false;  ///< all corners are corners of the polygon; if `measured`
};

/// Lays both faces into the plane, and what they share.
void lay_faces(const Solid& p, const Solid& q, double gap, ContactPolygon& part);

/// As above, of the corners of two faces; once.
void find_polygon(ContactPolygon& part);

/// Of eps times the sizes of a pair, and of eps times the largest coordinate: how far outside a
/// patch still counts as on its border. Two places are known to sqrt(3) eps of the coordinate. A
/// point may then lie kBesideBorder times that beside its solid and kFlatLabel times that off it:
/// 1.75 times 9 eps of the diameter or 1.75 eps of the coordinate, and its own rounding, sqrt(3) /
/// 2 eps of the coordinate. That is less than the 16 eps and 4 eps that are promised.
inline constexpr double kBorderSize = 4.5, kBorderCoordinate = 1.75;
/// Of that rounding: what the vertices of a label may be off it and count as on it. A turned label
/// is off by as much.
inline constexpr double kFlatLabel = 0.9;

/// How far outside a patch still counts as on its border, m: what rounding leaves of a place.
double border_rounding(const Solid& p, const Solid& q, double gap);

}  // namespace quoin::geometry
