#pragma once
/// The 15 directions of box_sat, as a kernel. See kernels/kernels.hpp. Internal.

#include "search/nearest_feature_search.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "numeric/error_bounds.hpp"
#include "shape/scan.hpp"

namespace quoin::geometry {
namespace {

/// A parallelepiped: half its edges from vertex 0, its middle, and how far the vertices of the
/// solid lie from those of it, m.
struct Brick {
  std::span<const int> vertices;
  std::array<Vector3, 3> half;
  Vector3 middle;
  double uneven = 0.0, error = 0.0;  // as measured; with the rounding of the corners
  bool even = false;                 // opposite faces are parallel, as far as coordinates can tell

  explicit Brick(const Solid& solid) : vertices(solid.topology().brick()) {
    const Rows rows(solid);
    const auto at = [&](std::size_t place) { return Vector3(rows.placed(vertices[place])); };
    const Vector3 base = at(0);
    middle = base;
    for (std::size_t k = 0; k < 3; ++k) {
      half[k] = 0.5 * (at(std::size_t{1} << k) - base);
      middle += half[k];
    }
    double squared = 0.0;
    for (const unsigned place : {3u, 5u, 6u, 7u})
      squared = std::max(squared, (at(place) - corner(place)).squaredNorm());
    uneven = std::sqrt(squared);
    error = uneven + kBrickRounding * kEpsilon * solid.diameter();
    const double coordinate = std::max(solid.diameter(), solid.largest_coordinate());
    even = uneven <= kBrickRounding * kEpsilon * coordinate;
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
  FourVectors picked(const std::uint16_t* k) const {
    return {Four{x[k[0]], x[k[1]], x[k[2]], x[k[3]]}, Four{y[k[0]], y[k[1]], y[k[2]], y[k[3]]},
            Four{z[k[0]], z[k[1]], z[k[2]], z[k[3]]}};
  }
};

/// How far the bricks overlap along each of the directions, and at least so far, m. Edges that are
/// parallel span none: infinite, and at least nothing.
struct Overlaps {
  alignas(64) double value[16], sure[16];
  alignas(64) double skew[16];  // of the two edges: the inverse square of the sine between them
};

/// Four of them.
inline void find_overlaps(const Directions& edges, std::size_t first, const Vector3& across,
                          double reach, Overlaps& overlaps) {
  constexpr double kParallel = 1.0 / kParallelSine;
  const auto size = [](const Four& v) { return larger(v, -v); };
  const std::uint16_t *const u = &Directions::kFirst[first], *const v = &Directions::kSecond[first];
  const FourVectors a = edges.picked(u), b = edges.picked(v), normal = cross(a, b);
  const auto along = [&](double x, double y, double z) {
    return size(dot(normal, {four(x), four(y), four(z)}));
  };
  Four sum = -along(across.x(), across.y(), across.z());
  for (std::size_t k = 0; k < 6; ++k) sum = sum + along(edges.x[k], edges.y[k], edges.z[k]);
  const Four inverse = four(1.0) / root(dot(normal, normal));
  const Four depth = sum * inverse;
  const Four cancelled = dot(a, a) * dot(b, b) * (inverse * inverse);
  const FourFlags there = cancelled < four(kParallel * kParallel);
  store(either(there, depth, four(kInfinity)), overlaps.value + first);
  const Four sure = depth - four(kEpsilon * reach) * (four(kDirectionRounding) + cancelled);
  store(either(there, sure, four(-kInfinity)), overlaps.sure + first);
  store(cancelled, overlaps.skew + first);
}

/// Across the two edges of a direction, towards Q; any length.
Vector3 plane_normal(const Directions& edges, std::size_t lane, const Vector3& across) {
  const Vector3 normal =
      edges.edge(Directions::kFirst[lane]).cross(edges.edge(Directions::kSecond[lane]));
  return normal.dot(across) < 0.0 ? Vector3(-normal) : normal;
}

/// The direction of the face that parts the bricks most.
Vector3 facing_direction(const Directions& edges, const Overlaps& overlaps, const Vector3& across) {
  constexpr std::size_t kFaces = 6;
  std::size_t lane = 0;
  for (std::size_t k = 1; k < kFaces; ++k)
    lane = overlaps.value[k] < overlaps.value[lane] ? k : lane;
  return plane_normal(edges, lane, across).normalized();
}

/// The mean of some planes, those within 1e-6 rad once; Unclear where there is but one.
SearchResult mean_of_planes(const Directions& edges, unsigned lanes, const Vector3& across,
                            SearchResult result) {
  std::array<Vector3, 15> normals;
  std::size_t count = 0;
  for (; lanes != 0; lanes &= lanes - 1) {
    const Vector3 normal =
        plane_normal(edges, static_cast<std::size_t>(std::countr_zero(lanes)), across);
    const auto same = [&](const Vector3& n) {
      return n.cross(normal).squaredNorm() < kOneDirection * n.squaredNorm() * normal.squaredNorm();
    };
    if (std::none_of(normals.begin(), normals.begin() + count, same)) normals[count++] = normal;
  }
  result.iterations = 1;
  if (count < 2) return result;
  Vector3 sum = Vector3::Zero();
  for (std::size_t k = 0; k < count; ++k) sum += normals[k].normalized();
  result.normal = sum.normalized();
  result.outcome = SearchOutcome::Touching;
  return result;
}

/// Two bricks and what is known of the 15 directions.
struct BrickPair {
  const Brick &p, &q;
  const Directions& edges;
  const Overlaps& overlaps;
  Vector3 across;  // from one middle to the other, m
  double rounding, least;
};

/// Directions of which a number is below a limit; beyond it.
inline unsigned below(const double* row, double limit) {
  unsigned all = 0;
  for (int k = 0; k < 16; k += 4) all |= bits(load(row + k) < four(limit)) << k;
  return all & Directions::kAll;
}
inline unsigned beyond(const double* row, double limit) {
  unsigned all = 0;
  for (int k = 0; k < 16; k += 4) all |= bits(load(row + k) > four(limit)) << k;
  return all & Directions::kAll;
}

/// Bricks that no direction parts by more than rounding, nor shows to overlap by more.
inline SearchResult touching_planes(const BrickPair& pair) {
  const SearchResult unclear;
  constexpr double kClose = 16.0;  // inverse sine of edges that are all but parallel
  const auto& [p, q, edges, overlaps, across, rounding, least] = pair;
  const unsigned parallel = beyond(overlaps.value, std::numeric_limits<double>::max());
  const unsigned open = ~beyond(overlaps.sure, kBothPart * rounding) & ~parallel & Directions::kAll;
  const unsigned close = ~below(overlaps.skew, kClose * kClose) & Directions::kAll;
  if ((open & close) != 0) return unclear;
  // Several planes, and so on any other way, which may measure them otherwise.
  const double unsure = kTieBand * rounding + p.uneven + q.uneven;
  if (std::abs(least) > rounding - unsure) return unclear;
  const unsigned sure = ~beyond(overlaps.value, kBothPart * rounding - unsure) & Directions::kAll;
  const unsigned tied = ~beyond(overlaps.value, kBothPart * rounding) & Directions::kAll;
  const SearchResult mean = mean_of_planes(edges, tied, across, unclear);
  const bool certain = sure == tied || mean_of_planes(edges, sure, across, unclear).outcome ==
                                           SearchOutcome::Touching;
  return certain ? mean : unclear;
}

/// Bricks that overlap less in one direction than in all others, beyond doubt.
inline SearchResult clear_overlap(const BrickPair& pair) {
  SearchResult result;
  const auto& [p, q, edges, overlaps, across, rounding, least] = pair;
  const unsigned best = ~beyond(overlaps.value, least) & Directions::kAll;
  const double error = kBrickErrors * (p.error + q.error), clear = kBrickClear * rounding + error;
  if (!(least > clear) || !std::has_single_bit(best) ||
      (beyond(overlaps.sure, least + clear) | best) != Directions::kAll)
    return result;
  const auto lane = static_cast<std::size_t>(std::countr_zero(best));
  const std::size_t first = Directions::kFirst[lane], second = Directions::kSecond[lane];
  const Vector3 normal = plane_normal(edges, lane, across).normalized();
  if (!(2.0 * normal.dot(across) > clear)) return result;
  // The facet of the set of differences that the two edges span: a corner, and one along each.
  const std::size_t place_p = p.support(normal), place_q = q.support(-normal);
  result.corners = 3;
  for (std::size_t k = 0; k < 3; ++k) {
    const unsigned edge = k == 0 ? 0u : 1u << (k == 1 ? first : second);
    result.p[k] = p.vertices[place_p ^ (edge & 7u)];
    result.q[k] = q.vertices[place_q ^ (edge >> 3)];
  }
  result.outcome = SearchOutcome::Overlapping;
  result.normal = normal;
  result.bound = -(least + error);
  result.iterations = 1;
  return result;
}

inline SearchResult least_overlap(const Solid& solid_p, const Solid& solid_q, double rounding) {
  const Brick p(solid_p), q(solid_q);
  const Vector3 across = (solid_q.origin() - solid_p.origin()) + (q.middle - p.middle);
  const double reach = across.norm() + solid_p.diameter() + solid_q.diameter();
  const Directions edges(p, q);
  Overlaps overlaps;
  Four least_four = four(kInfinity);
  for (std::size_t k = 0; k < 16; k += 4) {
    find_overlaps(edges, k, across, reach, overlaps);
    least_four = smaller(least_four, load(overlaps.value + k));
  }
  const BrickPair pair{p, q, edges, overlaps, across, rounding, geometry::least(least_four)};
  const bool touching = std::abs(pair.least) <= rounding;
  SearchResult result = touching ? touching_planes(pair) : clear_overlap(pair);
  if (result.outcome == SearchOutcome::Unclear) {
    const bool even = p.even && q.even;
    result.normal = even ? facing_direction(edges, overlaps, across) : Vector3(Vector3::Zero());
  }
  return result;
}

}  // namespace
}  // namespace quoin::geometry
