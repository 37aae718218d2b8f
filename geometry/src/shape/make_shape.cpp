#include <quoin/geometry/build.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

#include "shape/convex_hull.hpp"

namespace quoin::geometry {
namespace {

using Faces = std::vector<std::vector<int>>;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

/// Coplanarity of labels: what rounding and ordinary data leave, m.
double label_tolerance(const Eigen::Ref<const Points>& points) {
  const Vector3 size = points.rowwise().maxCoeff() - points.rowwise().minCoeff();
  return std::max(1e-9 * size.norm(),
                  16 * std::numeric_limits<double>::epsilon() * points.cwiseAbs().maxCoeff());
}

void check_equal_points(const Eigen::Ref<const Points>& points) {
  std::vector<int> order(static_cast<std::size_t>(points.cols()));
  std::iota(order.begin(), order.end(), 0);
  const auto less = [&](int i, int j) {
    for (int k = 0; k < 3; ++k) {
      if (points(k, i) != points(k, j)) return points(k, i) < points(k, j);
    }
    return i < j;
  };
  std::sort(order.begin(), order.end(), less);
  for (std::size_t k = 1; k < order.size(); ++k) {
    if (points.col(order[k - 1]) == points.col(order[k])) {
      throw InputError("points " + std::to_string(order[k - 1]) + " and " +
                       std::to_string(order[k]) + " are equal");
    }
  }
}

void check_points(const Eigen::Ref<const Points>& points, int limit) {
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
  check_equal_points(points);
}

/// Area-weighted normal of a polygon, m2 (twice the area).
Vector3 polygon_normal(const Eigen::Ref<const Points>& points, const std::vector<int>& face) {
  Vector3 normal = Vector3::Zero();
  const Vector3 first = points.col(face[0]);
  for (std::size_t k = 2; k < face.size(); ++k) {
    const Vector3 p = points.col(face[k - 1]), q = points.col(face[k]);
    normal += (p - first).cross(q - first);
  }
  return normal;
}

/// Labels coplanar neighbours as one polygon. Grows from the largest cell, against whose plane
/// every vertex is measured, so that tolerance does not add up around a nearly round solid.
class CoplanarMerge {
 public:
  CoplanarMerge(const Eigen::Ref<const Points>& points, const Faces& cells, double tolerance)
      : points_(points),
        cells_(cells),
        topology_(static_cast<int>(points.cols()), cells),
        tolerance_(tolerance),
        frozen_(cells.size(), 0) {}

  /// `drop_flat`: vertices that are exactly no corner vanish; otherwise every vertex stays.
  Faces run(bool drop_flat) {
    while (true) {
      grow_groups();
      if (freeze_bad_loops()) continue;
      if (drop_flat) {
        find_dropped();
      } else {
        dropped_.assign(static_cast<std::size_t>(points_.cols()), 0);
      }
      if (!freeze_lost_vertices()) break;
    }
    return polygons();
  }

 private:
  int neighbour(int cell, std::size_t k) const {
    const std::array<int, 2>& pair = topology_.edge_faces(topology_.face_edges(cell)[k]);
    return pair[0] == cell ? pair[1] : pair[0];
  }

  void grow_groups() {
    std::vector<double> areas;
    for (const std::vector<int>& cell : cells_)
      areas.push_back(polygon_normal(points_, cell).norm());
    std::vector<int> order(cells_.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](int i, int j) { return areas[at(i)] > areas[at(j)]; });
    group_.assign(cells_.size(), -1);
    for (const int seed : order) {
      if (group_[at(seed)] >= 0) continue;
      group_[at(seed)] = seed;
      if (!frozen_[at(seed)] && areas[at(seed)] > 0.0) grow(seed, areas[at(seed)]);
    }
  }

  void grow(int seed, double area) {
    const Vector3 normal = polygon_normal(points_, cells_[at(seed)]) / area;
    const Vector3 base = points_.col(cells_[at(seed)][0]);
    std::vector<int> stack{seed};
    while (!stack.empty()) {
      const int cell = stack.back();
      stack.pop_back();
      for (std::size_t k = 0; k < cells_[at(cell)].size(); ++k) {
        const int next = neighbour(cell, k);
        if (group_[at(next)] >= 0 || frozen_[at(next)]) continue;
        const bool flat = std::all_of(cells_[at(next)].begin(), cells_[at(next)].end(), [&](int v) {
          return std::abs(normal.dot(points_.col(v) - base)) <= tolerance_;
        });
        if (!flat) continue;
        group_[at(next)] = seed;
        stack.push_back(next);
      }
    }
  }

  bool on_border(int cell, std::size_t k) const {
    return group_[at(neighbour(cell, k))] != group_[at(cell)];
  }

  /// Next vertex along the border of a group, by vertex; -2 where the border touches itself.
  std::vector<std::array<int, 2>> border(int group) const {
    std::vector<std::array<int, 2>> sides;
    for (int cell = 0; cell < static_cast<int>(cells_.size()); ++cell) {
      if (group_[at(cell)] != group) continue;
      const std::vector<int>& cycle = cells_[at(cell)];
      for (std::size_t k = 0; k < cycle.size(); ++k) {
        if (on_border(cell, k)) sides.push_back({cycle[k], cycle[(k + 1) % cycle.size()]});
      }
    }
    std::sort(sides.begin(), sides.end());
    return sides;
  }

  std::vector<int> loop(int group) const {
    const std::vector<std::array<int, 2>> sides = border(group);
    std::vector<int> cycle;
    if (sides.size() < 3) return cycle;
    int v = sides[0][0];
    do {
      cycle.push_back(v);
      const auto side = std::lower_bound(sides.begin(), sides.end(), std::array<int, 2>{v, -1});
      if (side == sides.end() || (*side)[0] != v) return {};
      v = (*side)[1];
    } while (v != sides[0][0] && cycle.size() <= sides.size());
    if (cycle.size() != sides.size()) cycle.clear();  // holes, or a border that touches itself
    return cycle;
  }

  std::vector<int> groups() const {
    std::vector<int> names(group_);
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    return names;
  }

  bool freeze_bad_loops() {
    loops_.clear();
    bool any = false;
    for (const int group : groups()) {
      loops_.push_back(loop(group));
      if (!loops_.back().empty()) continue;
      any = true;
      for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
        if (group_[cell] == group) frozen_[cell] = 1;
      }
    }
    return any;
  }

  /// Exactly no corner: the middle of an edge of the solid, or inside one of its faces.
  void find_dropped() {
    dropped_.assign(static_cast<std::size_t>(points_.cols()), 0);
    std::vector<std::vector<int>> beside(static_cast<std::size_t>(points_.cols()));
    for (const std::vector<int>& cycle : loops_) {
      for (std::size_t k = 0; k < cycle.size(); ++k) {
        beside[at(cycle[k])].push_back(cycle[(k + 1) % cycle.size()]);
      }
    }
    for (int v = 0; v < points_.cols(); ++v) {
      if (topology_.vertex_faces(v).empty()) continue;
      const std::vector<int>& next = beside[at(v)];
      if (next.empty()) dropped_[at(v)] = flat_inside(v);
      if (next.size() == 2) {
        dropped_[at(v)] = collinear(points_.col(v), points_.col(next[0]), points_.col(next[1]));
      }
    }
  }

  bool flat_inside(int v) const {
    const std::span<const int> around = topology_.neighbours(v);
    const std::vector<int>& cell = cells_[at(topology_.vertex_faces(v)[0])];
    return std::all_of(around.begin(), around.end(), [&](int w) {
      return orientation(points_.col(cell[0]), points_.col(cell[1]), points_.col(cell[2]),
                         points_.col(w)) == 0;
    });
  }

  /// A corner that no polygon would name any more keeps the cells around it.
  bool freeze_lost_vertices() {
    std::vector<int> uses(static_cast<std::size_t>(points_.cols()), 0);
    for (const std::vector<int>& cycle : loops_) {
      for (const int v : cycle) ++uses[at(v)];
    }
    bool any = false;
    for (int v = 0; v < points_.cols(); ++v) {
      if (uses[at(v)] >= 2 || dropped_[at(v)]) continue;
      for (const int cell : topology_.vertex_faces(v)) {
        any = any || !frozen_[at(cell)];
        frozen_[at(cell)] = 1;
      }
    }
    return any;
  }

  Faces polygons() const {
    Faces faces;
    for (const std::vector<int>& cycle : loops_) {
      std::vector<int> face;
      for (const int v : cycle) {
        if (!dropped_[at(v)]) face.push_back(v);
      }
      if (face.size() >= 3) faces.push_back(face);
    }
    return faces;
  }

  Eigen::Ref<const Points> points_;
  const Faces& cells_;
  Topology topology_;
  double tolerance_;
  std::vector<char> frozen_, dropped_;
  std::vector<int> group_;
  Faces loops_;
};

/// Renumbers the vertices that the faces use, ascending; returns their old numbers.
std::vector<int> compress(Faces& faces) {
  std::vector<int> used;
  for (const std::vector<int>& face : faces) used.insert(used.end(), face.begin(), face.end());
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  for (std::vector<int>& face : faces) {
    for (int& v : face) {
      v = static_cast<int>(std::lower_bound(used.begin(), used.end(), v) - used.begin());
    }
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

/// Thickness: the least over the faces of how far the vertices lie below it, m.
double thickness(const Eigen::Ref<const Points>& vertices, const Faces& faces) {
  double least = std::numeric_limits<double>::infinity();
  for (const std::vector<int>& face : faces) {
    const Vector3 normal = polygon_normal(vertices, face);
    if (!(normal.norm() > 0.0)) continue;
    const Vector3 unit = normal.normalized(), base = vertices.col(face[0]);
    double depth = 0.0;
    for (int v = 0; v < vertices.cols(); ++v) {
      depth = std::max(depth, -unit.dot(vertices.col(v) - base));
    }
    least = std::min(least, depth);
  }
  return least;
}

void check_thickness(double value, double tolerance) {
  const double limit = std::max(tolerance, kSmallestExtent);
  if (value > limit) return;
  throw InputError("the points lie in one plane: thickness " + text(value) + " m, must exceed " +
                   text(limit) + " m");
}

void check_used(int vertex_count, const Faces& faces) {
  std::vector<char> used(at(vertex_count), 0);
  for (const std::vector<int>& face : faces) {
    for (const int v : face) used[at(v)] = 1;
  }
  const auto unused = std::find(used.begin(), used.end(), 0);
  if (unused != used.end()) {
    throw InputError("vertex " + std::to_string(unused - used.begin()) + " belongs to no face");
  }
}

/// Every face planar and every vertex on or below it, within kFlatness of the diameter.
void check_convex(const Eigen::Ref<const Points>& vertices, const Faces& faces, double limit) {
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const Vector3 normal = polygon_normal(vertices, faces[f]);
    const std::string name = "face " + std::to_string(f);
    if (!(normal.norm() > 0.0)) continue;  // a sliver that rounding closed: nothing to hold against
    const Vector3 unit = normal.normalized();
    double level = 0.0;
    for (const int v : faces[f]) level += unit.dot(vertices.col(v) - vertices.col(faces[f][0]));
    level /= static_cast<double>(faces[f].size());
    const Vector3 base = vertices.col(faces[f][0]);
    for (const int v : faces[f]) {
      const double off = std::abs(unit.dot(vertices.col(v) - base) - level);
      if (off > limit) {
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

Polyhedron assemble(const Eigen::Ref<const Points>& vertices, const Faces& faces) {
  auto topology = std::make_shared<const Topology>(static_cast<int>(vertices.cols()), faces);
  return Polyhedron(std::move(topology), vertices);
}

}  // namespace

Polyhedron make_box(const Vector3& min, const Vector3& max) {
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

Polyhedron make_prism(const Eigen::Ref<const Points>& polygon, const Vector3& sweep) {
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
  return make_polyhedron(vertices, faces);
}

Hull make_hull(const Eigen::Ref<const Points>& points) {
  check_points(points, kMostHullPoints);
  const HullTriangles hull = hull_triangles(points);
  if (hull.dimension < 3) {
    throw InputError(std::string("the points lie in one ") +
                     (hull.dimension < 2 ? "line" : "plane") + ": no solid");
  }
  Faces cells;
  for (const std::array<int, 3>& t : hull.triangles) cells.push_back({t[0], t[1], t[2]});
  const double tolerance = label_tolerance(points);
  const std::vector<int> corners = compress(cells);
  if (corners.size() > at(kMostVertices)) {
    throw InputError("the hull has " + std::to_string(corners.size()) + " vertices, at most " +
                     std::to_string(kMostVertices) + " allowed");
  }
  const Points kept = points(Eigen::all, corners);
  check_thickness(thickness(kept, cells), tolerance);
  Faces faces = CoplanarMerge(kept, cells, tolerance).run(true);
  const std::vector<int> used = compress(faces);
  std::vector<int> input_index;
  for (const int v : used) input_index.push_back(corners[at(v)]);
  return {assemble(kept(Eigen::all, used), faces), input_index};
}

Polyhedron make_polyhedron(const Eigen::Ref<const Points>& vertices, const Faces& faces) {
  check_points(vertices, kMostVertices);
  const int count = static_cast<int>(vertices.cols());
  { const Topology closed(count, faces); }
  check_used(count, faces);
  Faces outward = faces;
  if (volume(vertices, faces) < 0.0) {
    for (std::vector<int>& face : outward) std::reverse(face.begin(), face.end());
  }
  const double tolerance = label_tolerance(vertices);
  const Vector3 size = vertices.rowwise().maxCoeff() - vertices.rowwise().minCoeff();
  check_convex(vertices, outward, std::max(kFlatness * size.norm(), tolerance));
  check_thickness(thickness(vertices, outward), tolerance);
  return assemble(vertices, CoplanarMerge(vertices, outward, tolerance).run(false));
}

}  // namespace quoin::geometry
