#pragma once
/// Every factor by which rounding decides, in one place. Internal. (Those of the exact overlap
/// alone stand there, see geometry/README.md, "Ties"; what only speed hangs on stands where it is
/// used.) u = eps / 2 is the relative error of one step. D is the larger diameter of a pair: twice
/// the distance of the farthest vertex from the middle of its body, so r = D / 2 bounds all
/// offsets. Factors said to be *chosen* are no bounds: they leave room between what two ways to an
/// answer may see, and cost speed alone where they are too wide (the next way decides) – the
/// certificates and the property tests hold the answers.

#include "numeric/floating_point.hpp"

namespace quoin::geometry {

// ---- lengths of a pair (Lengths) ----

/// The *rounding* of a pair, of eps D. A scan sums three products of offsets that are rounded once:
/// 4 u r = eps D for either solid, 2 for both; the difference of two vertices up to 2 D apart: u
/// 2 D = 1; the search stops `kSearchShare` of the whole short: 1.25. Together 4.25; the rest is
/// for the length of the normal.
inline constexpr double kRounding = 5;
/// Of the rounding: a corner that brings the search less than that is no gain.
inline constexpr double kSearchShare = 0.25;
/// Of what the search is given, hence the whole rounding: solids nearer than that share a point as
/// far as doubles can tell.
inline constexpr double kNothing = 1.0 / kSearchShare;
/// Of eps times the largest coordinate: a coordinate is known to u of it, a place to sqrt(3) u, two
/// places to sqrt(3) eps.
inline constexpr double kPlaceRounding = 2;
/// The least tolerance, of eps times the largest coordinate: a turn and a shift leave of one place
/// 4 sums and products, sqrt(3) 4 u < 3.5 eps; a plane over it, four such places.
inline constexpr double kLeastTolerance = 16;
/// The default tolerance, of the smaller diameter: a convention.
inline constexpr double kDefaultTolerance = 1e-9;
/// Ratio of diameters: up to here the rounding of the larger solid, 5 eps 1e4 = 1.1e-11 of the
/// smaller one, lies a hundredfold below that tolerance.
inline constexpr double kUneven = 1e4;

// ---- what is clear (of the rounding) ----

/// A vertex between these multiples below a support plane might be sorted otherwise on another way.
/// Half a rounding and the two scans' 2 eps D stay within one rounding; 64: chosen.
inline constexpr double kClearBelow = 0.5, kClearAbove = 64;
/// Of the widest of the lengths: a line that rounding turns by no more than what lifts a vertex by
/// this brings none within that length that lies as much below; chosen.
inline constexpr double kTurnedShare = 1.0 / 16;
/// A foot is *firm* in a face where it lies so far inside the border, 3e7 eps D. A plane that meets
/// the border there and leans by t is worse by at least half of t times this: of those as good
/// within three roundings none leans by more than 1e-6 rad (kOneDirection).
inline constexpr double kFirm = 6e6;
/// Solids apart: the line between their features, off by one rounding, leans less than 1 / 8 rad.
inline constexpr double kApart = 8;
/// An overlap proved to be the only one beats all others by this, and by `kAloneShare` of itself:
/// chosen.
inline constexpr double kAlone = 64, kAloneShare = 1e-9;
/// The bound of a polytope is less than its plane by the facet's own rounding: (2.5 + 0.25) eps of
/// corners at most 2 D away, 5.5 eps D; with the 5 of the rounding less than 11, 2.2 of it.
inline constexpr double kOverlapRounding = 2.2;
/// Of eps and the gap: the normal's length (2), its product with a difference (1.5 and 0.5), of the
/// bound and of the plane.
inline constexpr double kGapRounding = 8;

/// Faces that touch: how far planes may lean that come near the best one, and the depth along such
/// a plane is still that of the best: relative, by tilt^2 / 2 = 1.3e-13. geometry/README.md,
/// "Touching faces".
inline constexpr double kTouchingTilt = 5e-7;
/// Of the rounding: what box SAT may measure a plane of true parallelepipeds differently from a
/// scan of them, one eps D: half of either for the corners. Whether several planes are as good
/// (kBothPart) is decided by double-double where it comes nearer to that limit than this, and what
/// the bricks are off theirs.
inline constexpr double kTieBand = 0.2;
/// Cosine of the angle between two faces that may touch; only speed hangs on it.
inline constexpr double kTouchingOpposite = -1.0 + 1e-6;

// ---- search (GJK) ----

/// Of eps and the newest corner along the direction: two products of three terms, 1.5 eps each, and
/// their corners, 0.5 each.
inline constexpr double kGainRounding = 4;

// ---- polytope (EPA), of eps times how far the corners are from the origin ----

/// A facet's distance is off by its corners (0.5), a product (1.5) and the length of its normal
/// (0.5), and by the normal's cancellation: a quarter of `cancelled`.
inline constexpr double kFacetRounding = 2.5, kFacetCancelled = 0.25;
/// Of the polytope's rounding, a quarter of the pair's: facets within three roundings of the pair
/// are as near: two by which planes tie (kBothPart), one for the planes of noise beside them.
inline constexpr double kAsNear = 3 / kSearchShare;
/// Of eps D: a triangle higher than that has a normal that its corners' rounding, eps D, turns by
/// less than 1e-6 rad. A slimmer one's direction is not known.
inline constexpr double kSlimHeight = 1e6;
/// Squared: directions within 1e-6 rad count as one.
inline constexpr double kOneDirection = 1e-12;
/// Cosine: EPA takes directions within 4.5e-7 rad for one, half of that: it leaves those between
/// the two to the exact overlap.
inline constexpr double kSurelyOneDirection = 1.0 - 1e-13;

// ---- bricks (SAT) ----

/// Of eps D: a corner is the sum of a middle and three halves, 4 sqrt(3) u; with the middle's own
/// less than 8. Of eps times the largest coordinate: from six rounded corners to a seventh, 6
/// sqrt(3) u, less than 8, too.
inline constexpr double kBrickRounding = 8;
/// Of eps times the reach: the sum of seven products of three terms, with room; and the
/// cancellation of the cross product once.
inline constexpr double kDirectionRounding = 8;
/// Sine of the angle between two edges that span no direction: chosen; other ways decide then.
inline constexpr double kParallelSine = 1e-6;
/// Of the bricks' errors, and of the rounding: how much worse all other directions have to be. See
/// geometry/README.md, "Least overlap".
inline constexpr double kBrickErrors = 4, kBrickClear = 16;
/// Of the rounding, one for either plane: both part the solids as well.
inline constexpr double kBothPart = 2;

// ---- double-double ----

/// 106 bits are 1.2e-32; products of three lengths with cancelled differences, with room.
inline constexpr double kWideEpsilon = 1e-29;
/// Of eps times the product of three edges: below, the sign of a volume is decided in
/// double-double. [Shewchuk 1997]: off by 3.5 eps of the permanent, which is at most 6 / sqrt(27)
/// = 1.16 times that product, and the differences by 1.5; 5.6, with room.
inline constexpr double kVolumeRounding = 16;
/// Of the same product: below, the sign is decided exactly. Three products in a row and five sums
/// of double-doubles, 4 units of 2^-106 each, of at most 1.16 times that product: 4e-31, with room.
inline constexpr double kWideVolumeRounding = 1e-30;
inline constexpr double kKeyRounding = 4;  ///< of eps: a distance found again; chosen
/// Of eps: of the unit normal of a facet from doubles, times lengths / area; the same of a rounded
/// exact one; and of the product of such a normal with a difference.
inline constexpr double kNormalRounding = 6, kExactNormalRounding = 2, kHeightRounding = 4;
/// Of eps |d| D: a vertex that a scan has put so far below the top is not the exact one. Two values
/// are off by eps D / 2 each; chosen with room.
inline constexpr double kWideSupport = 8;
/// Of eps D: where the exact search makes no step, nearer solids are taken to touch; chosen, and
/// decided by the planes between them.
inline constexpr double kStalled = 64;
/// Of eps times the smaller diameter and the distance: a gain so small is of no matter to the gap,
/// and the exact search may end where it makes no more of it; chosen.
inline constexpr double kIdleGain = 1.0 / 256;

// ---- polygons ----

/// Of eps times the sums of coordinates of two ways: four relative errors of half an eps in either
/// product of their differences.
inline constexpr double kTurnRounding = 2;

// ---- queries ----

/// Of eps times the lengths summed: a vertex of an image, differences of two, a product.
inline constexpr double kQueryRounding = 32;
/// Of eps times a body's size: a point against one plane.
inline constexpr double kPointRounding = 16;

}  // namespace quoin::geometry
