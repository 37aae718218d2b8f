#include <quoin/geometry/split.hpp>

#include <algorithm>
#include <numeric>
#include <quoin/geometry/build.hpp>
#include <utility>

#include "numeric/floating_point.hpp"
#include "numeric/numbers.hpp"
#include "shape/rows.hpp"

namespace quoin::geometry {
namespace {

using Edge = std::array<int, 2>;
using Polygon = std::vector<int>;

/// One side's polygons, by the numbers of all places: vertices, then cuts.
struct Half {
  std::vector<Polygon> polygons;
  std::vector<int> old_faces;
  std::vector<Edge> border;  // of the polygons, along the plane, reversed
  double outward = 1.0;      // times the plane's normal: that of the face in the plane
};

class Cut {
 public:
  /// Vertices within `rounding` (m) of the plane lie on it.
  Cut(const Shape& shape, const Plane& plane, double rounding)
      : shape_(shape), normal_(plane.normal.stableNormalized()) {
    heights_ = normal_.transpose() * (shape.vertices().colwise() - plane.point);
    for (double& height : heights_) height = std::abs(height) <= rounding ? 0.0 : height;
  }

  bool crosses() const { return heights_.maxCoeff() > 0.0 && heights_.minCoeff() < 0.0; }
  bool is_more_above() const { return heights_.maxCoeff() > -heights_.minCoeff(); }

  /// Both parts; false: one of them makes no solid.
  bool run(Split& parts) {
    find_cuts();
    Half above, below;
    above.outward = -1.0;
    const Topology& topology = shape_.topology();
    if (topology.all_are_corners())
      for (int f = 0; f < topology.face_count(); ++f) add(topology.face(f), f, above, below);
    else  // hosted vertices lie on the surface, not on the labels
      for (const auto& cell : topology.triangles()) add(cell, common_face(cell), above, below);
    return close(below, parts.below) && close(above, parts.above);
  }

 private:
  int side(int v) const { return (heights_[v] > 0.0) - (heights_[v] < 0.0); }
  bool on_plane(int v) const { return v >= shape_.vertex_count() || side(v) == 0; }

  void find_cuts() {
    const Topology& topology = shape_.topology();
    if (topology.all_are_corners()) {
      for (int e = 0; e < topology.edge_count(); ++e) note(topology.edge(e));
    } else {
      for (const auto& cell : topology.triangles())
        for (std::size_t k = 0; k < 3; ++k) note({cell[k], cell[(k + 1) % 3]});
    }
    std::sort(cut_edges_.begin(), cut_edges_.end());
    cut_edges_.erase(std::unique(cut_edges_.begin(), cut_edges_.end()), cut_edges_.end());
    places_.resize(3, shape_.vertex_count() + static_cast<int>(cut_edges_.size()));
    places_.leftCols(shape_.vertex_count()) = shape_.vertices();
    int next = shape_.vertex_count();
    for (const auto& [high, low] : cut_edges_) {
      const double share = heights_[high] / (heights_[high] - heights_[low]);
      places_.col(next++) =
          shape_.vertex(high) + share * (shape_.vertex(low) - shape_.vertex(high));
    }
  }
  /// From the higher end to the lower one: the same for all solids that have this edge.
  void note(Edge edge) {
    if (side(edge[0]) * side(edge[1]) >= 0) return;
    if (side(edge[0]) < 0) std::swap(edge[0], edge[1]);
    cut_edges_.push_back(edge);
  }
  int cut_of(int v, int w) const {
    const Edge edge = side(v) > 0 ? Edge{v, w} : Edge{w, v};
    const auto found = std::lower_bound(cut_edges_.begin(), cut_edges_.end(), edge);
    return shape_.vertex_count() + static_cast<int>(found - cut_edges_.begin());
  }

  /// The label in which all three vertices of a cell of the surface lie.
  int common_face(const std::array<int, 3>& cell) const {
    const Topology& topology = shape_.topology();
    for (const int f : topology.vertex_faces(cell[0])) {
      const auto lies_in = [&](int v) {
        return std::ranges::binary_search(topology.vertex_faces(v), f);
      };
      if (lies_in(cell[1]) && lies_in(cell[2])) return f;
    }
    return topology.vertex_faces(cell[0])[0];
  }

  void add(std::span<const int> cell, int old_face, Half& above, Half& below) const {
    Polygon high, low;
    for (std::size_t k = 0; k < cell.size(); ++k) {
      const int v = cell[k], w = cell[k + 1 < cell.size() ? k + 1 : 0];
      if (side(v) >= 0) high.push_back(v);
      if (side(v) <= 0) low.push_back(v);
      if (side(v) * side(w) >= 0) continue;
      const int cut = cut_of(v, w);
      high.push_back(cut);
      low.push_back(cut);
    }
    keep(std::move(high), old_face, above);
    keep(std::move(low), old_face, below);
  }
  void keep(Polygon polygon, int old_face, Half& half) const {
    if (std::ranges::all_of(polygon, [&](int v) { return on_plane(v); })) return;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const int v = polygon[k], w = polygon[k + 1 < polygon.size() ? k + 1 : 0];
      if (on_plane(v) && on_plane(w)) half.border.push_back({w, v});
    }
    half.polygons.push_back(std::move(polygon));
    half.old_faces.push_back(old_face);
  }

  /// Adds the face in the plane: the one cycle of the border's edges.
  static bool close_border(Half& half) {
    std::sort(half.border.begin(), half.border.end());
    Polygon face;
    int v = half.border.empty() ? -1 : half.border[0][0];
    while (face.size() < half.border.size()) {
      const auto next = std::ranges::lower_bound(half.border, Edge{v, 0});
      if (next == half.border.end() || (*next)[0] != v) return false;
      face.push_back(v);
      v = (*next)[1];
      if (v == face[0]) break;
    }
    if (face.size() < 3 || face.size() != half.border.size()) return false;
    half.polygons.push_back(std::move(face));
    half.old_faces.push_back(-1);
    return true;
  }

  bool close(Half& half, std::optional<SplitPart>& part) const {
    if (!close_border(half)) return false;
    std::vector<int> name(at(static_cast<int>(places_.cols())), -1), used;
    for (Polygon& polygon : half.polygons) {
      for (int& v : polygon) {
        if (name[at(v)] < 0) {
          name[at(v)] = static_cast<int>(used.size());
          used.push_back(v);
        }
        v = name[at(v)];
      }
    }
    try {
      part = {make_shape(places_(Eigen::all, used), half.polygons), {}};
    } catch (const InputError&) {  // too thin, or places that rounding has put on each other
      return false;
    }
    part->old_faces = old_faces(part->shape, half);
    return true;
  }

  /// Of the polygons that have three vertices in a face, or two, the one that turns as it does.
  std::vector<int> old_faces(const Shape& part, const Half& half) const {
    const Topology& topology = part.topology();
    const int polygons = static_cast<int>(half.polygons.size());
    const IndexRows around = rows_by(topology.vertex_count(), [&](const auto& put) {
      for (int p = 0; p < polygons; ++p)
        for (const int v : half.polygons[at(p)]) put(v, p);
    });
    std::vector<int> shared(at(polygons), 0), old;
    for (int f = 0; f < topology.face_count(); ++f) {
      const auto visit = [&](const auto& work) {
        for (const int v : topology.face_set(f))
          for (const int p : around[v]) work(p);
      };
      visit([&](int p) { ++shared[at(p)]; });
      std::pair<int, double> most{};
      int best = 0;
      visit([&](int p) {
        const int count = std::exchange(shared[at(p)], 0);
        if (count == 0) return;
        const std::pair likeness{std::min(count, 3), part.face_normal(f).dot(normal(p, half))};
        if (likeness <= most) return;
        most = likeness;
        best = p;
      });
      old.push_back(half.old_faces[at(best)]);
    }
    return old;
  }
  Vector3 normal(int polygon, const Half& half) const {
    const int old = half.old_faces[at(polygon)];
    return old < 0 ? half.outward * normal_ : shape_.face_normal(old);
  }

  const Shape& shape_;
  Vector3 normal_;
  Eigen::RowVectorXd heights_;  // of the vertices above the plane, m; 0: on it
  std::vector<Edge> cut_edges_;
  Points places_;
};

SplitPart whole(const Shape& shape) {
  SplitPart part{shape, std::vector<int>(at(shape.topology().face_count()))};
  std::iota(part.old_faces.begin(), part.old_faces.end(), 0);
  return part;
}

}  // namespace

Split split(const Shape& shape, const Plane& plane) {
  if (!plane.point.allFinite() || !plane.normal.allFinite() || plane.normal.isZero(0.0))
    throw InputError("split: the plane is not finite, or its normal is zero");
  const double size = shape.largest_coordinate() + plane.point.cwiseAbs().maxCoeff();
  const double rounding = kRoundings * kEpsilon * size;
  Split parts;
  // Where rounding puts places on each other, vertices as near as labels know lie on the plane.
  for (const double near : {rounding, std::max(rounding, label_length(shape.vertices()))}) {
    Cut cut(shape, plane, near);
    if (cut.crosses() && cut.run(parts)) return parts;
    parts = {};
    (cut.is_more_above() ? parts.above : parts.below) = whole(shape);
    if (!cut.crosses()) break;
  }
  return parts;
}

}  // namespace quoin::geometry
