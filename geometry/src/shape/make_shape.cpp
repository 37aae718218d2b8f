#include <quoin/geometry/build.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

#include "shape/convex_hull.hpp"
#include "shape/face_labels.hpp"
#include "shape/polygon_area.hpp"
#include "shape/rounding_mode.hpp"

namespace quoin::geometry {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

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
    for (int k = 0; k < 3; ++k) {
      if (points(k, i) != points(k, j)) return points(k, i) < points(k, j);
    }
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
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (k == 0 || points.col(order[k - 1]) != points.col(order[k])) kept.push_back(order[k]);
  }
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
    if (!points.col(i).allFinite()) {
      throw InputError("point " + std::to_string(i) + " has a coordinate that is not finite");
    }
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
  for (const auto& polygon : polygons) {
    for (const int v : polygon) name[at(v)] = 0;
  }
  for (int v = 0; v < count; ++v) {
    if (name[at(v)] < 0) continue;
    name[at(v)] = static_cast<int>(used.size());
    used.push_back(v);
  }
  for (auto& polygon : polygons) {
    for (int& v : polygon) v = name[at(v)];
  }
  return used;
}

double volume(const Eigen::Ref<const Points>& vertices, const Faces& faces) {
  const Vector3 origin = vertices.col(0);
  double six_volumes = 0.0;
  for (const std::vector<int>& face : faces) {
    six_volumes += polygon_normal(vertices, face).dot(vertices.col(face[0]) - origin);
  }
  return six_volumes / 6.0;
}

/// Does a vertex lie deeper below the plane of a facet, beyond what plain doubles leave open?
bool surely_deeper(const Eigen::Ref<const Points>& vertices, const std::vector<int>& facet,
                   double depth) {
  const RoughArea area = rough_area(vertices, facet);
  const Vector3 base = vertices.col(facet[0]);
  for (int v = 0; v < vertices.cols(); ++v) {
    if (area.surely_exceeds(base - vertices.col(v), depth)) return true;
  }
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
  if (least > limit) return;
  throw InputError("the points lie in one plane: thickness " + text(std::ldexp(least, -exponent)) +
                   " m, must exceed " + text(std::ldexp(limit, -exponent)) + " m");
}

/// Every face planar and every vertex on or below it, within kFlatness of the diameter. Faces
/// narrower than that say nothing: all their vertices lie on wider ones.
void check_convex(const Eigen::Ref<const Points>& vertices, const Faces& faces, double limit) {
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (!is_wider(vertices, faces[f], limit)) continue;
    const Vector3 unit = polygon_normal(vertices, faces[f]).normalized();
    const std::string name = "face " + std::to_string(f);
    double level = 0.0;
    for (const int v : faces[f]) level += unit.dot(vertices.col(v) - vertices.col(faces[f][0]));
    level /= static_cast<double>(faces[f].size());
    const Vector3 base = vertices.col(faces[f][0]);
    for (const int v : faces[f]) {
      const double off = std::abs(unit.dot(vertices.col(v) - base) - level);
      if (!(off <= limit)) {
        throw InputError(name + " is off its plane by " + text(off) + " m at vertex " +
                         std::to_string(v) + ", limit " + text(limit) + " m");
      }
    }
    for (int v = 0; v < vertices.cols(); ++v) {
      const double beyond = unit.dot(vertices.col(v) - base) - level;
      if (beyond > limit) {
        throw InputError("not convex: vertex " + std::to_string(v) + " lies " + text(beyond) +
                         " m outside " + name + ", limit " + text(limit) + " m");
      }
    }
  }
}

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

Shape assemble(const Eigen::Ref<const Points>& vertices, const Faces& faces) {
  auto topology = std::make_shared<const Topology>(static_cast<int>(vertices.cols()), faces);
  return Shape(std::move(topology), vertices);
}

/// `scaled`: the same vertices as the cells were judged by; `surface`: closed, through all of them.
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
  for (int v = 0; v < 8; ++v) {
    vertices.col(v) << (v & 1 ? max : min).x(), (v & 2 ? max : min).y(), (v & 4 ? max : min).z();
  }
  for (int k = 0; k < 3; ++k) {
    if (!(min[k] < max[k])) {
      throw InputError("box: extent along axis " + std::to_string(k) + " is " +
                       text(max[k] - min[k]) + " m, must be positive");
    }
  }
  check_points(vertices, kMostVertices);
  return assemble(
      vertices,
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}});
}

Shape make_prism(const Eigen::Ref<const Points>& polygon, const Vector3& sweep) {
  const int n = static_cast<int>(polygon.cols());
  if (n < 3) {
    throw InputError("prism: the polygon has " + std::to_string(n) +
                     " vertices, at least 3 needed");
  }
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

Shape make_shape(const Eigen::Ref<const Points>& vertices, const Faces& faces) {
  check_points(vertices, kMostVertices);
  check_equal_points(vertices);
  { const Topology closed(static_cast<int>(vertices.cols()), faces); }
  int exponent = 0;
  const Points scaled = scaled_points(vertices, exponent);
  const ExactHull hull = exact_hull(scaled);
  check_thickness(scaled(Eigen::all, hull.corners), hull.facets, label_length(scaled), exponent);
  Faces outward = faces;
  if (volume(scaled, faces) < 0.0) {
    for (std::vector<int>& face : outward) std::reverse(face.begin(), face.end());
  }
  check_convex(vertices, outward, std::max(kFlatness * diagonal(vertices), label_length(vertices)));
  return labelled(vertices, scaled, outward);
}

}  // namespace quoin::geometry
