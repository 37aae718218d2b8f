#pragma once
/// What two solids share in a contact plane, clipped independently of the library: which vertices
/// carry the contact, its type, the corners of the shared part, its area and centroid.
///
/// Computed in long double from the exact places (referee/pairs/exact_arbiter). A convex clip moves
/// no corner off the lines it lies on by more than the rounding of its places, 2^-60 of the pair's
/// extent; every band below is at least 2 eps = 2^-51 of it, so no judgement hangs on that
/// rounding.

#include <quoin/geometry/contact_type.hpp>
#include <vector>

#include "referee/pairs/exact_arbiter.hpp"

namespace quoin::referee {

using Place = std::array<long double, 2>;  ///< in the contact plane, m

/// Lengths within which a decision is open, m.
struct PatchBands {
  double tolerance = 0;  ///< contact length tol
  double decision = 0;   ///< a height or length nearer to tol than this may fall either way
  double border = 0;     ///< what is so near to a border counts as on it
};

struct PatchCorner {
  Place place;
  long double sine = 1;  ///< of the lines that cross there; 1 at a vertex
  /// Where two sides cross: unit, out of the support polygons of A and B across them; 0 where the
  /// corner lies on no side of that polygon.
  std::array<Place, 2> outward{};
  std::array<Place, 2> middle{};  ///< of those sides of the support polygons
  long double excess = 0;         ///< its gap is at most so much above the least one, m
};

struct ExactPatch {
  geometry::ContactType type = geometry::ContactType::VertexVertex;
  /// No height, length, width or angle is within the band about tol: the type is beyond doubt, and
  /// so is what follows.
  bool clear = true;
  std::vector<PatchCorner> corners;  ///< counter-clockwise seen against the normal; or the two ends
                                     ///< of a segment; or one point
  long double area = 0;              ///< m2; 0 unless face-face
  long double perimeter = 0;         ///< of the shared polygon, m
  Place centroid{};
  int support_vertices = 0;  ///< points of either solid within tol of its support plane
  std::array<std::vector<Place>, 2> support;  ///< the convex hulls of these in the plane
  /// Where a segment has several pairs of ends that are farthest apart within the band of
  /// decisions: how far any of them lies from those taken here, m.
  long double open_ends = 0;
};

/// Coordinates in and along the plane across a unit normal.
class PlaneFrame {
 public:
  explicit PlaneFrame(const geometry::Vector3& normal);
  Place place(const RealPoint& x) const { return {dot(u_, x), dot(v_, x)}; }
  long double height(const RealPoint& x) const { return dot(n_, x); }
  RealPoint point(const Place& place, long double height) const;

 private:
  static long double dot(const RealPoint& p, const RealPoint& q) {
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
  }
  RealPoint n_, u_, v_;
};

/// Support planes of both solids along a unit normal from A to B.
ExactPatch exact_patch(const ExactPair& pair, const geometry::Vector3& normal,
                       const PatchBands& bands);

/// Do both solids end at a corner where sides of their support polygons cross? Where tol cuts a
/// face, a side of the polygon runs through the face, nothing of the solid ends there, and no edge
/// could name the corner. The solid goes on when on the line along the normal through a place 1e-6
/// of `extent` (m) further out it has a point no more than 2 tol below the support plane, that is,
/// for tol = 1e-9 of the extent, when it falls by less than 0.002. (A quarter of tol is tried after
/// the other, as a solid may be no thicker than tol.)
bool ends_at(const ExactPair& pair, const geometry::Vector3& normal, const PatchCorner& corner,
             double tolerance, double extent);

/// Does the corner lie on a side that runs through a face? So it does when the solid goes on, as
/// above, out of the middle of the side. Near the ends of such a side the solid itself ends: what
/// can be named there are its own edges, beside which the corner lies, and not the corner.
bool lies_on_cut(const ExactPair& pair, const geometry::Vector3& normal, const PatchCorner& corner,
                 double tolerance, double extent);

/// Is there a place within `tolerance` (m) of a corner where both solids reach to within half of it
/// of their support planes, by more than `slack` (m) inside either? Parallel edges count as one
/// line when they lie beside each other by less than tol. The solids may end, or fall off steeply,
/// before they come to lie over each other: there is no line along the normal, then, that meets
/// both within tol of the least gap, and a contact point would lie off one of them. Where there is
/// one, a point is asked for: a gap is at most tol above the least, half of it from either solid.
bool both_reach(const ExactPair& pair, const geometry::Vector3& normal, const PatchCorner& corner,
                double tolerance, double slack);

/// Lengths that a point at a corner is asked for by, m.
struct CornerLengths {
  double tolerance = 0.0;  ///< tol
  double extent = 0.0;     ///< of the smaller solid
  double slack = 0.0;      ///< allowed error of a gap of 0
};

/// Must there be a contact point at a corner of the patch? ends_at(), and of parallel edges
/// both_reach().
bool asks_for_point(const ExactPair& pair, const geometry::Vector3& normal, const ExactPatch& patch,
                    const PatchCorner& corner, const CornerLengths& lengths);

/// Lowest point of B less highest of A along a unit normal, m: the gap if the normal is right.
long double gap_along(const ExactPair& pair, const geometry::Vector3& normal);

/// Distance of a place from the convex hull of places, m; infinite when there are none.
long double distance_to_places(const std::vector<Place>& places, const Place& place);

/// Area (m2) and centroid of a convex polygon.
long double polygon_area(const std::vector<Place>& polygon, Place& centroid);

}  // namespace quoin::referee
