#pragma once
/// Polyhedra from plain data, checked on the way in. Every function throws InputError naming the
/// feature, the value and the limit when the data does not make a convex solid.

#include <quoin/geometry/shape.hpp>
#include <string>

namespace quoin::geometry {

inline constexpr int kMostHullPoints = 100000;  ///< points that make_hull takes
inline constexpr int kMostVertices = 10000;     ///< vertices that one polyhedron may have
/// How far a face given may be off its plane, and a vertex beyond it, as a share of the diameter.
inline constexpr double kFlatness = 1e-6;

/// Axis-aligned box between two corners, m. Vertex i + 2 j + 4 k stands at corner (i, j, k). As
/// large and as thick as make_hull asks.
Shape make_box(const Vector3& min, const Vector3& max);

/// Prism: a convex polygon (3 × n, planar, either direction, m) swept along `sweep` (m). Vertices:
/// the polygon's, then the swept ones in the same order.
Shape make_prism(const Eigen::Ref<const Points>& polygon, const Vector3& sweep);

/// The length to which labels are known, the *label length*, m: kFlatShare of the diagonal of the
/// points' box, or what a turn and a shift leave of exact coordinates, kRoundings eps of the
/// largest one (products and sums: 3.5 eps for each vertex; a face of four doubles that twice), but
/// never more than kCoarsestShare of the diagonal: beyond, the rounding is the shape. Throws
/// InputError where there are no points.
inline constexpr double kFlatShare = 1e-9;
inline constexpr double kRoundings = 16;
inline constexpr double kCoarsestShare = 1e-3;
double label_length(const Eigen::Ref<const Points>& points);

/// A convex hull and where its vertices stood in the input.
struct Hull {
  Shape polyhedron;
  std::vector<int> input_index;  ///< hull vertex -> column of the input, ascending
};

/// Exact convex hull of points (3 × n, m). All its corners are kept, points that are exactly no
/// corner are left out, of equal points the first is kept.
///
/// Labels know rounding: facets that lie within the label length of one plane make one face, whose
/// corners are those of the polygon. A vertex that is no corner within the label length (on an
/// edge, in a face, or beside a corner) has a host in the topology. Numbering and powers of two
/// change neither faces nor corners, and mirrors neither, but for ties: where a solid is its own
/// mirror image, coordinates decide, and a nearly flat arc may be parted on the other side, or
/// another of several vertices within the label length of each other be the corner.
///
/// Refused: fewer than 4 or more than kMostHullPoints points; NaN, infinity and sizes beyond
/// kLargestCoordinate and kSmallestExtent; points in one plane, that is a thickness of no more than
/// the label length. *Thickness* is the least extent of the exact hull across one of its facets: at
/// least its width, and at most three times that.
Hull make_hull(const Eigen::Ref<const Points>& points);

struct ShapeOptions {
  /// By how much each coordinate may be off for its rounding, m: half a unit of the last digit of a
  /// file. A vertex may then lie off the plane of a face, or outside, by what planes through three
  /// such vertices leave open (2 √3 of it, times 1 + the diameter / the width of the face), and
  /// 2 √3 of it inside the hull.
  double coordinate_rounding = 0.0;
};

/// Shape by vertices (3 × n, m) and faces (polygons or triangles, either orientation
/// throughout: inside-out is turned round); checked: finite, closed, convex and planar within
/// kFlatness or what options.coordinate_rounding leaves open, no equal points, no unused vertex,
/// sizes and thickness as in make_hull. Faces are merged and labelled as in make_hull; vertices on
/// the border of two faces may be named by both. The solid is the convex hull of the vertices; all
/// of them are kept. Where the faces given leave it by more than the label length (as coordinates
/// in single precision do), the facets of the exact hull take their place, in the same order, and
/// vertices below them are in no face.
Shape make_shape(const Eigen::Ref<const Points>& vertices,
                 const std::vector<std::vector<int>>& faces, const ShapeOptions& options = {});

/// Several shapes as one surface: vertices, edges and faces of part after part, in their order. It
/// is for mass_properties, pictures and look-ups by feature; a search takes convex shapes alone.
/// Throws InputError for no parts.
Shape join(std::span<const Shape> parts);

/// What is wrong with a solid, in words.
struct ShapeFault {
  std::string text;     ///< names the feature, the value and the limit
  bool refused = true;  ///< by make_shape(); false: it takes it, and turns faces round
};

/// Everything that is wrong with vertices (3 × n, m) and faces, as make_shape() takes them: counts,
/// coordinates that are not finite, equal points, faces that are no closed surface, no thickness,
/// faces that run inside out, each face off its plane and each with a vertex outside. One line a
/// face at most. Nothing is refused by make_shape() where nothing is `refused` here. Throws nothing
/// of data.
std::vector<ShapeFault> shape_faults(const Eigen::Ref<const Points>& vertices,
                                     const std::vector<std::vector<int>>& faces,
                                     const ShapeOptions& options = {});

}  // namespace quoin::geometry
