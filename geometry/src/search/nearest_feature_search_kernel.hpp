#pragma once
/// nearest_feature_search, as a kernel. See kernels/kernels.hpp. Internal.

#include "search/nearest_feature_search.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "numeric/error_bounds.hpp"
#include "search/simplex_reduction.hpp"
#include "shape/scan.hpp"

namespace quoin::geometry {
namespace {

constexpr int kMostSteps = 64;

/// One point q_j - p_i of the Minkowski difference; relative error of each coordinate: half an eps.
struct Corner {
  Vector3 w;
  int p = 0, q = 0;
};

/// Up to four corners, newest first, and the search direction: from the origin to their hull.
struct Simplex {
  std::array<Corner, 4> corners;
  int size = 0;
  Vector3 direction;  // along the nearest point, any length
  double squared_distance = 0.0;

  void push_front(const Corner& corner) {
    for (int k = size; k > 0; --k)
      corners[static_cast<std::size_t>(k)] = corners[static_cast<std::size_t>(k - 1)];
    corners[0] = corner;
    ++size;
  }
  const Vector3& w(int k) const { return corners[static_cast<std::size_t>(k)].w; }
};

/// The point of a face of the simplex that is nearest to the origin. Only faces with the newest
/// corner (number 0) count: it lies nearer than all that the others span, so it carries the point.
struct Nearest {
  int count = 1;  // corners that carry it: the newest and up to two others
  int first = 0, second = 0;
  Vector3 direction = Vector3::Zero();
  double squared = kInfinity;
};

Nearest at_newest(const Vector3& a) { return {1, 0, 0, a, a.squaredNorm()}; }

/// `along`: -ab·a, known to be positive.
Nearest on_side(const Vector3& a, const Vector3& ab, double along, int b) {
  const double length = ab.squaredNorm();
  if (!(along < length)) return {2, b, b, a + ab, (a + ab).squaredNorm()};
  const Vector3 v = a + ab * (along / length);
  return {2, b, b, v, v.squaredNorm()};
}

Nearest on_segment(const Simplex& simplex, int b) {
  const Vector3& a = simplex.w(0);
  const Vector3 ab = simplex.w(b) - a;
  const double along = -ab.dot(a);
  return along > 0.0 ? on_side(a, ab, along, b) : at_newest(a);
}

/// Source: [Ericson 2005], section 5.1.5, for the point at the origin, the regions beside a.
/// `normal`: (b - a) x (c - a).
Nearest on_triangle(const Simplex& simplex, int b, int c, const Vector3& normal) {
  const Vector3& a = simplex.w(0);
  const Vector3 ab = simplex.w(b) - a, ac = simplex.w(c) - a;
  const double along_b = -ab.dot(a), along_c = -ac.dot(a);
  if (along_b <= 0.0 && along_c <= 0.0) return at_newest(a);
  const bool beyond_b = along_b > 0.0 && ab.cross(normal).dot(a) <= 0.0;
  const bool beyond_c = along_c > 0.0 && normal.cross(ac).dot(a) <= 0.0;
  if (beyond_b || beyond_c) {
    const Nearest on_b = beyond_b ? on_side(a, ab, along_b, b) : Nearest{};
    const Nearest on_c = beyond_c ? on_side(a, ac, along_c, c) : Nearest{};
    return on_b.squared <= on_c.squared ? on_b : on_c;
  }
  const double height = normal.dot(a);
  return {3, b, c, height < 0.0 ? Vector3(-normal) : normal,
          height * height / normal.squaredNorm()};
}

void take(const Nearest& nearest, Simplex& simplex) {
  simplex.direction = nearest.direction;
  simplex.squared_distance = nearest.squared;
  const auto first = static_cast<std::size_t>(nearest.first);
  const auto second = static_cast<std::size_t>(nearest.second);
  if (nearest.count > 1 && first != 1) simplex.corners[1] = simplex.corners[first];
  if (nearest.count > 2 && second != 2) simplex.corners[2] = simplex.corners[second];
  simplex.size = nearest.count;
}

/// Of the three sides of the tetrahedron beside the newest corner those that have the origin on
/// their outer side; none: it is inside.
bool reduce_tetrahedron(Simplex& simplex) {
  const Vector3& a = simplex.w(0);
  const Vector3 ab = simplex.w(1) - a, ac = simplex.w(2) - a, ad = simplex.w(3) - a;
  const Vector3 abc = ab.cross(ac), acd = ac.cross(ad), abd = ab.cross(ad);
  const double volume = abc.dot(ad);
  Nearest best;
  const auto consider = [&](const Vector3& normal, int b, int c, double sign) {
    const double height = sign * normal.dot(a);  // of the volume's sign: the origin is outside
    if (volume != 0.0 && height != 0.0 && (height > 0.0) != (volume > 0.0)) return;
    const Nearest candidate = on_triangle(simplex, b, c, normal);
    if (candidate.squared < best.squared) best = candidate;
  };
  consider(abc, 1, 2, 1.0);
  consider(acd, 2, 3, 1.0);
  consider(abd, 1, 3, -1.0);
  if (!(best.squared < kInfinity)) return false;
  take(best, simplex);
  return true;
}

/// Shrinks to the corners that carry the nearest point; false: the origin is inside.
bool reduce(Simplex& simplex) {
  if (simplex.size == 4) return reduce_tetrahedron(simplex);
  if (simplex.size == 3) {
    const Vector3& a = simplex.w(0);
    const Vector3 normal = (simplex.w(1) - a).cross(simplex.w(2) - a);
    take(on_triangle(simplex, 1, 2, normal), simplex);
  } else {
    take(on_segment(simplex, 1), simplex);
  }
  return true;
}

int name_p(double name) { return static_cast<int>(std::bit_cast<long long>(name) & 0x7fffffff); }
int name_q(double name) { return static_cast<int>(std::bit_cast<long long>(name) >> 32); }

Corner corner_of(const NewCorner& corner) {
  const double name = corner.name[0];
  return {{corner.w.x[0], corner.w.y[0], corner.w.z[0]}, name_p(name), name_q(name)};
}

/// Some corners in the order of their lanes, the newest first; the last one fills what is left.
SimplexReduction rows_of(const Simplex& simplex, const Vector3& apart) {
  SimplexReduction rows;
  for (int lane = 0; lane < 4; ++lane) {
    const int k = lane == 3 ? 0 : std::min(lane, simplex.size - 1);
    const Corner& corner = simplex.corners[static_cast<std::size_t>(k)];
    const Vector3 offset = corner.w - apart;
    rows.offset.x[lane] = offset.x();
    rows.offset.y[lane] = offset.y();
    rows.offset.z[lane] = offset.z();
    rows.names[lane] = corner_name(corner.p, corner.q)[0];
  }
  rows.edges = (1u << simplex.size) - 1u;
  rows.triangles = simplex.size == 3 ? 7 : static_cast<unsigned>(simplex.size - 1);
  return rows;
}

/// The same step by distances, where signs leave it open: flat simplices.
[[gnu::noinline, gnu::flatten]] inline Carried take_corner_by_distance(const Corner& corner,
                                                                       const Vector3& apart,
                                                                       SimplexReduction& rows,
                                                                       Direction& towards) {
  Simplex simplex;
  for (int lane = 3; lane-- > 0;) {
    if ((rows.edges >> lane & 1u) == 0) continue;
    const Vector3 offset(rows.offset.x[lane], rows.offset.y[lane], rows.offset.z[lane]);
    simplex.push_front({offset + apart, name_p(rows.names[lane]), name_q(rows.names[lane])});
  }
  simplex.push_front(corner);
  if (!reduce(simplex)) return Carried::Inside;
  rows = rows_of(simplex, apart);
  const Vector3& v = simplex.direction;
  towards = {v.x(), v.y(), v.z(), simplex.size == 3 ? 0.0 : 1.0};
  return Carried::Found;
}

/// Corners of their own first, then those that stand twice.
void name_corners(const SimplexReduction& rows, SearchResult& result) {
  static constexpr std::array<unsigned char, 8> kFirst{0, 0, 0, 0, 0, 2, 1, 0},
      kCount{0, 1, 1, 2, 1, 2, 2, 3}, kLanes{0, 1, 2, 0, 1, 0, 0, 0};
  std::array<double, 4> names;
  std::memcpy(names.data(), &rows.names, sizeof(names));
  for (std::size_t k = 0; k < 3; ++k) {
    const double name = names[kLanes[kFirst[rows.edges] + k]];
    result.p[k] = name_p(name);
    result.q[k] = name_q(name);
  }
  result.corners = kCount[rows.edges];
}

/// From the rows that the scans have read; `apart`: between their origins.
template <class AnyRows>
NewCorner new_corner(const AnyRows& p, const AnyRows& q, const PairSupport& both,
                     const Vector3& apart) {
  const int i = both.p.vertex, j = both.q.vertex;
  const Vec3 step = q.placed(j) - p.placed(i);
  const FourVectors offset{four(step.x), four(step.y), four(step.z)};
  const FourVectors between{four(apart.x()), four(apart.y()), four(apart.z())};
  return {offset + between, offset, corner_name(i, j)};
}

/// What a direction says of the nearest point. `newest`: one of the corners that carry it.
struct Reach {
  double along;           // of the corners along the direction
  double squared_length;  // of the direction
  double squared_distance;

  Reach(const FourVectors& newest, const Direction& d)
      : along(d.x * newest.x[0] + d.y * newest.y[0] + d.z * newest.z[0]),
        squared_length(d.x * d.x + d.y * d.y + d.z * d.z) {
    const bool normal = d.scale == 0.0;
    squared_distance =
        (normal ? along * along : squared_length) / (normal ? squared_length : d.scale * d.scale);
  }
};

template <class AnyRows>
SearchResult search_rows(const Solid& p, const Solid& q, const Vector3& direction,
                         double rounding) {
  SearchResult result;
  const AnyRows rows_p(p), rows_q(q);
  const Vector3 apart = q.origin() - p.origin();
  const auto corner_along = [&](const Vector3& d) {
    const PairSupport both = Scan::support_pair(rows_p, rows_q, d);
    __builtin_prefetch(p.shape().vertices().data() + 3 * both.p.vertex);  // for the closed form
    __builtin_prefetch(q.shape().vertices().data() + 3 * both.q.vertex);
    return new_corner(rows_p, rows_q, both, apart);
  };
  const NewCorner first = corner_along(direction);
  SimplexReduction rows;
  rows.offset = first.offset;
  rows.names = first.name;
  Direction d{first.w.x[0], first.w.y[0], first.w.z[0]};
  Reach reach(first.w, d);
  double before = kInfinity;
  bool inside = false;
  while (result.iterations < kMostSteps) {
    ++result.iterations;
    if (!(reach.squared_distance > kNothing * kNothing * rounding * rounding)) {
      result.outcome = SearchOutcome::Overlapping;
      break;
    }
    const NewCorner corner = corner_along(Vector3(d.x, d.y, d.z));
    const FourVectors to_newest = rows.offset - corner.offset;
    const double nearer = d.x * to_newest.x[3] + d.y * to_newest.y[3] + d.z * to_newest.z[3];
    const double gain = nearer - kGainRounding * kEpsilon * reach.along;
    const bool no_gain =
        !(gain > 0.0) | (gain * gain <= rounding * rounding * reach.squared_length);
    if (no_gain | has_corner(rows, corner.name) | !(reach.squared_distance < before)) {
      result.outcome = SearchOutcome::Separated;  // as far as doubles go; the proof decides
      break;
    }
    before = reach.squared_distance;
    Carried carried = Carried::Found;
    if (rows.edges == 1)
      take_second_corner(corner, rows, d);
    else
      carried = take_corner(corner, rows, d);
    if (carried == Carried::Unclear) {
      SimplexReduction other = rows;  // copies, so that the others stay in registers
      Direction towards = d;
      carried = take_corner_by_distance(corner_of(corner), apart, other, towards);
      rows = other;
      d = towards;
    }
    if (carried == Carried::Inside) {
      result.outcome = SearchOutcome::Overlapping;
      result.p[3] = name_p(corner.name[0]);
      result.q[3] = name_q(corner.name[0]);
      inside = true;
      break;
    }
    reach = Reach(corner.w, d);
  }
  name_corners(rows, result);
  if (inside) result.corners = 4;
  result.bound = std::sqrt(reach.squared_distance);
  const double length = std::sqrt(reach.squared_length);
  if (length > 0.0) result.normal = Vector3(d.x, d.y, d.z) / length;
  return result;
}

}  // namespace
}  // namespace quoin::geometry
