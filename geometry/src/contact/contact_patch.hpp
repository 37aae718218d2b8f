#pragma once
/// What the support polygons of a pair share, where it is no overlay of two whole labels: heights
/// by the solids' surfaces, names where tol cuts a face, shares with the polygon's first moment.
/// Internal.

#include "contact/outer_surface.hpp"
#include "polygon/projected_feature.hpp"

namespace quoin::geometry {

/// The surfaces of both solids near their support planes.
struct Surfaces {
  OuterSurface p, q;
  /// `depth` (m) below the support planes: see OuterSurface.
  Surfaces(const Solid& solid_p, const Solid& solid_q, const ContactPlane& plane, double depth,
           double rounding)
      : p(solid_p, plane, 1.0, depth, rounding), q(solid_q, plane, -1.0, depth, rounding) {}
  /// Heights of all but the vertices themselves, which are in the surface; where a solid ends,
  /// those of its labels stay.
  void lift(SharedCorners& corners) const;
  /// The same of one; false where a solid ends: labels reach beyond it by the length to which they
  /// are known.
  bool lift(SharedCorner& corner) const;
};

/// The ends of the stretch in which two parallel edges, laid, lie over each other: midway between
/// them, as they may lie beside each other by the contact length. False: there is none, by more
/// than `rounding` (m).
bool find_shared_stretch(const ProjectedFeature& edge, const ProjectedFeature& other,
                         double rounding, std::array<Vector2, 2>& ends);

/// Height of an edge, laid, at the foot of a place.
double height_along(const ProjectedFeature& edge, const Vector2& place);

/// Is no point named by these two features?
bool is_free(const Feature& feature_p, const Feature& feature_q, const SharedCorners& points);

/// Names a place on the borders of both support polygons by two edges: their own, or, where a side
/// is none because tol cuts a face, those beside it; the first two that no other point is named by.
/// False: there are none.
bool name_cut(const Solid& p, const Solid& q, const ProjectedFeature& patch_p,
              const ProjectedFeature& patch_q, const SharedCorners& points, SharedCorner& corner);

/// A vertex on a face, on an edge of that face or beside it by `tolerance` (m) at most, lies on the
/// face across the edge as well. Names of such faces the one that leans least from the contact
/// plane: rounding says over which of them the place lies, and their normals are not alike.
/// `outward`: +1 for P, -1 for Q. Nothing to do where one face is all that may carry points.
void name_least_leaning(const Solid& solid, const ContactPlane& plane, double outward,
                        double tolerance, SharedCorners& corners);

/// Is a place within `tolerance` (m) of the segment between two places?
bool near_segment(const Vector2& from, const Vector2& to, const Vector2& place, double tolerance);

/// Is a place within `tolerance` (m) of the convex hull of the points?
bool near_hull(const SharedCorners& points, const Vector2& place, double tolerance);

/// Does a place lie inside the convex hull of the points, whose corners `order` names, by more than
/// `tolerance` (m)?
bool well_inside(const SharedCorners& points, const SmallVector<int, 32>& order,
                 const Vector2& place, double tolerance);

/// The place in the convex hull of corners that is nearest to a place: a corner, with its names, or
/// nameless.
SharedCorner nearest_in_hull(const SharedCorners& corners, const Vector2& place);

/// Moves shares among points so that they have the polygon's first moment, if its centroid lies in
/// the points' hull. All shares are lessened alike; the two points between which the ray from the
/// shares' centroid through the polygon's leaves the hull take what that sets free. Where it lies
/// outside, their moment is that of the nearest place in the hull.
void balance_shares(const SharedPolygon& polygon, SharedCorners& points);

}  // namespace quoin::geometry
