#include "brick_overlap.hpp"

#include <bit>
#include <cmath>
#include <limits>

#include "eight_lanes.hpp"

namespace quoin::geometry {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// A parallelepiped: half its edges from vertex 0, its middle, and how far the vertices of the
/// solid lie from those of it, m.
struct Brick {
  std::span<const int> vertices;
  std::array<Vector3, 3> half;
  Vector3 middle;
  double error = 0.0;

  explicit Brick(const Polyhedron& solid) : vertices(solid.topology().brick()) {
    const auto at = [&](std::size_t place) { return offset(solid, vertices[place]); };
    const Vector3 base = at(0);
    middle = base;
    for (std::size_t k = 0; k < 3; ++k) {
      half[k] = 0.5 * (at(std::size_t{1} << k) - base);
      middle += half[k];
    }
    double squared = 0.0;
    for (const std::size_t place : {3, 5, 6, 7}) {
      squared = std::max(squared, (at(place) - corner(place)).squaredNorm());
    }
    error = std::sqrt(squared) + 8 * kEpsilon * solid.diameter();
  }
  Vector3 corner(std::size_t place) const {
    Vector3 x = middle;
    for (std::size_t k = 0; k < 3; ++k) x += (place >> k & 1) != 0 ? half[k] : Vector3(-half[k]);
    return x;
  }
  /// The place of the corner farthest along a direction.
  std::size_t support(const Vector3& direction) const {
    std::size_t place = 0;
    for (std::size_t k = 0; k < 3; ++k) place |= std::size_t{half[k].dot(direction) > 0.0} << k;
    return place;
  }
};

/// The six half edges as rows, and which two of them span each of the 15 directions: P's faces, Q's
/// faces, pairs of edges; one is there twice.
struct Directions {
  using Places = std::array<std::uint16_t, 16>;
  static constexpr Places kFirst{1, 2, 0, 4, 5, 3, 0, 0, 0, 1, 1, 1, 2, 2, 2, 2};
  static constexpr Places kSecond{2, 0, 1, 5, 3, 4, 3, 4, 5, 3, 4, 5, 3, 4, 5, 5};
  static constexpr unsigned kAll = 0x7fff;
  std::array<double, 6> x, y, z;

  Directions(const Brick& p, const Brick& q) {
    for (std::size_t k = 0; k < 6; ++k) {
      const Vector3& edge = k < 3 ? p.half[k] : q.half[k - 3];
      x[k] = edge.x();
      y[k] = edge.y();
      z[k] = edge.z();
    }
  }
  Vector3 edge(std::size_t k) const { return {x[k], y[k], z[k]}; }
};

/// How far the bricks overlap along eight of the directions, and at least so far, m.
template <class Eight>
void find_overlaps(const Directions& edges, std::size_t first, const Vector3& across, double reach,
                   double* overlap, double* sure) {
  const auto all = [](double value) { return Eight::all(value); };
  const auto size = [&](const Eight& v) { return v.larger(all(0.0) - v); };
  const std::uint16_t *const u = &Directions::kFirst[first], *const v = &Directions::kSecond[first];
  const Eight ux = Eight::picked(edges.x.data(), u), vx = Eight::picked(edges.x.data(), v);
  const Eight uy = Eight::picked(edges.y.data(), u), vy = Eight::picked(edges.y.data(), v);
  const Eight uz = Eight::picked(edges.z.data(), u), vz = Eight::picked(edges.z.data(), v);
  const Eight x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
  const auto along = [&](double a, double b, double c) {
    return size(x * all(a) + y * all(b) + z * all(c));
  };
  Eight sum = all(0.0) - along(across.x(), across.y(), across.z());
  for (std::size_t k = 0; k < 6; ++k) sum = sum + along(edges.x[k], edges.y[k], edges.z[k]);
  const Eight squared = x * x + y * y + z * z;
  const Eight whole = (ux * ux + uy * uy + uz * uz) * (vx * vx + vy * vy + vz * vz);
  const Eight inverse = all(1.0) / squared.root();
  const Eight depth = sum * inverse;
  const Eight cancelled = whole * (inverse * inverse);
  depth.store(overlap);
  (depth - all(kEpsilon * reach) * (all(8.0) + cancelled)).store(sure);
}

template <class Eight>
FastResult least_overlap(const Polyhedron& solid_p, const Polyhedron& solid_q, double rounding) {
  FastResult result;
  const Brick p(solid_p), q(solid_q);
  const Vector3 across = (solid_q.origin() - solid_p.origin()) + (q.middle - p.middle);
  const double reach = across.norm() + solid_p.diameter() + solid_q.diameter();
  const Directions edges(p, q);
  alignas(64) double overlap[16], sure[16];
  find_overlaps<Eight>(edges, 0, across, reach, overlap, sure);
  find_overlaps<Eight>(edges, 8, across, reach, overlap + 8, sure + 8);
  const double least = Eight::of(overlap).smaller(Eight::of(overlap + 8)).least();
  const auto bits = [&](const double* row, double limit) {
    const Eight beyond = Eight::all(limit);
    return (beyond.below(Eight::of(row)) | beyond.below(Eight::of(row + 8)) << 8) &
           Directions::kAll;
  };
  const unsigned best = ~bits(overlap, least) & Directions::kAll;
  const double error = 4 * (p.error + q.error), clear = 16 * rounding + error;
  if (!(least > clear) || !std::has_single_bit(best) ||
      (bits(sure, least + clear) | best) != Directions::kAll) {
    return result;
  }
  const auto lane = static_cast<std::size_t>(std::countr_zero(best));
  const std::size_t first = Directions::kFirst[lane], second = Directions::kSecond[lane];
  Vector3 normal = edges.edge(first).cross(edges.edge(second)).normalized();
  const double apart = normal.dot(across);
  if (!(2.0 * std::abs(apart) > clear)) return result;
  if (apart < 0.0) normal = -normal;
  // The facet of the set of differences that the two edges span: a corner, and one along each.
  const std::size_t place_p = p.support(normal), place_q = q.support(-normal);
  result.corners = 3;
  for (std::size_t k = 0; k < 3; ++k) {
    const unsigned edge = k == 0 ? 0u : 1u << (k == 1 ? first : second);
    result.p[k] = p.vertices[place_p ^ (edge & 7u)];
    result.q[k] = q.vertices[place_q ^ (edge >> 3)];
  }
  result.outcome = FastOutcome::Overlapping;
  result.normal = normal;
  result.bound = -(least + error);
  result.iterations = 1;
  return result;
}

#ifdef QUOIN_WIDE_LANES
QUOIN_AVX2 [[gnu::flatten]] FastResult overlap_256(const Polyhedron& p, const Polyhedron& q,
                                                   double rounding) {
  return least_overlap<Eight256>(p, q, rounding);
}
#endif

}  // namespace

FastResult brick_overlap(const Polyhedron& p, const Polyhedron& q, double rounding) {
#ifdef QUOIN_WIDE_LANES
  if (has_avx2()) return overlap_256(p, q, rounding);
#endif
  return least_overlap<PlainEight>(p, q, rounding);
}

}  // namespace quoin::geometry
