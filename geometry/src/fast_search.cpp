#include "fast_search.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "simplex_rows.hpp"
#include "support_lanes.hpp"

namespace quoin::geometry {
namespace {

constexpr int kMostSteps = 64;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

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
    for (int k = size; k > 0; --k) {
      corners[static_cast<std::size_t>(k)] = corners[static_cast<std::size_t>(k - 1)];
    }
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
  Vector3 direction;
  double squared = std::numeric_limits<double>::infinity();
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
  if (!(best.squared < std::numeric_limits<double>::infinity())) return false;
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

template <class Scan>
Corner find_corner(const Polyhedron& p, const Polyhedron& q, const Vector3& direction) {
  const int i = Scan::support(Rows(p), direction).vertex;
  const int j = Scan::support(Rows(q), -direction).vertex;
  return {q.vertex(j) - p.vertex(i), i, j};
}

// ---- least overlap ----

/// A triangle of the growing polytope, counter-clockwise seen from outside.
struct Facet {
  std::array<int, 3> corners{};
  std::array<int, 3> neighbours{};   // [k] lies across the edge from corners[k] to the next
  Vector3 normal = Vector3::Zero();  // unit, outward; zero when the triangle has no area
  double distance = 0.0;             // of its plane from the origin, m
  double sure = 0.0;                 // the same less its rounding
  bool alive = true;
  bool slim = false;  // its normal is that of doubles that have cancelled
  int seen = -1;      // last corner that it was tested for
};

/// A polytope inside the set of differences, around the origin. While all its facets turn to the
/// origin their inner sides, each ray from the origin meets one of them; so the least distance of a
/// facet is a depth that the solids have at least. See geometry/README.md, "Least overlap".
template <class Scan>
class Polytope {
 public:
  Polytope(const Polyhedron& p, const Polyhedron& q, double rounding)
      : p_(p), q_(q), rounding_(rounding) {}

  FastResult grow(const FastResult& start) {
    FastResult result = start;
    result.outcome = FastOutcome::Unclear;
    result.iterations = 0;
    if (!begin(start)) return result;
    while (result.iterations < kMostCorners - 8) {
      ++result.iterations;
      const int nearest = nearest_facet();
      if (nearest < 0) return result;
      const Facet& facet = at(nearest);
      const Corner corner = find_corner<Scan>(p_, q_, -facet.normal);
      const double gain = facet.normal.dot(corner.w - corner_at(facet.corners[0]).w);
      if (gain <= rounding_) {
        finish(facet, result);
        return result;
      }
      if (!expand(nearest, corner)) return result;
    }
    return result;
  }

 private:
  static constexpr int kMostCorners = 96;

  Facet& at(int f) { return facets_[static_cast<std::size_t>(f)]; }
  const Corner& corner_at(int c) const { return corners_[static_cast<std::size_t>(c)]; }

  /// A tetrahedron around the origin, from the corners of the search and, where it ended with
  /// fewer, from supports across them.
  bool begin(const FastResult& start) {
    for (int k = 0; k < start.corners; ++k) {
      const int i = start.p[static_cast<std::size_t>(k)], j = start.q[static_cast<std::size_t>(k)];
      add_corner({q_.vertex(j) - p_.vertex(i), i, j});
    }
    while (corners_.size() < 4) {
      if (!add_across()) return false;
    }
    const Vector3 a = corner_at(1).w - corner_at(0).w, b = corner_at(2).w - corner_at(0).w;
    const Vector3 c = corner_at(3).w - corner_at(0).w;
    if (a.cross(b).dot(c) > 0.0) swap_first_two();  // (0, 1, 2) turns from 3
    add_facet({0, 1, 2}, {1, 2, 3});
    add_facet({1, 0, 3}, {0, 3, 2});
    add_facet({2, 1, 3}, {0, 1, 3});
    add_facet({0, 2, 3}, {0, 2, 1});
    return true;
  }

  bool add_across() {
    Vector3 direction;
    if (corners_.size() == 3) {
      direction = (corner_at(1).w - corner_at(0).w).cross(corner_at(2).w - corner_at(0).w);
    } else {
      const Vector3 line = corners_.size() == 2 ? Vector3(corner_at(1).w - corner_at(0).w)
                                                : Vector3(q_.vertex_mean() - p_.vertex_mean());
      int axis = 0;
      line.cwiseAbs().minCoeff(&axis);
      direction = line.cross(Vector3::Unit(axis));
    }
    Corner best{Vector3::Zero(), 0, 0};
    double farthest = 0.0;
    for (const double side : {1.0, -1.0}) {
      const Corner corner = find_corner<Scan>(p_, q_, side * direction);
      const double reach = std::abs(direction.dot(corner.w - corner_at(0).w));
      if (reach > farthest) {
        farthest = reach;
        best = corner;
      }
    }
    if (!(farthest > rounding_ * direction.norm())) return false;
    add_corner(best);
    return true;
  }

  void add_corner(const Corner& corner) {
    corners_.push_back(corner);
    lengths_.push_back(corner.w.norm());
  }

  void swap_first_two() {
    std::swap(corners_[0], corners_[1]);
    std::swap(lengths_[0], lengths_[1]);
  }

  void add_facet(const std::array<int, 3>& corners, const std::array<int, 3>& neighbours) {
    facets_.resize(facets_.size() + 1);
    Facet& facet = facets_[facets_.size() - 1];
    facet.alive = true;
    facet.seen = -1;
    facet.corners = corners;
    facet.neighbours = neighbours;
    const Vector3& a = corner_at(corners[0]).w;
    const Vector3 u = corner_at(corners[1]).w - a, v = corner_at(corners[2]).w - a;
    const Vector3 normal = u.cross(v);
    const double squared = normal.squaredNorm(), size = u.squaredNorm() * v.squaredNorm();
    facet.slim = squared < 0.0625 * size;
    set_plane(normal, std::sqrt(squared), std::sqrt(size), facet);
  }

  /// `size` over `area`: by how much the products that made the normal have cancelled.
  void set_plane(const Vector3& normal, double area, double size, Facet& facet) {
    facet.normal = Vector3::Zero();
    facet.distance = facet.sure = std::numeric_limits<double>::infinity();
    if (area > 1e-14 * size) {
      const auto length = [&](std::size_t k) {
        return lengths_[static_cast<std::size_t>(facet.corners[k])];
      };
      const double inverse = 1.0 / area;
      facet.normal = inverse * normal;
      facet.distance = facet.normal.dot(corner_at(facet.corners[0]).w);
      const double reach = std::max({length(0), length(1), length(2)});
      facet.sure = facet.distance - kEpsilon * reach * (1.5 + size * inverse);
    }
  }

  Vector3 wide_normal(const std::array<int, 3>& corners) const {
    std::array<WideVector, 3> w;
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner& c = corner_at(corners[k]);
      w[k] = wide_difference(q_.vertex(c.q), p_.vertex(c.p));
    }
    return cross(w[1] - w[0], w[2] - w[0]).rounded();
  }

  /// The facet nearest to the origin, or -1 where one turns its outer side to it.
  int nearest_facet() {
    int nearest = least_facet();
    while (nearest >= 0 && at(nearest).slim) {  // only now is it worth its exact normal
      Facet& facet = at(nearest);
      facet.slim = false;
      const Vector3 normal = wide_normal(facet.corners);
      const double area = normal.norm();
      set_plane(normal, area, area, facet);
      nearest = least_facet();
    }
    return nearest;
  }

  int least_facet() {
    int nearest = -1;
    double least = std::numeric_limits<double>::infinity();
    for (int f = 0; f < facets_.count(); ++f) {
      const Facet& facet = at(f);
      if (!facet.alive) continue;
      if (facet.distance < -rounding_ && !facet.slim) return -1;
      if (facet.sure < least) {
        least = facet.sure;
        nearest = f;
      }
    }
    return nearest;
  }

  bool sees(const Vector3& w, Facet& facet) const {
    return facet.normal.dot(w - corner_at(facet.corners[0]).w) > 0.0;
  }

  struct Step {
    int facet, side;
  };

  /// Replaces the facets that see the new corner by a cone over their border.
  bool expand(int first, const Corner& corner) {
    const int apex = corners_.count();
    add_corner(corner);
    SmallVector<Step, 64> stack, border;
    at(first).alive = false;
    at(first).seen = apex;
    for (int k = 2; k >= 0; --k) stack.push_back({first, k});
    while (!stack.empty()) {
      const Step step = stack[stack.size() - 1];
      stack.resize(stack.size() - 1);
      const Facet here = at(step.facet);
      const int next = here.neighbours[static_cast<std::size_t>(step.side)];
      Facet& other = at(next);
      if (other.seen == apex && !other.alive) continue;
      if (!sees(corner.w, other)) {
        border.push_back(step);
        continue;
      }
      other.alive = false;
      other.seen = apex;
      const int to = here.corners[static_cast<std::size_t>((step.side + 1) % 3)];
      int entry = 0;
      while (entry < 3 && other.corners[static_cast<std::size_t>(entry)] != to) ++entry;
      stack.push_back({next, (entry + 2) % 3});
      stack.push_back({next, (entry + 1) % 3});
    }
    return add_cone(border, apex);
  }

  bool add_cone(const SmallVector<Step, 64>& border, int apex) {
    const int first = facets_.count(), count = border.count();
    if (count < 3 || first + count > 4 * kMostCorners) return false;
    for (int k = 0; k < count; ++k) {
      const Step step = border[static_cast<std::size_t>(k)];
      const Facet old = at(step.facet);
      const int from = old.corners[static_cast<std::size_t>(step.side)];
      const int to = old.corners[static_cast<std::size_t>((step.side + 1) % 3)];
      const int outer = old.neighbours[static_cast<std::size_t>(step.side)];
      Facet& beyond = at(outer);
      for (std::size_t side = 0; side < 3; ++side) {
        if (beyond.corners[side] == to && beyond.corners[(side + 1) % 3] == from) {
          beyond.neighbours[side] = first + k;
        }
      }
      add_facet({from, to, apex},
                {outer, first + (k + 1) % count, first + (k + count - 1) % count});
    }
    for (int k = 0; k < count; ++k) {  // one closed loop, or rounding has torn the surface
      const int to = at(first + k).corners[1], from = at(first + (k + 1) % count).corners[0];
      if (to != from) return false;
    }
    return true;
  }

  void finish(const Facet& facet, FastResult& result) {
    for (const Facet& other :
         facets_) {  // another direction as good: for the exhaustive way to judge
      if (other.alive && other.distance <= facet.distance + 8 * rounding_ &&
          other.normal.dot(facet.normal) < 1.0 - 1e-9) {
        return;
      }
    }
    result.outcome = FastOutcome::Overlapping;
    result.normal = -facet.normal;
    result.bound = -facet.sure;
    result.corners = 3;
    for (std::size_t k = 0; k < 3; ++k) {
      result.p[k] = corner_at(facet.corners[k]).p;
      result.q[k] = corner_at(facet.corners[k]).q;
    }
  }

  const Polyhedron& p_;
  const Polyhedron& q_;
  double rounding_;
  SmallVector<Corner, kMostCorners> corners_;
  SmallVector<double, kMostCorners> lengths_;  // of the corners' w, m
  SmallVector<Facet, 4 * kMostCorners> facets_;
};

int name_p(const SimplexRows& rows, int lane) {
  return static_cast<int>(std::bit_cast<long long>(rows.names[lane]) & 0x7fffffff);
}
int name_q(const SimplexRows& rows, int lane) {
  return static_cast<int>(std::bit_cast<long long>(rows.names[lane]) >> 32);
}

/// Some corners in the order of their lanes, the newest first; the last one fills what is left.
SimplexRows rows_of(const Simplex& simplex) {
  SimplexRows rows;
  for (int lane = 0; lane < 4; ++lane) {
    const int k = lane == 3 ? 0 : std::min(lane, simplex.size - 1);
    const Corner& corner = simplex.corners[static_cast<std::size_t>(k)];
    rows.w.x[lane] = corner.w.x();
    rows.w.y[lane] = corner.w.y();
    rows.w.z[lane] = corner.w.z();
    rows.names[lane] = corner_name(corner.p, corner.q)[0];
  }
  rows.edges = (1u << simplex.size) - 1u;
  rows.triangles = simplex.size == 3 ? 7 : static_cast<unsigned>(simplex.size - 1);
  return rows;
}

/// The same step by distances, where signs leave it open: flat simplices.
[[gnu::noinline]] Carried take_corner_by_distance(const Corner& corner, SimplexRows& rows,
                                                  Direction& towards) {
  Simplex simplex;
  for (int lane = 3; lane-- > 0;) {
    if ((rows.edges >> lane & 1u) == 0) continue;
    const Vector3 w(rows.w.x[lane], rows.w.y[lane], rows.w.z[lane]);
    simplex.push_front({w, name_p(rows, lane), name_q(rows, lane)});
  }
  simplex.push_front(corner);
  if (!reduce(simplex)) return Carried::Inside;
  rows = rows_of(simplex);
  const Vector3& v = simplex.direction;
  towards = {v.x(), v.y(), v.z(), simplex.size == 3 ? 0.0 : 1.0};
  return Carried::Found;
}

/// Corners of their own first, then those that stand twice.
void name_corners(const SimplexRows& rows, FastResult& result) {
  static constexpr std::array<unsigned char, 8> kFirst{0, 0, 0, 0, 0, 2, 1, 0},
      kCount{0, 1, 1, 2, 1, 2, 2, 3}, kLanes{0, 1, 2, 0, 1, 0, 0, 0};
  std::array<long long, 4> names;
  std::memcpy(names.data(), &rows.names, sizeof(names));
  for (std::size_t k = 0; k < 3; ++k) {
    const long long name = names[kLanes[kFirst[rows.edges] + k]];
    result.p[k] = static_cast<int>(name & 0x7fffffff);
    result.q[k] = static_cast<int>(name >> 32);
  }
  result.corners = kCount[rows.edges];
}

/// q_j - p_i from the rows that the scans have read; `apart`: between the origins of the rows.
FourVectors difference(const Rows& p, int i, const Rows& q, int j, const Vector3& apart) {
  return {four(q.x[j] - p.x[i] + apart.x()), four(q.y[j] - p.y[i] + apart.y()),
          four(q.z[j] - p.z[i] + apart.z())};
}

/// What a direction says of the nearest point.
struct Reach {
  double along;           // of the corners along the direction
  double squared_length;  // of the direction
  double squared_distance;

  Reach(const SimplexRows& rows, const Direction& d)
      : along(d.x * rows.w.x[3] + d.y * rows.w.y[3] + d.z * rows.w.z[3]),
        squared_length(d.x * d.x + d.y * d.y + d.z * d.z) {
    const bool normal = d.scale == 0.0;
    squared_distance =
        (normal ? along * along : squared_length) / (normal ? squared_length : d.scale * d.scale);
  }
};

template <class Scan>
FastResult search(const Polyhedron& p, const Polyhedron& q, const Vector3& direction,
                  double rounding) {
  using Flags = typename Scan::Flags;
  FastResult result;
  const Rows rows_p(p), rows_q(q);
  const Vector3 apart = q.origin() - p.origin();
  const PairSupport first = Scan::support_pair(rows_p, rows_q, direction);
  SimplexRows rows;
  rows.w = difference(rows_p, first.p.vertex, rows_q, first.q.vertex, apart);
  rows.names = corner_name(first.p.vertex, first.q.vertex);
  Direction d{rows.w.x[0], rows.w.y[0], rows.w.z[0]};
  Reach reach(rows, d);
  double before = std::numeric_limits<double>::infinity();
  bool inside = false;
  while (result.iterations < kMostSteps) {
    ++result.iterations;
    if (!(reach.squared_distance > 16 * rounding * rounding)) {
      result.outcome = FastOutcome::Overlapping;
      break;
    }
    const PairSupport both = Scan::support_pair(rows_p, rows_q, Vector3(d.x, d.y, d.z));
    const int i = both.p.vertex, j = both.q.vertex;
    const FourVectors corner = difference(rows_p, i, rows_q, j, apart), edges = rows.w - corner;
    const Four name = corner_name(i, j);
    const double gain =
        d.x * edges.x[3] + d.y * edges.y[3] + d.z * edges.z[3] - 4 * kEpsilon * reach.along;
    const bool no_gain =
        !(gain > 0.0) | (gain * gain <= rounding * rounding * reach.squared_length);
    if (no_gain | has_corner<Flags>(rows, name) | !(reach.squared_distance < before)) {
      result.outcome = FastOutcome::Separated;  // as far as doubles go; the proof decides
      break;
    }
    before = reach.squared_distance;
    Carried carried = take_corner<Flags>(corner, edges, name, rows, d);
    if (carried == Carried::Unclear) {
      SimplexRows other = rows;  // copies, so that the others stay in registers
      Direction towards = d;
      carried =
          take_corner_by_distance({{corner.x[0], corner.y[0], corner.z[0]}, i, j}, other, towards);
      rows = other;
      d = towards;
    }
    if (carried == Carried::Inside) {
      result.outcome = FastOutcome::Overlapping;
      result.p[3] = i;
      result.q[3] = j;
      inside = true;
      break;
    }
    reach = Reach(rows, d);
  }
  name_corners(rows, result);
  if (inside) result.corners = 4;
  result.bound = std::sqrt(reach.squared_distance);
  const double length = std::sqrt(reach.squared_length);
  if (length > 0.0) result.normal = Vector3(d.x, d.y, d.z) / length;
  return result;
}

#ifdef QUOIN_WIDE_LANES
QUOIN_AVX512 [[gnu::flatten]] FastResult search_512(const Polyhedron& p, const Polyhedron& q,
                                                    const Vector3& direction, double rounding) {
  return search<Scan512>(p, q, direction, rounding);
}
QUOIN_AVX2 [[gnu::flatten]] FastResult search_256(const Polyhedron& p, const Polyhedron& q,
                                                  const Vector3& direction, double rounding) {
  return search<Scan256>(p, q, direction, rounding);
}
QUOIN_AVX512 [[gnu::flatten]] FastResult overlap_512(const Polyhedron& p, const Polyhedron& q,
                                                     const FastResult& start, double rounding) {
  return Polytope<Scan512>(p, q, rounding).grow(start);
}
QUOIN_AVX2 [[gnu::flatten]] FastResult overlap_256(const Polyhedron& p, const Polyhedron& q,
                                                   const FastResult& start, double rounding) {
  return Polytope<Scan256>(p, q, rounding).grow(start);
}
#endif

}  // namespace

FastResult fast_nearest(const Polyhedron& p, const Polyhedron& q, const Vector3& direction,
                        double rounding) {
#ifdef QUOIN_WIDE_LANES
  if (has_avx512() && !few_vertices(p, q)) return search_512(p, q, direction, rounding);
  if (has_avx2()) return search_256(p, q, direction, rounding);
#endif
  return search<PlainScan>(p, q, direction, rounding);
}

FastResult fast_overlap(const Polyhedron& p, const Polyhedron& q, const FastResult& start,
                        double rounding) {
#ifdef QUOIN_WIDE_LANES
  if (has_avx512()) return overlap_512(p, q, start, rounding);
  if (has_avx2()) return overlap_256(p, q, start, rounding);
#endif
  return Polytope<PlainScan>(p, q, rounding).grow(start);
}

}  // namespace quoin::geometry
