#include "fast_search.hpp"

#include <cmath>
#include <limits>

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

  bool has(int p, int q) const {
    for (int k = 0; k < size; ++k) {
      const Corner& c = corners[static_cast<std::size_t>(k)];
      if (c.p == p && c.q == q) return true;
    }
    return false;
  }
  void push_front(const Corner& corner) {
    for (int k = size; k > 0; --k) {
      corners[static_cast<std::size_t>(k)] = corners[static_cast<std::size_t>(k - 1)];
    }
    corners[0] = corner;
    ++size;
  }
  void keep(int i) {
    corners[0] = corners[static_cast<std::size_t>(i)];
    size = 1;
  }
  void keep(int i, int j) {
    const Corner a = corners[static_cast<std::size_t>(i)], b = corners[static_cast<std::size_t>(j)];
    corners[0] = a;
    corners[1] = b;
    size = 2;
  }
  void keep(int i, int j, int k) {
    const Corner a = corners[static_cast<std::size_t>(i)], b = corners[static_cast<std::size_t>(j)],
                 c = corners[static_cast<std::size_t>(k)];
    corners[0] = a;
    corners[1] = b;
    corners[2] = c;
    size = 3;
  }
};

/// Point of one segment or triangle nearest to the origin: which corners carry it (bits),
/// direction.
struct Nearest {
  unsigned mask = 0;
  Vector3 direction;
  double squared = std::numeric_limits<double>::infinity();
};

Nearest at_corner(const Vector3& a, unsigned bit) { return {bit, a, a.squaredNorm()}; }

Nearest on_segment(const Vector3& a, const Vector3& b, unsigned bit_a, unsigned bit_b) {
  const Vector3 e = b - a;
  const double along = -a.dot(e), length = e.squaredNorm();
  if (!(along > 0.0)) return at_corner(a, bit_a);
  if (!(along < length)) return at_corner(b, bit_b);
  const Vector3 v = a + e * (along / length);
  return {bit_a | bit_b, v, v.squaredNorm()};
}

/// Source: [Ericson 2005], section 5.1.5, for the point at the origin.
Nearest on_triangle(const Vector3& a, const Vector3& b, const Vector3& c, unsigned bit_a,
                    unsigned bit_b, unsigned bit_c) {
  const Vector3 ab = b - a, ac = c - a;
  const double d1 = -ab.dot(a), d2 = -ac.dot(a);
  if (d1 <= 0.0 && d2 <= 0.0) return at_corner(a, bit_a);
  const double d3 = -ab.dot(b), d4 = -ac.dot(b);
  if (d3 >= 0.0 && d4 <= d3) return at_corner(b, bit_b);
  const double d5 = -ab.dot(c), d6 = -ac.dot(c);
  if (d6 >= 0.0 && d5 <= d6) return at_corner(c, bit_c);
  if (d1 * d4 - d3 * d2 <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return on_segment(a, b, bit_a, bit_b);
  if (d5 * d2 - d1 * d6 <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return on_segment(a, c, bit_a, bit_c);
  if (d3 * d6 - d5 * d4 <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    return on_segment(b, c, bit_b, bit_c);
  }
  const Vector3 normal = ab.cross(ac);
  const double height = normal.dot(a);
  return {bit_a | bit_b | bit_c, height < 0.0 ? Vector3(-normal) : normal,
          height * height / normal.squaredNorm()};
}

void take(const Nearest& nearest, Simplex& simplex) {
  simplex.direction = nearest.direction;
  simplex.squared_distance = nearest.squared;
  std::array<int, 4> kept{};
  int count = 0;
  for (int k = 0; k < simplex.size; ++k) {
    if (nearest.mask >> k & 1u) kept[static_cast<std::size_t>(count++)] = k;
  }
  if (count == 1) simplex.keep(kept[0]);
  if (count == 2) simplex.keep(kept[0], kept[1]);
  if (count == 3) simplex.keep(kept[0], kept[1], kept[2]);
}

/// Shrinks to the corners that carry the nearest point; false: the origin is inside.
bool reduce(Simplex& simplex) {
  const auto& c = simplex.corners;
  const Vector3 &a = c[0].w, &b = c[1].w, &d = c[2].w, &e = c[3].w;
  if (simplex.size == 1) {
    take(at_corner(a, 1), simplex);
  } else if (simplex.size == 2) {
    take(on_segment(a, b, 1, 2), simplex);
  } else if (simplex.size == 3) {
    take(on_triangle(a, b, d, 1, 2, 4), simplex);
  } else {
    const Vector3 ab = b - a, ad = d - a, ae = e - a;
    const double volume = ab.cross(ad).dot(ae);
    Nearest best;
    const auto consider = [&](const Vector3& outward, const Vector3& u, const Vector3& v,
                              unsigned bit_u, unsigned bit_v) {
      if (!(volume == 0.0) && (outward.dot(a) < 0.0) == (volume < 0.0)) return;
      const Nearest candidate = on_triangle(a, u, v, 1, bit_u, bit_v);
      if (candidate.squared < best.squared) best = candidate;
    };
    // outward·a and volume of one sign: the origin lies on the inner side of that face.
    consider(-ab.cross(ad), b, d, 2, 4);
    consider(-ad.cross(ae), d, e, 4, 8);
    consider(-ae.cross(ab), e, b, 8, 2);
    if (best.mask == 0) return false;
    take(best, simplex);
  }
  return true;
}

Corner find_corner(const Polyhedron& p, const Polyhedron& q, const Vector3& direction) {
  const PairSupport both = support_pair(p, q, direction);
  const int i = both.p.vertex, j = both.q.vertex;
  return {q.vertex(j) - p.vertex(i), i, j};
}

void name_corners(const Simplex& simplex, FastResult& result) {
  result.corners = simplex.size;
  for (int k = 0; k < simplex.size; ++k) {
    result.p[static_cast<std::size_t>(k)] = simplex.corners[static_cast<std::size_t>(k)].p;
    result.q[static_cast<std::size_t>(k)] = simplex.corners[static_cast<std::size_t>(k)].q;
  }
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
      const Corner corner = find_corner(p_, q_, -facet.normal);
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
      corners_.push_back({q_.vertex(j) - p_.vertex(i), i, j});
    }
    while (corners_.size() < 4) {
      if (!add_across()) return false;
    }
    const Vector3 a = corner_at(1).w - corner_at(0).w, b = corner_at(2).w - corner_at(0).w;
    const Vector3 c = corner_at(3).w - corner_at(0).w;
    if (a.cross(b).dot(c) > 0.0) std::swap(corners_[0], corners_[1]);  // (0, 1, 2) turns from 3
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
      const Corner corner = find_corner(p_, q_, side * direction);
      const double reach = std::abs(direction.dot(corner.w - corner_at(0).w));
      if (reach > farthest) {
        farthest = reach;
        best = corner;
      }
    }
    if (!(farthest > rounding_ * direction.norm())) return false;
    corners_.push_back(best);
    return true;
  }

  void add_facet(const std::array<int, 3>& corners, const std::array<int, 3>& neighbours) {
    facets_.push_back({});
    Facet& facet = facets_[facets_.size() - 1];
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
      const Vector3& a = corner_at(facet.corners[0]).w;
      facet.normal = normal / area;
      facet.distance = facet.normal.dot(a);
      const double reach =
          std::sqrt(std::max({a.squaredNorm(), corner_at(facet.corners[1]).w.squaredNorm(),
                              corner_at(facet.corners[2]).w.squaredNorm()}));
      facet.sure = facet.distance - kEpsilon * reach * (1.0 + size / area);
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
    corners_.push_back(corner);
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
  SmallVector<Facet, 4 * kMostCorners> facets_;
};

}  // namespace

FastResult fast_nearest(const Polyhedron& p, const Polyhedron& q, const Vector3& direction,
                        double rounding) {
  FastResult result;
  Simplex simplex;
  simplex.push_front(find_corner(p, q, direction));
  simplex.direction = simplex.corners[0].w;
  simplex.squared_distance = simplex.direction.squaredNorm();
  const double nothing = 16 * rounding * rounding;
  while (result.iterations < kMostSteps) {
    ++result.iterations;
    if (!(simplex.squared_distance > nothing)) {
      result.outcome = FastOutcome::Overlapping;
      break;
    }
    const Corner corner = find_corner(p, q, simplex.direction);
    const double gain = simplex.direction.dot(simplex.corners[0].w - corner.w) -
                        4 * kEpsilon * simplex.direction.dot(simplex.corners[0].w);
    if (gain <= 0.0 || gain * gain <= rounding * rounding * simplex.direction.squaredNorm() ||
        simplex.has(corner.p, corner.q)) {
      result.outcome = FastOutcome::Separated;
      break;
    }
    simplex.push_front(corner);
    if (!reduce(simplex)) {
      result.outcome = FastOutcome::Overlapping;
      break;
    }
    if (!simplex.has(corner.p,
                     corner.q)) {  // no step forward: rounding; the caller's proof decides
      result.outcome = FastOutcome::Separated;
      break;
    }
  }
  result.bound = std::sqrt(simplex.squared_distance);
  const double length = simplex.direction.norm();
  if (length > 0.0) result.normal = simplex.direction / length;
  name_corners(simplex, result);
  return result;
}

FastResult fast_overlap(const Polyhedron& p, const Polyhedron& q, const FastResult& start,
                        double rounding) {
  return Polytope(p, q, rounding).grow(start);
}

}  // namespace quoin::geometry
