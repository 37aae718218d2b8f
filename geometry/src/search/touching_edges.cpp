#include "search/touching_edges.hpp"

#include <algorithm>
#include <cmath>

#include "numeric/error_bounds.hpp"
#include "polygon/cross2.hpp"
#include "search/touching_faces.hpp"

namespace quoin::geometry {
namespace {

/// The edge between two faces; -1: they have none.
struct Rim {
  int edge = -1;
  std::array<int, 2> ends{};
  Vector3 from, line;  // m

  /// How far the faces reach away from it, m.
  double depth(const Solid& solid) const {
    const auto [v, w] = ends;
    double least = kInfinity;
    for (const int end : {v, w}) {
      for (const int other : solid.topology().neighbours(end)) {
        if (other == v || other == w) continue;
        least = std::min(least, line.cross(solid.line(end, other)).squaredNorm());
      }
    }
    return std::sqrt(least / line.squaredNorm());
  }
};
Rim rim_between(const Solid& solid, int f, int g) {
  const Topology& topology = solid.topology();
  Rim rim;
  for (const int e : topology.face_edges(f)) {
    const auto [left, right] = topology.edge_faces(e);
    if (left == g || right == g) rim.edge = e;
  }
  if (rim.edge < 0) return rim;
  rim.ends = topology.edge(rim.edge);
  const auto [v, w] = rim.ends;
  rim.from = solid.vertex(v);
  rim.line = solid.line(v, w);
  return rim;
}

/// Two faces of each solid, the edges between them, and P's normals.
struct Rims {
  int face_p, face_q, side_p, side_q;
  Rim p, q;
  Vector3 normal, second;
};

/// False: the solids do not come near each other in such a place.
bool find_rims(const Solid& p, const Solid& q, const Vector3& across, Rims& rims) {
  const PairSupport near = support_pair(p, q, across);
  rims.face_p = facing_face(p, near.p.vertex, across);
  rims.face_q = facing_face(q, near.q.vertex, -across);
  if (rims.face_p < 0 || rims.face_q < 0) return false;
  const PartingFace beside = parting_face(p, q, p.topology().face_neighbours(rims.face_p));
  const double size = std::min(p.diameter(), q.diameter());
  if (beside.face < 0 || !(std::abs(beside.gap) <= kTouchingTilt * size)) return false;
  rims.side_p = beside.face;
  rims.side_q = parting_face(q, p, q.topology().face_neighbours(rims.face_q)).face;
  if (rims.side_q < 0) return false;
  rims.p = rim_between(p, rims.face_p, rims.side_p);
  rims.q = rim_between(q, rims.face_q, rims.side_q);
  rims.normal = p.face_normal(rims.face_p);
  rims.second = p.face_normal(rims.side_p);
  return rims.p.edge >= 0 && rims.q.edge >= 0;
}

/// Where the stretch that both edges have in common ends: at a vertex of P or of Q.
struct End {
  Vector2 between;  // from P's edge to Q's, across P's, m
  bool of_p = false;
  int vertex = 0;
};

/// As seen along P's edge: in axes across it, the first of which is the normal of P's face.
struct Stretch {
  Vector3 axis_u, axis_v;
  End first, last;
  double length = 0.0;  // m

  explicit Stretch(const Rims& rims) : axis_u(rims.normal) {
    const Vector3 &edge_p = rims.p.line, &edge_q = rims.q.line;
    const Vector3 way = rims.q.from - rims.p.from;
    const double squared = edge_p.squaredNorm(), size = std::sqrt(squared);
    axis_v = edge_p.cross(axis_u) / size;
    const double start = edge_p.dot(way) / squared, step = edge_p.dot(edge_q) / squared;
    const std::size_t ahead = step > 0.0 ? 1 : 0;  // Q's end that lies farther along P's edge
    const double low = std::min(start, start + step), high = std::max(start, start + step);
    const auto end = [&](double share, bool of_p, int vertex) -> End {
      const Vector3 to_q = way + (share - start) / step * edge_q - share * edge_p;
      return {seen_along(to_q), of_p, vertex};
    };
    first = low < 0.0 ? end(0.0, true, rims.p.ends[0]) : end(low, false, rims.q.ends[1 - ahead]);
    last = high > 1.0 ? end(1.0, true, rims.p.ends[1]) : end(high, false, rims.q.ends[ahead]);
    length = (std::min(high, 1.0) - std::max(low, 0.0)) * size;
  }
  Vector2 seen_along(const Vector3& x) const { return {axis_u.dot(x), axis_v.dot(x)}; }
};

/// A direction across the edges, the gap along it, and what then carries the plane.
struct Direction {
  enum By { kFaces, kSides, kEdges, kEnd };
  Vector2 unit;
  double gap;  // m
  By by;
  End end;  // where the solids are nearest
};

/// Among them is the best direction of all.
class Directions {
 public:
  Directions(const Stretch& stretch, const Vector2& second) : stretch_(stretch), second_(second) {
    const Vector2 &first = stretch.first.between, &last = stretch.last.between;
    add(Vector2::UnitX(), Direction::kFaces);
    add(second, Direction::kSides);
    const Vector2 change = last - first;
    add_between({-change.y(), change.x()}, Direction::kEdges);
    add_between({change.y(), -change.x()}, Direction::kEdges);
    add_between(first, Direction::kEnd);
    add_between(last, Direction::kEnd);
  }
  const Direction& best() const {
    return *std::max_element(list_.begin(), list_.begin() + count_,
                             [](const Direction& x, const Direction& y) { return x.gap < y.gap; });
  }
  /// Does the best one beat all others, and they touching solids, by more than `clear`? m
  bool is_alone(const Direction& best, double clear) const {
    const double most = std::min(best.gap, 0.0) - clear;
    return std::all_of(list_.begin(), list_.begin() + count_, [&](const Direction& other) {
      return &other == &best || other.gap <= most;
    });
  }

 private:
  void add(const Vector2& unit, Direction::By by) {
    const double first = unit.dot(stretch_.first.between), last = unit.dot(stretch_.last.between);
    list_[count_++] = {unit, std::min(first, last), by,
                       first <= last ? stretch_.first : stretch_.last};
  }
  /// If it lies between the normals of P's faces.
  void add_between(const Vector2& direction, Direction::By by) {
    const double length = direction.norm(), turn = second_.y() > 0.0 ? 1.0 : -1.0;
    if (length > 0.0 && turn * direction.y() > 0.0 && turn * cross2(direction, second_) > 0.0) {
      add(direction / length, by);
    }
  }

  const Stretch& stretch_;
  Vector2 second_;
  std::array<Direction, 6> list_;
  std::ptrdiff_t count_ = 0;
};

/// The features that carry the plane of a direction.
ContactSets carriers_of(const Solid& p, const Solid& q, const Rims& rims,
                        const Direction& direction) {
  Feature by_p{FeatureKind::Edge, rims.p.edge}, by_q{FeatureKind::Edge, rims.q.edge};
  if (direction.by == Direction::kFaces || direction.by == Direction::kSides) {
    const bool faces = direction.by == Direction::kFaces;
    by_p = {FeatureKind::Face, faces ? rims.face_p : rims.side_p};
    by_q = {FeatureKind::Face, faces ? rims.face_q : rims.side_q};
  }
  if (direction.by != Direction::kEdges) {
    (direction.end.of_p ? by_p : by_q) = {FeatureKind::Vertex, direction.end.vertex};
  }
  ContactSets sets;
  take_feature(p, by_p, sets.p, sets.face_p);
  take_feature(q, by_q, sets.q, sets.face_q);
  return sets;
}

}  // namespace

bool touching_edges(const Solid& p, const Solid& q, const Lengths& length, const Vector3& across,
                    Optimum& optimum) {
  Rims rims;
  if (!find_rims(p, q, across, rims)) return false;
  const Stretch stretch(rims);
  const double farthest = std::max(stretch.first.between.norm(), stretch.last.between.norm());
  if (!(farthest <= kTouchingTilt * std::min(stretch.length, rims.p.depth(p)))) return false;
  ++optimum.iterations;
  const Directions directions(stretch, stretch.seen_along(rims.second));
  const Direction& best = directions.best();
  if (!clearly_apart(best.gap, length.rounding) &&
      !directions.is_alone(best, kTouchingAlone * length.rounding)) {
    return false;
  }
  const Vector3 normal = best.unit.x() * stretch.axis_u + best.unit.y() * stretch.axis_v;
  return settle(p, q, length, carriers_of(p, q, rims, best), normal, optimum.plane) &&
         optimum.plane.gap >= best.gap - length.rounding &&
         lies_over(p, q, optimum.plane, nullptr, -length.rounding) &&
         take_settled(p, q, length, optimum);
}

}  // namespace quoin::geometry
