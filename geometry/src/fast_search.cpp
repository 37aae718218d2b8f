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
    const double length = simplex.direction.norm();
    if (!(simplex.squared_distance > nothing) || !(length > 0.0)) {
      result.outcome = FastOutcome::Overlapping;
      break;
    }
    const Corner corner = find_corner(p, q, simplex.direction);
    const double gain = simplex.direction.dot(simplex.corners[0].w - corner.w);
    result.normal = simplex.direction / length;
    const double slack = rounding + 4 * kEpsilon * std::sqrt(simplex.squared_distance);
    if (gain <= slack * length || simplex.has(corner.p, corner.q)) {
      result.outcome = FastOutcome::Separated;
      break;
    }
    simplex.push_front(corner);
    if (!reduce(simplex)) {
      result.outcome = FastOutcome::Overlapping;
      break;
    }
    if (!simplex.has(corner.p, corner.q)) break;  // no step forward: rounding
  }
  result.bound = std::sqrt(simplex.squared_distance);
  name_corners(simplex, result);
  return result;
}

FastResult fast_overlap(const Polyhedron&, const Polyhedron&, const FastResult& start, double) {
  FastResult result = start;
  result.outcome = FastOutcome::Unclear;
  return result;
}

}  // namespace quoin::geometry
