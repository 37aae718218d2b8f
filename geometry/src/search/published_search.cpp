#include <quoin/geometry/published_search.hpp>

#include <algorithm>
#include <cmath>

#include "numeric/floating_point.hpp"
#include "shape/support.hpp"

namespace quoin::geometry {
namespace {

std::array<int, 2> nearest_vertices(const Solid& a, const Solid& b) {
  std::array<int, 2> best{0, 0};
  double least = kInfinity;
  for (int i = 0; i < a.vertex_count(); ++i) {
    const Vector3 x = a.vertex(i);
    for (int j = 0; j < b.vertex_count(); ++j) {
      const double distance = (b.vertex(j) - x).squaredNorm();
      if (distance >= least) continue;
      least = distance;
      best = {i, j};
    }
  }
  return best;
}

/// The nearest point of a face; `inside`: it is the foot on the face's plane.
struct OnFace {
  Vector3 point;
  bool inside = true;
};

OnFace nearest_on_face(const Solid& solid, int face, const Vector3& x) {
  const std::span<const int> cycle = solid.topology().face(face);
  const Vector3 normal = solid.face_normal(face);
  const Vector3 foot = x - normal * normal.dot(x - solid.vertex(cycle[0]));
  OnFace best{foot};
  double least = kInfinity;
  for (std::size_t k = 0; k < cycle.size(); ++k) {
    const Vector3 a = solid.vertex(cycle[k]);
    const Vector3 side = solid.vertex(cycle[(k + 1) % cycle.size()]) - a;
    if (normal.dot(side.cross(foot - a)) >= 0.0) continue;
    best.inside = false;
    const double along = std::clamp(side.dot(foot - a) / side.squaredNorm(), 0.0, 1.0);
    const Vector3 on_side = a + along * side;
    if ((on_side - foot).squaredNorm() >= least) continue;
    least = (on_side - foot).squaredNorm();
    best.point = on_side;
  }
  return best;
}

Vector3 nearest_around(const Solid& solid, int vertex, const Vector3& x) {
  Vector3 best = solid.vertex(vertex);
  for (const int f : solid.topology().vertex_faces(vertex)) {
    const Vector3 point = nearest_on_face(solid, f, x).point;
    if ((point - x).squaredNorm() < (best - x).squaredNorm()) best = point;
  }
  return best;
}

/// A point of the solid whose vertices are tried, one of the other's face, and how far they are
/// apart; `normal`: from the first to the second, or into the face.
struct FoundPair {
  Vector3 point, on_face, normal;
  double gap = kInfinity;
};

/// One solid's vertices against the other's faces.
class OneSided {
 public:
  OneSided(const Solid& own, int own_vertex, const Solid& other, double still, int max_cycles)
      : own_(own), own_vertex_(own_vertex), other_(other), still_(still), max_cycles_(max_cycles) {}

  FoundPair search(int other_vertex, PublishedAnswer& answer) const {
    VertexSet vertices;
    for (const int f : own_.topology().vertex_faces(own_vertex_)) {
      for (const int v : own_.topology().face(f))
        if (!vertices.contains(v)) vertices.push_back(v);
    }
    FoundPair best;
    for (const int f : other_.topology().vertex_faces(other_vertex)) {
      for (const int v : vertices) {
        const FoundPair found = from_vertex(own_.vertex(v), f, answer);
        if (std::abs(found.gap) < std::abs(best.gap)) best = found;
      }
    }
    return best;
  }

 private:
  FoundPair from_vertex(const Vector3& vertex, int face, PublishedAnswer& answer) const {
    const Vector3 inward = -other_.face_normal(face);
    const OnFace first = nearest_on_face(other_, face, vertex);
    if (first.inside) return {vertex, first.point, inward, inward.dot(first.point - vertex)};
    Vector3 p = vertex, p1 = first.point;
    for (int cycle = 1; cycle <= max_cycles_; ++cycle) {
      answer.cycles = std::max(answer.cycles, cycle);
      const Vector3 p2 = nearest_around(own_, own_vertex_, p1);
      if ((p2 - p).norm() <= still_) return pair(p, p1, inward);
      const Vector3 p3 = nearest_on_face(other_, face, p2).point;
      if ((p3 - p1).norm() <= still_) return pair(p2, p3, inward);
      p = p2;
      p1 = p3;
    }
    answer.stands_still = false;
    return pair(p, p1, inward);
  }

  static FoundPair pair(const Vector3& point, const Vector3& on_face, const Vector3& inward) {
    const double gap = (on_face - point).norm();
    return {point, on_face, gap > 0.0 ? Vector3((on_face - point) / gap) : inward, gap};
  }

  const Solid& own_;
  int own_vertex_;
  const Solid& other_;
  double still_;
  int max_cycles_;
};

/// How far a solid reaches beyond a point along a direction, m.
double residual(const Solid& solid, const Vector3& point, const Vector3& direction) {
  const Vector3 top = solid.vertex(support(solid, direction).vertex);
  return std::max(0.0, direction.dot(top - point));
}

}  // namespace

PublishedAnswer published_search(const Body& body_a, const Body& body_b,
                                 const PublishedOptions& options) {
  const PlacedPair pair(body_a, body_b);
  const Solid &a = pair.a, &b = pair.b;
  const double still =
      options.still > 0.0 ? options.still : 1e-12 * std::min(a.diameter(), b.diameter());
  PublishedAnswer answer;
  const auto [r, q] = nearest_vertices(a, b);
  answer.vertex_a = r;
  answer.vertex_b = q;
  const FoundPair from_a =
      OneSided(a, answer.vertex_a, b, still, options.max_cycles).search(answer.vertex_b, answer);
  const FoundPair from_b =
      OneSided(b, answer.vertex_b, a, still, options.max_cycles).search(answer.vertex_a, answer);
  const bool a_first = std::abs(from_a.gap) <= std::abs(from_b.gap);
  answer.gap = a_first ? from_a.gap : from_b.gap;
  answer.normal = a_first ? from_a.normal : -from_b.normal;
  answer.point_a = a_first ? from_a.point : from_b.on_face;
  answer.point_b = a_first ? from_a.on_face : from_b.point;
  answer.residual_a = residual(a, answer.point_a, answer.normal);
  answer.residual_b = residual(b, answer.point_b, -answer.normal);
  answer.point_a += pair.middle;
  answer.point_b += pair.middle;
  return answer;
}

}  // namespace quoin::geometry
