#include <quoin/geometry/build.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <utility>

#include "numeric/numbers.hpp"
#include "shape/convex_hull.hpp"
#include "shape/face_labels.hpp"
#include "shape/polygon_area.hpp"
#include "shape/rows.hpp"

namespace quoin::geometry {
namespace {

/// Diagonal of the box around points: the same bits whichever way the axes are named.
double diagonal(const Eigen::Ref<const Points>& points) {
  Vector3 size = points.rowwise().maxCoeff() - points.rowwise().minCoeff();
  std::sort(size.begin(), size.end());
  return size.norm();
}

/// Columns in the order of their coordinates; of equal ones the first comes first.
std::vector<int> by_coordinates(const Eigen::Ref<const Points>& points) {
  std::vector<int> order(at(static_cast<int>(points.cols())));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int i, int j) {
    for (int k = 0; k < 3; ++k)
      if (points(k, i) != points(k, j)) return points(k, i) < points(k, j);
    return i < j;
  });
  return order;
}

void check_equal_points(const Eigen::Ref<const Points>& points) {
  const std::vector<int> order = by_coordinates(points);
  for (std::size_t k = 1; k < order.size(); ++k) {
    if (points.col(order[k - 1]) == points.col(order[k])) {
      throw InputError("points " + std::to_string(order[k - 1]) + " and " +
                       std::to_string(order[k]) + " are equal");
    }
  }
}

/// Of equal points the first, ascending.
std::vector<int> distinct(const Eigen::Ref<const Points>& points) {
  const std::vector<int> order = by_coordinates(points);
  std::vector<int> kept;
  for (std::size_t k = 0; k < order.size(); ++k)
    if (k == 0 || points.col(order[k - 1]) != points.col(order[k])) kept.push_back(order[k]);
  std::sort(kept.begin(), kept.end());
  return kept;
}

void check_points(const Eigen::Ref<const Points>& points, int limit) {
  check_rounding_mode();
  const std::string count = std::to_string(points.cols()) + " points";
  if (points.cols() < 4) throw InputError(count + ", at least 4 needed");
  if (points.cols() > limit)
    throw InputError(count + ", at most " + std::to_string(limit) + " allowed");
  for (int i = 0; i < points.cols(); ++i) {
    const double largest = points.col(i).cwiseAbs().maxCoeff();
    if (!points.col(i).allFinite())
      throw InputError("point " + std::to_string(i) + " has a coordinate that is not finite");
    if (largest > kLargestCoordinate) {
      throw InputError("point " + std::to_string(i) + " has a coordinate of " + text(largest) +
                       " m, limit " + text(kLargestCoordinate) + " m");
    }
  }
  const double extent = (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).maxCoeff();
  if (extent > 0.0 && extent < kSmallestExtent) {
    throw InputError("the largest extent of the points is " + text(extent) + " m, limit " +
                     text(kSmallestExtent) + " m");
  }
}

/// Renumbers the vertices that the polygons use, of `count`, ascending; returns their old numbers.
template <typename Polygons>
std::vector<int> compress(int count, Polygons& polygons) {
  std::vector<int> name(at(count), -1), used;
  for (const auto& polygon : polygons)
    for (const int v : polygon) name[at(v)] = 0;
  for (int v = 0; v < count; ++v) {
    if (name[at(v)] < 0) continue;
    name[at(v)] = static_cast<int>(used.size());
    used.push_back(v);
  }
  for (auto& polygon : polygons)
    for (int& v : polygon) v = name[at(v)];
  return used;
}

double volume(const Eigen::Ref<const Points>& vertices, const Faces& faces) {
  const Vector3 origin = vertices.col(0);
  double six_volumes = 0.0;
  for (const std::vector<int>& face : faces)
    six_volumes += polygon_normal(vertices, face).dot(vertices.col(face[0]) - origin);
  return six_volumes / 6.0;
}

/// Does a vertex lie deeper below the plane of a facet, beyond what plain doubles leave open?
bool surely_deeper(const Eigen::Ref<const Points>& vertices, const std::vector<int>& facet,
                   double depth) {
  const RoughArea area = rough_area(vertices, facet);
  const Vector3 base = vertices.col(facet[0]);
  for (int v = 0; v < vertices.cols(); ++v)
    if (area.surely_exceeds(base - vertices.col(v), depth)) return true;
  return false;
}

/// How far the vertices lie below the plane of a facet, at most; no farther is looked than
/// `enough`. `deep` is the vertex to try first, and then the one found.
double depth_below(const Eigen::Ref<const Points>& vertices, const std::vector<int>& facet,
                   double enough, int& deep) {
  const Vector3 normal = polygon_normal(vertices, facet);
  const Vector3 base = vertices.col(facet[0]);
  double longest = 0.0;
  for (const int v : facet) longest = std::max(longest, (vertices.col(v) - base).squaredNorm());
  constexpr double kNoNormal = 0x1p-80;  // nothing is left of it in double-double
  if (!(normal.norm() > kNoNormal * longest)) return enough;
  const Vector3 unit = normal.normalized();
  double depth = std::max(0.0, -unit.dot(vertices.col(deep) - base));
  for (int v = 0; v < vertices.cols() && depth < enough; ++v) {
    const double below = -unit.dot(vertices.col(v) - base);
    if (below <= depth) continue;
    depth = below;
    deep = v;
  }
  return depth;
}

void refuse_thin(double thickness, double limit) {
  if (thickness > limit) return;
  throw InputError("the points lie in one plane: thickness " + text(thickness) +
                   " m, must exceed " + text(limit) + " m");
}

/// Refuses flat solids. `facets`: of the exact hull. A convex body is never thinner than a third of
/// its least extent across a facet: lay the width upright, so that the body lies between two
/// concave graphs at most W apart over its shadow, and map the shadow so that its greatest ellipse
/// is the unit disk; then it lies in the disk of radius 2 [John 1948]. Over the middle the upper
/// graph falls at most W to the disk's border, so its facet there has a slope of at most W and
/// passes at most W + 2 W above any other point.
void check_thickness(const Eigen::Ref<const Points>& vertices, const Faces& facets, double limit,
                     int exponent) {
  double least = std::numeric_limits<double>::infinity();
  int deep = 0;
  for (const std::vector<int>& facet : facets) {
    const double enough = std::min(least, std::nextafter(limit, 2 * limit));
    if (surely_deeper(vertices, facet, enough)) continue;
    least = std::min(least, depth_below(vertices, facet, enough, deep));
  }
  refuse_thin(std::ldexp(least, -exponent), std::ldexp(limit, -exponent));
}

/// Which of its vertices is farthest off a face's mean plane, and which of all lies highest above
/// it, m.
struct Bulge {
  double off = 0.0, above = 0.0;
  int off_vertex = 0, above_vertex = 0;
};

Bulge bulge_of(const Eigen::Ref<const Points>& vertices, const std::vector<int>& face) {
  const Vector3 unit = polygon_normal(vertices, face).normalized(), base = vertices.col(face[0]);
  double level = 0.0;
  for (const int v : face) level += unit.dot(vertices.col(v) - base);
  level /= static_cast<double>(face.size());
  Bulge bulge;
  for (const int v : face) {
    const double off = std::abs(unit.dot(vertices.col(v) - base) - level);
    if (off <= bulge.off) continue;
    bulge.off = off;
    bulge.off_vertex = v;
  }
  for (int v = 0; v < vertices.cols(); ++v) {
    const double above = unit.dot(vertices.col(v) - base) - level;
    if (above <= bulge.above) continue;
    bulge.above = above;
    bulge.above_vertex = v;
  }
  return bulge;
}

/// What is wrong with a face, or "".
std::string complaint(int face, const Bulge& bulge, double limit) {
  const std::string name = "face " + std::to_string(face);
  if (bulge.off > limit) {
    return name + " is off its plane by " + text(bulge.off) + " m at vertex " +
           std::to_string(bulge.off_vertex) + ", limit " + text(limit) + " m";
  }
  if (bulge.above > limit) {
    return "not convex: vertex " + std::to_string(bulge.above_vertex) + " lies " +
           text(bulge.above) + " m outside " + name + ", limit " + text(limit) + " m";
  }
  return {};
}

/// How far places may be apart for the rounding of their coordinates, m.
double between_rounded(const ShapeOptions& options) {
  return 2.0 * std::sqrt(3.0) * options.coordinate_rounding;
}

/// How far a vertex may be off a face's plane for the rounding of coordinates, m: the plane leans
/// by that of its own vertices over its width, of which this takes no more than there is.
double rounded_limit(const Eigen::Ref<const Points>& vertices, const std::vector<int>& face,
                     const ShapeOptions& options) {
  if (options.coordinate_rounding == 0.0) return 0.0;
  double longest = 0.0;
  for (std::size_t k = 0; k < face.size(); ++k) {
    const Vector3 place = vertices.col(face[k]);
    longest = std::max({longest, (place - vertices.col(face[0])).norm(),
                        (place - vertices.col(face[(k + 1) % face.size()])).norm()});
  }
  const double width =
      polygon_normal(vertices, face).norm() / longest * (face.size() == 3 ? 1.0 : 0.5);
  return between_rounded(options) * (1.0 + diagonal(vertices) / width);
}

/// Tells `report` of faces that are not planar, or have a vertex above them, by more than kFlatness
/// of the diameter or what rounded coordinates leave open. True: nothing of that is more than the
/// label length either. Faces narrower than a length say nothing of it: all their vertices lie on
/// wider ones.
template <class Report>
bool check_convex(const Eigen::Ref<const Points>& vertices, const Faces& faces,
                  const ShapeOptions& options, const Report& report) {
  const double length = label_length(vertices);
  const double flat = std::max(kFlatness * diagonal(vertices), length);
  bool within = true;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (!is_wider(vertices, faces[f], length)) continue;
    const Bulge bulge = bulge_of(vertices, faces[f]);
    if (bulge.off <= length && bulge.above <= length) continue;
    within = false;
    const double limit = std::max(flat, rounded_limit(vertices, faces[f], options));
    const std::string fault = complaint(static_cast<int>(f), bulge, limit);
    if (!fault.empty() && is_wider(vertices, faces[f], limit)) report(fault);
  }
  return within;
}

void refuse(const std::string& fault) { throw InputError(fault); }

/// The exact hull of scaled points: its facets, and the points that are their corners.
struct ExactHull {
  Faces facets;
  std::vector<int> corners;  // facet vertex -> column, ascending
};

ExactHull exact_hull(const Eigen::Ref<const Points>& scaled) {
  HullTriangles hull = hull_triangles(scaled);
  if (hull.dimension < 3) {
    throw InputError(std::string("the points lie in one ") +
                     (hull.dimension < 2 ? "line" : "plane") + ": no solid");
  }
  ExactHull exact{{}, compress(static_cast<int>(scaled.cols()), hull.triangles)};
  const Points met = scaled(Eigen::all, exact.corners);
  exact.facets = exact_facets(met, hull.triangles);
  std::vector<int> kept = compress(static_cast<int>(met.cols()), exact.facets);
  for (int& v : kept) v = exact.corners[at(v)];
  exact.corners = std::move(kept);
  return exact;
}

/// Which of the faces given shares most corners with a facet, and of several turns as it does.
/// `shared`: zeros, one a face.
int face_below(const Eigen::Ref<const Points>& vertices, const std::vector<int>& facet,
               const IndexRows& faces_around, const std::vector<Vector3>& normals,
               std::vector<int>& shared) {
  for (const int v : facet)
    for (const int f : faces_around[v]) ++shared[at(f)];
  const Vector3 normal = polygon_normal(vertices, facet).normalized();
  std::pair<int, double> most{};
  int best = 0;
  for (const int v : facet) {
    for (const int f : faces_around[v]) {
      const std::pair likeness{std::exchange(shared[at(f)], 0), normal.dot(normals[at(f)])};
      if (likeness <= most) continue;
      most = likeness;
      best = f;
    }
  }
  return best;
}

/// The facets of a hull in the order of the faces that they stand for.
Faces in_order_of(const Faces& given, const Eigen::Ref<const Points>& vertices,
                  const Faces& facets) {
  const IndexRows around = rows_by(static_cast<int>(vertices.cols()), [&](const auto& put) {
    for (std::size_t f = 0; f < given.size(); ++f)
      for (const int v : given[f]) put(v, static_cast<int>(f));
  });
  std::vector<Vector3> normals;
  for (const auto& face : given) normals.push_back(polygon_normal(vertices, face).normalized());
  std::vector<int> shared(given.size(), 0), order(facets.size()), stands_for;
  for (const auto& facet : facets)
    stands_for.push_back(face_below(vertices, facet, around, normals, shared));
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](int k) { return stands_for[at(k)]; });
  Faces ordered;
  for (const int k : order) ordered.push_back(facets[at(k)]);
  return ordered;
}

Shape assemble(const Eigen::Ref<const Points>& vertices, const Faces& faces) {
  auto topology = std::make_shared<const Topology>(static_cast<int>(vertices.cols()), faces);
  return Shape(std::move(topology), vertices);
}

/// `scaled`: the same vertices as the cells were judged by; `surface`: closed, no vertex above it.
Shape labelled(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Points>& scaled,
               const Faces& surface) {
  const FaceLabels labels = label_faces(scaled, surface, label_length(scaled));
  auto topology = std::make_shared<const Topology>(static_cast<int>(vertices.cols()), labels.faces,
                                                   labels.hosted, surface);
  return Shape(std::move(topology), vertices);
}

}  // namespace

Shape make_box(const Vector3& min, const Vector3& max) {
  Points vertices(3, 8);
  for (int v = 0; v < 8; ++v)
    vertices.col(v) << (v & 1 ? max : min).x(), (v & 2 ? max : min).y(), (v & 4 ? max : min).z();
  for (int k = 0; k < 3; ++k) {
    if (!(min[k] < max[k])) {
      throw InputError("box: extent along axis " + std::to_string(k) + " is " +
                       text(max[k] - min[k]) + " m, must be positive");
    }
  }
  check_points(vertices, kMostVertices);
  refuse_thin((max - min).minCoeff(), label_length(vertices));
  return assemble(
      vertices,
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}});
}

namespace {

/// One that leaves the polygon's plane.
void check_sweep(const Eigen::Ref<const Points>& polygon, const Vector3& sweep) {
  Vector3 area = Vector3::Zero();
  for (Eigen::Index k = 2; k < polygon.cols(); ++k) {
    const Vector3 first = polygon.col(0);
    area += (polygon.col(k - 1) - first).cross(polygon.col(k) - first);
  }
  if (!(std::abs(area.dot(sweep)) <= kFlatShare * area.norm() * sweep.norm())) return;
  char text[128];
  std::snprintf(text, sizeof text, "prism: the sweep (%g %g %g) m lies in the polygon's plane",
                sweep[0], sweep[1], sweep[2]);
  throw InputError(text);
}

}  // namespace

Shape make_prism(const Eigen::Ref<const Points>& polygon, const Vector3& sweep) {
  const int n = static_cast<int>(polygon.cols());
  if (n < 3) {
    throw InputError("prism: the polygon has " + std::to_string(n) +
                     " vertices, at least 3 needed");
  }
  check_sweep(polygon, sweep);
  Points vertices(3, 2 * n);
  vertices.leftCols(n) = polygon;
  vertices.rightCols(n) = polygon.colwise() + sweep;
  Faces faces(2);
  for (int k = 0; k < n; ++k) {
    const int next = (k + 1) % n;
    faces[0].push_back(n - 1 - k);
    faces[1].push_back(n + k);
    faces.push_back({k, next, n + next, n + k});
  }
  return make_shape(vertices, faces);
}

double label_length(const Eigen::Ref<const Points>& points) {
  if (points.cols() == 0) throw InputError("label length: there are no points");
  const double size = diagonal(points);
  const double rounding =
      kRoundings * std::numeric_limits<double>::epsilon() * points.cwiseAbs().maxCoeff();
  return std::max(kFlatShare * size, std::min(rounding, kCoarsestShare * size));
}

Hull make_hull(const Eigen::Ref<const Points>& points) {
  check_points(points, kMostHullPoints);
  int exponent = 0;
  const Points all = scaled_points(points, exponent);
  std::vector<int> input_index = distinct(all);
  ExactHull hull = exact_hull(all(Eigen::all, input_index));
  for (int& v : hull.corners) v = input_index[at(v)];
  if (hull.corners.size() > at(kMostVertices)) {
    throw InputError("the hull has " + std::to_string(hull.corners.size()) + " vertices, at most " +
                     std::to_string(kMostVertices) + " allowed");
  }
  const Points scaled = all(Eigen::all, hull.corners);
  check_thickness(scaled, hull.facets, label_length(scaled), exponent);
  return {labelled(points(Eigen::all, hull.corners), scaled, hull.facets), hull.corners};
}

namespace {

void check_surface(const Eigen::Ref<const Points>& vertices, const Faces& faces) {
  const Topology closed(static_cast<int>(vertices.cols()), faces);
}

/// Refuses vertices that are no corners of the hull and lie deeper in it than rounding explains.
/// Lengths are of scaled points; `exponent`: their power of two.
void check_depths(const Eigen::Ref<const Points>& scaled, const ExactHull& hull,
                  const ShapeOptions& options, int exponent) {
  const double flat = std::max(kFlatness * diagonal(scaled), label_length(scaled));
  const double limit = std::max(flat, std::ldexp(between_rounded(options), exponent));
  std::vector<Vector3> normals;
  for (const auto& facet : hull.facets) {
    const auto corner = [&](std::size_t k) { return scaled.col(hull.corners[at(facet[k])]); };
    Points places(3, static_cast<Eigen::Index>(facet.size()));
    for (std::size_t k = 0; k < facet.size(); ++k)
      places.col(static_cast<Eigen::Index>(k)) = corner(k);
    std::vector<int> all(facet.size());
    std::iota(all.begin(), all.end(), 0);
    normals.push_back(polygon_normal(places, all).normalized());
  }
  for (int v = 0; v < scaled.cols(); ++v) {
    if (std::ranges::binary_search(hull.corners, v)) continue;
    double depth = std::numeric_limits<double>::infinity();
    for (std::size_t f = 0; f < normals.size(); ++f) {
      const Vector3 base = scaled.col(hull.corners[at(hull.facets[f][0])]);
      depth = std::min(depth, normals[f].dot(base - scaled.col(v)));
    }
    if (depth <= limit) continue;
    throw InputError("not convex: vertex " + std::to_string(v) + " lies " +
                     text(std::ldexp(depth, -exponent)) + " m inside the hull, limit " +
                     text(std::ldexp(limit, -exponent)) + " m");
  }
}

}  // namespace

Shape make_shape(const Eigen::Ref<const Points>& vertices, const Faces& faces,
                 const ShapeOptions& options) {
  require_length(options.coordinate_rounding, "shape: coordinate rounding");
  check_points(vertices, kMostVertices);
  check_equal_points(vertices);
  check_surface(vertices, faces);
  int exponent = 0;
  const Points scaled = scaled_points(vertices, exponent);
  ExactHull hull = exact_hull(scaled);
  check_thickness(scaled(Eigen::all, hull.corners), hull.facets, label_length(scaled), exponent);
  Faces outward = faces;
  if (volume(scaled, faces) < 0.0)
    for (std::vector<int>& face : outward) std::reverse(face.begin(), face.end());
  if (check_convex(vertices, outward, options, refuse)) return labelled(vertices, scaled, outward);
  if (options.coordinate_rounding > 0.0) check_depths(scaled, hull, options, exponent);
  for (std::vector<int>& facet : hull.facets)
    for (int& v : facet) v = hull.corners[at(v)];
  return labelled(vertices, scaled, in_order_of(outward, scaled, hull.facets));
}

std::vector<ShapeFault> shape_faults(const Eigen::Ref<const Points>& vertices, const Faces& faces,
                                     const ShapeOptions& options) {
  std::vector<ShapeFault> faults;
  const auto passes = [&](const auto& check) {
    try {
      check();
      return true;
    } catch (const InputError& error) {
      faults.push_back({error.what()});
      return false;
    }
  };
  const bool points = passes([&] { check_points(vertices, kMostVertices); });
  if (!points) return faults;
  const bool distinct = passes([&] { check_equal_points(vertices); });
  if (!passes([&] { check_surface(vertices, faces); })) return faults;
  Faces outward = faces;
  int exponent = 0;
  if (volume(scaled_points(vertices, exponent), faces) < 0.0) {
    faults.push_back({"inside out: the faces run clockwise as seen from outside", false});
    for (std::vector<int>& face : outward) std::reverse(face.begin(), face.end());
  }
  const std::size_t before = faults.size();
  check_convex(vertices, outward, options,
               [&](const std::string& fault) { faults.push_back({fault}); });
  // What is left: no thickness, vertices inside.
  if (distinct && faults.size() == before) passes([&] { make_shape(vertices, faces, options); });
  return faults;
}

}  // namespace quoin::geometry
