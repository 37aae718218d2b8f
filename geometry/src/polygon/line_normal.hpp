#pragma once
/// Closed forms of the simple pairs of features, to be built into the functions that use them.
/// `kFused`: with fused products, which give the same bits. Internal.

#include <algorithm>
#include <cmath>
#include <utility>

#include "numeric/double_double.hpp"
#include "numeric/vec3.hpp"
#include "shape/solid.hpp"

namespace quoin::geometry {

/// Below this share of the lengths that went in, a difference or a product has lost two bits: it is
/// then formed in double-double.
constexpr double kCancelled = 0.25;

/// What two vertices or edges came to.
struct LineNormal {
  Vec3 normal{1.0, 0.0, 0.0};  // unit, from P to Q
  bool found = false;
  bool joined = false;                  // the shortest line between the two lies within both
  bool crossed = false;                 // two edges that are joined and not parallel
  double share_p = 0.0, share_q = 0.0;  // of the way along either, where they cross
  double from_ends = kInfinity;         // square of how far the feet on edges are from ends, m2
  double skew = 0.0, longer = 0.0;      // of two edges: squares of their product, of the longer one

  /// How far the shorter of two crossed edges reaches across the other, m: rounding by it is what
  /// may turn their normal.
  double reach_across() const { return std::sqrt(skew / longer); }
};

inline WideVector wide_difference(const Vec3& p, const Vec3& q) {
  return {two_difference(p.x, q.x), two_difference(p.y, q.y), two_difference(p.z, q.z)};
}

/// One side of P or Q: from one vertex to another. Its line is right to the last places however
/// short it is, its ends are places.
struct Side {
  Vec3 from, to, line;
  const Solid* owner = nullptr;
  int first = 0, second = 0;
  Side() = default;
  explicit Side(const Vec3& vertex) : from(vertex), to(vertex), line(0.0, 0.0, 0.0) {}
  Side(const Solid& solid, int v, int w)
      : from(place(solid, v)),
        to(place(solid, w)),
        line(solid.body() == nullptr ? to - from : Vec3(solid.line(v, w))),
        owner(&solid),
        first(v),
        second(w) {}
  WideVector wide() const { return owner->wide_line(first, second); }
};

// What is seldom asked for is not built in, and takes copies, so that the rest stays in registers.
Vec3 wide_cross(Side e, Side f);
inline Vec3 accurate_cross(const Side& e, const Side& f) {
  const Vec3 &a = e.line, &b = f.line;
  const Vec3 normal = cross(a, b);
  if (square(normal) > kCancelled * kCancelled * square(a) * square(b)) return normal;
  return wide_cross(e, f);
}

/// True when sin(angle) × shorter length <= tolerance; squares of the product of two edges and of
/// the longer one.
inline bool parallel(double squared_product, double longer, double tolerance) {
  return squared_product <= tolerance * tolerance * longer;
}
inline bool parallel(const Side& e, const Side& f, double tolerance) {
  const Vec3 &a = e.line, &b = f.line;
  return parallel(square(cross(a, b)), greater(square(a), square(b)), tolerance);
}

/// w less its part along e, right to the last places of the result however short that is.
template <bool kFused>
Vec3 across(const WideVector& w, const WideVector& e, double share) {
  const auto rest = [share](const DoubleDouble& x, const DoubleDouble& y) {
    const DoubleDouble product = two_product<kFused>(share, y.high);
    const DoubleDouble high = two_difference(x.high, product.high);
    return high.high + (high.low + (x.low - product.low - share * y.low));
  };
  const Vec3 v(rest(w.x, e.x), rest(w.y, e.y), rest(w.z, e.z));
  const Vec3 line(e.x.high, e.y.high, e.z.high);
  return v - (dot(v, line) / square(line)) * line;
}

inline LineNormal face_line(const Vec3& normal) { return {.normal = normal, .found = true}; }

/// From Q to P.
inline LineNormal reversed(LineNormal form) {
  form.normal = -form.normal;
  std::swap(form.share_p, form.share_q);
  return form;
}

/// Across a line from P to Q.
inline LineNormal line_normal(const Vec3& line, bool joined) {
  LineNormal form;
  const double length = std::sqrt(square(line));
  form.found = length > 0.0;
  if (form.found) form.normal = line / length;
  form.joined = joined;
  return form;
}

/// How far `share` of a way of this squared length is from its ends, squared; nothing beyond them.
inline double squared_from_ends(double share, double squared_length) {
  const double least = greater(0.0, lesser(share, 1.0 - share));
  return least * least * squared_length;
}

/// Vertex against edge, from the one to the other.
template <bool kFused>
LineNormal vertex_edge(const Vec3& vertex, const Side& edge) {
  const Vec3 w = edge.from - vertex, line = edge.line;
  const double squared = square(line), share = -dot(w, line) / squared;
  LineNormal form;
  if (!(share >= 0.0 && share <= 1.0)) {
    form = line_normal((share > 1.0 ? edge.to : edge.from) - vertex, true);
  } else if (const Vec3 direct = w + share * line;
             square(direct) > kCancelled * kCancelled * square(w)) {
    form = line_normal(direct, true);
  } else {
    form =
        line_normal(across<kFused>(wide_difference(edge.from, vertex), edge.wide(), -share), true);
  }
  form.from_ends = squared_from_ends(share, squared);
  return form;
}

/// Is `share` of a way of this squared length between its ends, within `rounding`? It is then moved
/// there.
inline bool between_ends(double& share, double squared_length, double rounding) {
  if (share >= 0.0 && share <= 1.0) return true;
  const double end = share < 0.0 ? 0.0 : 1.0, beyond = share - end;
  share = end;
  return beyond * beyond * squared_length <= rounding * rounding;
}

/// Two edges; on which side of P the normal of crossed ones looks is left open.
template <bool kFused>
LineNormal edge_edge(const Side& e, const Side& f, double rounding) {
  const Vec3 &a = e.line, &b = f.line;
  const Vec3 w = f.from - e.from;
  const double squared_a = square(a), squared_b = square(b);
  const double longer = greater(squared_a, squared_b);
  const Vec3 normal = accurate_cross(e, f);
  const double squared = square(normal);
  if (!parallel(squared, longer, rounding)) {
    LineNormal form = line_normal(normal, true);
    form.share_p = dot(cross(w, b), normal) / squared;
    form.share_q = dot(cross(w, a), normal) / squared;
    form.joined = between_ends(form.share_p, squared_a, rounding) &&
                  between_ends(form.share_q, squared_b, rounding);
    form.crossed = form.joined;
    // Of an end from the other edge: at a small angle rounding moves the crossing by more.
    form.from_ends = lesser(squared_from_ends(form.share_p, squared / squared_b),
                            squared_from_ends(form.share_q, squared / squared_a));
    form.skew = square(cross(a, b));
    form.longer = longer;
    return form;
  }
  // Parallel: across the longer one, from whichever vertex; they join where their spans overlap.
  const bool along_p = squared_a >= squared_b;
  const Vec3 line = along_p ? a : b;
  const double share = dot(w, line) / longer;
  const double first = along_p ? share : -share;  // of the shorter edge's ends, along the longer
  const double second = first + dot(along_p ? b : a, line) / longer;
  const double low = greater(0.0, lesser(first, second)),
               high = lesser(1.0, greater(first, second));
  LineNormal form = line_normal(
      across<kFused>(wide_difference(f.from, e.from), along_p ? e.wide() : f.wide(), share),
      (low - high) * std::sqrt(longer) <= rounding);
  // Of spans that meet end against end within rounding the vertices may be nearest as well.
  form.from_ends = greater(0.0, high - low) * greater(0.0, high - low) * longer;
  return form;
}

/// Does the place of a point, seen along the outward normal of a face, lie inside its border by
/// more than `margin`, or outside by less than -margin? m
inline bool over_face(const Solid& polyhedron, int face, const Vec3& outward, const Vec3& point,
                      double margin) {
  const double clear =
      greater(0.0, margin * polyhedron.diameter());  // of no side less than `margin`
  const std::span<const int> cycle = polyhedron.topology().face(face);
  Vec3 from = place(polyhedron, cycle.back());
  for (const int v : cycle) {
    const Vec3 to = place(polyhedron, v), side = to - from;
    const double inside = dot(outward, cross(side, point - from));
    from = to;
    if (inside > clear) continue;
    const double least = margin * std::abs(margin) * square(side);
    if (!(inside * std::abs(inside) > least)) return false;
  }
  return true;
}

/// The middle of what an edge shares with a face, seen along the face's outward normal; false where
/// it does not lie inside the face's border by `margin`, m.
inline bool middle_on_face(const Solid& polyhedron, int face, const Vec3& outward, const Side& edge,
                           double margin, Vec3& middle) {
  double first = 0.0, last = 1.0;  // shares of the edge
  const std::span<const int> cycle = polyhedron.topology().face(face);
  Vec3 from = place(polyhedron, cycle.back());
  for (const int v : cycle) {
    const Vec3 to = place(polyhedron, v), side = to - from;
    const double inside = dot(outward, cross(side, edge.from - from));
    const double rise = dot(outward, cross(side, edge.line));
    from = to;
    if (rise > 0.0) first = greater(first, -inside / rise);
    if (rise < 0.0) last = lesser(last, -inside / rise);
  }
  middle = edge.from + 0.5 * (first + last) * edge.line;
  return first < last && over_face(polyhedron, face, outward, middle, margin);
}

}  // namespace quoin::geometry
