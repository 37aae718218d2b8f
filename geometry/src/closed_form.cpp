#include "closed_form.hpp"

#include <cmath>

#include "double_double.hpp"

namespace quoin::geometry {
namespace {

/// Below this share of the lengths that went in, a difference or a product has lost two bits: it is
/// then formed in double-double.
constexpr double kCancelled = 0.25;

WideVector side(const Polyhedron& polyhedron, int from, int to) {
  return wide_difference(polyhedron.vertex(to), polyhedron.vertex(from));
}

Vector3 rounded_side(const Polyhedron& polyhedron, int from, int to) {
  return polyhedron.vertex(to) - polyhedron.vertex(from);
}

/// One side of P or Q: from one vertex to another.
struct Side {
  const Polyhedron& owner;
  int from, to;
  Vector3 rounded() const { return rounded_side(owner, from, to); }
  WideVector wide() const { return side(owner, from, to); }
};

Vector3 accurate_cross(const Side& e, const Side& f) {
  const Vector3 a = e.rounded(), b = f.rounded();
  const Vector3 normal = a.cross(b);
  if (normal.squaredNorm() > kCancelled * kCancelled * a.squaredNorm() * b.squaredNorm()) {
    return normal;
  }
  return cross(e.wide(), f.wide()).rounded();
}

/// w less its part along e, right to the last places of the result however short that is.
Vector3 across(const WideVector& w, const WideVector& e, double share) {
  const auto rest = [share](const DoubleDouble& x, const DoubleDouble& y) {
    const DoubleDouble product = two_product(share, y.high);
    const DoubleDouble high = two_difference(x.high, product.high);
    return high.high + (high.low + (x.low - product.low - share * y.low));
  };
  Vector3 v(rest(w.x, e.x), rest(w.y, e.y), rest(w.z, e.z));
  const Vector3 line(e.x.high, e.y.high, e.z.high);
  return v - line * (v.dot(line) / line.squaredNorm());
}

ClosedForm from_line(const Vector3& line, bool joined) {
  ClosedForm form;
  const double length = line.norm();
  form.found = length > 0.0;
  if (form.found) form.normal = line / length;
  form.joined = joined;
  return form;
}

/// Vertex against edge: w from the vertex to the first end of the edge (or back, by `sign`).
ClosedForm vertex_edge(const Vector3& vertex, const Polyhedron& owner, const VertexSet& edge,
                       double sign) {
  const Vector3 w = owner.vertex(edge[0]) - vertex, line = rounded_side(owner, edge[0], edge[1]);
  const double share = -w.dot(line) / line.squaredNorm();
  const double inside = std::clamp(share, 0.0, 1.0);
  if (inside != share) {
    const int end = inside == 0.0 ? edge[0] : edge[1];
    return from_line(sign * (owner.vertex(end) - vertex), true);
  }
  const Vector3 direct = w + share * line;
  if (direct.squaredNorm() > kCancelled * kCancelled * w.squaredNorm()) {
    return from_line(sign * direct, true);
  }
  const WideVector wide_w = wide_difference(owner.vertex(edge[0]), vertex);
  return from_line(sign * across(wide_w, side(owner, edge[0], edge[1]), -share), true);
}

ClosedForm edge_edge(const Polyhedron& p, const Polyhedron& q, const ContactSets& sets,
                     double rounding) {
  const Side e{p, sets.p[0], sets.p[1]}, f{q, sets.q[0], sets.q[1]};
  const Vector3 a = e.rounded(), b = f.rounded();
  const Vector3 normal = accurate_cross(e, f);
  const double longer = std::max(a.norm(), b.norm());
  const Vector3 w = q.vertex(sets.q[0]) - p.vertex(sets.p[0]);
  if (normal.norm() > rounding * longer) {
    const double squared = normal.squaredNorm();
    const double s = w.cross(b).dot(normal) / squared, t = w.cross(a).dot(normal) / squared;
    const double slack_s = rounding / a.norm(), slack_t = rounding / b.norm();
    const bool joined = s >= -slack_s && s <= 1.0 + slack_s && t >= -slack_t && t <= 1.0 + slack_t;
    ClosedForm form = from_line(normal, joined);
    form.crossed = joined;
    form.share = std::clamp(s, 0.0, 1.0);
    return form;
  }
  // Parallel: across the longer one, from whichever vertex; they join where their spans overlap.
  const bool along_p = a.squaredNorm() >= b.squaredNorm();
  const WideVector wide_w = wide_difference(q.vertex(sets.q[0]), p.vertex(sets.p[0]));
  const Vector3 line = along_p ? a : b;
  const double share = w.dot(line) / line.squaredNorm();
  const double first =
      along_p ? share : -share;  // of the shorter edge's ends, along the longer one
  const double second = first + (along_p ? b : a).dot(line) / line.squaredNorm();
  const double slack = rounding / line.norm();
  const bool joined = std::max(first, second) >= -slack && std::min(first, second) <= 1.0 + slack;
  return from_line(across(wide_w, along_p ? e.wide() : f.wide(), share), joined);
}

/// Normal of three vertices, on the side of `guess`.
Vector3 triangle_normal(const Polyhedron& owner, const VertexSet& set) {
  return accurate_cross(Side{owner, set[0], set[1]}, Side{owner, set[0], set[2]}).normalized();
}

}  // namespace

bool over_face(const Polyhedron& polyhedron, int face, const Vector3& outward, const Vector3& point,
               double rounding) {
  const std::span<const int> cycle = polyhedron.topology().face(face);
  for (std::size_t k = 0; k < cycle.size(); ++k) {
    const Vector3 a = polyhedron.vertex(cycle[k]);
    const Vector3 side = polyhedron.vertex(cycle[k + 1 == cycle.size() ? 0 : k + 1]) - a;
    const double inside = outward.dot(side.cross(point - a));
    if (inside < 0.0 && inside * inside > rounding * rounding * side.squaredNorm()) return false;
  }
  return true;
}

int covered_face(const Polyhedron& polyhedron, const VertexSet& set, const Vector3& outward) {
  const Topology& topology = polyhedron.topology();
  if (set.size() < 3) return -1;
  int best = -1;
  double greatest = 0.5;
  for (const int v : set) {  // a face that is covered may miss at most the vertices of the others
    for (const int f : topology.vertex_faces(v)) {
      const double facing = polyhedron.face_normal(f).dot(outward);
      if (facing <= greatest) continue;
      const std::span<const int> cycle = topology.face(f);
      if (cycle.size() > set.size()) continue;
      if (!std::all_of(cycle.begin(), cycle.end(), [&](int w) { return set.contains(w); }))
        continue;
      if (cycle.size() == set.size()) return f;
      greatest = facing;
      best = f;
    }
  }
  return best;
}

ClosedForm closed_form(const Polyhedron& p, const Polyhedron& q, const ContactSets& sets,
                       const Vector3& guess, double rounding) {
  ClosedForm form;
  const std::size_t count_p = sets.p.size(), count_q = sets.q.size();
  if (sets.face_p >= 0 || sets.face_q >= 0) {
    // Two faces: the larger one's plane is the better known.
    const bool by_p = sets.face_q < 0 || (sets.face_p >= 0 && p.diameter() >= q.diameter());
    form.normal = by_p ? p.face_normal(sets.face_p) : Vector3(-q.face_normal(sets.face_q));
    form.found = true;
  } else if (count_p == 1 && count_q == 1) {
    form = from_line(q.vertex(sets.q[0]) - p.vertex(sets.p[0]), true);
  } else if (count_p == 1 && count_q == 2) {
    form = vertex_edge(p.vertex(sets.p[0]), q, sets.q, 1.0);
  } else if (count_p == 2 && count_q == 1) {
    form = vertex_edge(q.vertex(sets.q[0]), p, sets.p, -1.0);
  } else if (count_p == 2 && count_q == 2) {
    form = edge_edge(p, q, sets, rounding);
  } else if (count_p == 3 && count_q <= 2) {
    form.normal = triangle_normal(p, sets.p);
    form.found = form.normal.allFinite();
  } else if (count_q == 3 && count_p <= 2) {
    form.normal = triangle_normal(q, sets.q);
    form.found = form.normal.allFinite();
  }
  if (form.normal.dot(guess) < 0.0) form.normal = -form.normal;
  return form;
}

}  // namespace quoin::geometry
