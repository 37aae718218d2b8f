#pragma once
/// Closed forms of the simple pairs of features, to be built into the functions that use them.
/// `kFused`: with fused products, which give the same bits. Private to the room.

#include <cmath>

#include "closed_form.hpp"
#include "double_double.hpp"

namespace quoin::geometry {

/// Below this share of the lengths that went in, a difference or a product has lost two bits: it is
/// then formed in double-double.
constexpr double kCancelled = 0.25;

inline WideVector side(const Polyhedron& polyhedron, int from, int to) {
  return wide_difference(polyhedron.vertex(to), polyhedron.vertex(from));
}

inline Vector3 rounded_side(const Polyhedron& polyhedron, int from, int to) {
  return polyhedron.vertex(to) - polyhedron.vertex(from);
}

/// One side of P or Q: from one vertex to another.
struct Side {
  const Polyhedron& owner;
  int from, to;
  Vector3 rounded() const { return rounded_side(owner, from, to); }
  WideVector wide() const { return side(owner, from, to); }
};

inline Vector3 accurate_cross(const Side& e, const Side& f) {
  const Vector3 a = e.rounded(), b = f.rounded();
  const Vector3 normal = a.cross(b);
  if (normal.squaredNorm() > kCancelled * kCancelled * a.squaredNorm() * b.squaredNorm()) {
    return normal;
  }
  return cross(e.wide(), f.wide()).rounded();
}

/// w less its part along e, right to the last places of the result however short that is.
template <bool kFused>
Vector3 across(const WideVector& w, const WideVector& e, double share) {
  const auto rest = [share](const DoubleDouble& x, const DoubleDouble& y) {
    const DoubleDouble product = two_product<kFused>(share, y.high);
    const DoubleDouble high = two_difference(x.high, product.high);
    return high.high + (high.low + (x.low - product.low - share * y.low));
  };
  Vector3 v(rest(w.x, e.x), rest(w.y, e.y), rest(w.z, e.z));
  const Vector3 line(e.x.high, e.y.high, e.z.high);
  return v - line * (v.dot(line) / line.squaredNorm());
}

/// Across a line from P to Q.
inline ClosedForm line_form(const Vector3& line, bool joined) {
  ClosedForm form;
  const double length = line.norm();
  form.found = length > 0.0;
  if (form.found) form.normal = line / length;
  form.joined = joined;
  return form;
}

/// Vertex against edge; `sign`: +1 when the vertex is of P, -1 when it is of Q.
template <bool kFused>
ClosedForm vertex_edge(const Vector3& vertex, const Polyhedron& owner,
                       const std::array<int, 2>& edge, double sign) {
  const Vector3 w = owner.vertex(edge[0]) - vertex, line = rounded_side(owner, edge[0], edge[1]);
  const double share = -w.dot(line) / line.squaredNorm();
  const double inside = std::clamp(share, 0.0, 1.0);
  if (inside != share) {
    const int end = inside == 0.0 ? edge[0] : edge[1];
    return line_form(sign * (owner.vertex(end) - vertex), true);
  }
  const Vector3 direct = w + share * line;
  if (direct.squaredNorm() > kCancelled * kCancelled * w.squaredNorm()) {
    return line_form(sign * direct, true);
  }
  const WideVector wide_w = wide_difference(owner.vertex(edge[0]), vertex);
  return line_form(sign * across<kFused>(wide_w, side(owner, edge[0], edge[1]), -share), true);
}

/// Two edges; on which side of P the normal of crossed ones looks is left open.
template <bool kFused>
ClosedForm edge_edge(const Polyhedron& p, const std::array<int, 2>& edge_p, const Polyhedron& q,
                     const std::array<int, 2>& edge_q, double rounding) {
  const Side e{p, edge_p[0], edge_p[1]}, f{q, edge_q[0], edge_q[1]};
  const Vector3 a = e.rounded(), b = f.rounded();
  const Vector3 normal = accurate_cross(e, f);
  const double longer = std::max(a.norm(), b.norm());
  const Vector3 w = q.vertex(edge_q[0]) - p.vertex(edge_p[0]);
  if (normal.norm() > rounding * longer) {
    const double squared = normal.squaredNorm();
    const double s = w.cross(b).dot(normal) / squared, t = w.cross(a).dot(normal) / squared;
    const double slack_s = rounding / a.norm(), slack_t = rounding / b.norm();
    const bool joined = s >= -slack_s && s <= 1.0 + slack_s && t >= -slack_t && t <= 1.0 + slack_t;
    ClosedForm form = line_form(normal, joined);
    form.crossed = joined;
    form.share = std::clamp(s, 0.0, 1.0);
    return form;
  }
  // Parallel: across the longer one, from whichever vertex; they join where their spans overlap.
  const bool along_p = a.squaredNorm() >= b.squaredNorm();
  const WideVector wide_w = wide_difference(q.vertex(edge_q[0]), p.vertex(edge_p[0]));
  const Vector3 line = along_p ? a : b;
  const double share = w.dot(line) / line.squaredNorm();
  const double first =
      along_p ? share : -share;  // of the shorter edge's ends, along the longer one
  const double second = first + (along_p ? b : a).dot(line) / line.squaredNorm();
  const double slack = rounding / line.norm();
  const bool joined = std::max(first, second) >= -slack && std::min(first, second) <= 1.0 + slack;
  return line_form(across<kFused>(wide_w, along_p ? e.wide() : f.wide(), share), joined);
}

/// Does the place of a point, seen along the outward normal of a face, lie within the face?
inline bool over_face(const Polyhedron& polyhedron, int face, const Vector3& outward,
                      const Vector3& point, double rounding) {
  const std::span<const int> cycle = polyhedron.topology().face(face);
  for (std::size_t k = 0; k < cycle.size(); ++k) {
    const Vector3 a = polyhedron.vertex(cycle[k]);
    const Vector3 side = polyhedron.vertex(cycle[k + 1 == cycle.size() ? 0 : k + 1]) - a;
    const double inside = outward.dot(side.cross(point - a));
    if (inside < 0.0 && inside * inside > rounding * rounding * side.squaredNorm()) return false;
  }
  return true;
}

}  // namespace quoin::geometry
