#pragma once
/// The step of the search from one simplex to the next, without branches on values: they could not
/// be foreseen. Private to the room.

#include <array>
#include <bit>
#include <cstdint>
#include <quoin/geometry/types.hpp>

#include "wide_lanes.hpp"

#pragma GCC diagnostic ignored "-Wpsabi"  // all is built into the search, nothing is passed on

namespace quoin::geometry {

/// Four numbers side by side: the compiler makes of them what the machine has.
using Four = double __attribute__((vector_size(32)));
using FourFlags = long long __attribute__((vector_size(32)));  // 0 or -1

struct FourVectors {
  Four x, y, z;
};

/// The first three numbers moved on by one.
inline Four rotated(const Four& v) { return Four{v[1], v[2], v[0], v[0]}; }
inline FourVectors rotated(const FourVectors& v) {
  return {rotated(v.x), rotated(v.y), rotated(v.z)};
}
inline FourVectors cross(const FourVectors& a, const FourVectors& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Four dot(const FourVectors& a, const FourVectors& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

struct PlainFlags {
  static unsigned of_three(const FourFlags& flags) {
    return static_cast<unsigned>((flags[0] & 1) | (flags[1] & 2) | (flags[2] & 4));
  }
};
#ifdef QUOIN_WIDE_LANES
struct WideFlags {
  QUOIN_AVX2 static unsigned of_three(const FourFlags& flags) {
    return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(flags))) & 7u;
  }
};
#endif

inline FourVectors negated_where(const FourFlags& flags, const FourVectors& v) {
  return {flags ? -v.x : v.x, flags ? -v.y : v.y, flags ? -v.z : v.z};
}

/// What belongs to one of three triangles (choice 0 to 2), of three edges (3 to 5) or to the newest
/// corner.
inline double chosen(const Four& triangles, const Four& edges, double newest, std::size_t choice) {
  const std::array<double, 7> all{triangles[0], triangles[1], triangles[2], edges[0],
                                  edges[1],     edges[2],     newest};
  return all[choice];
}

/// Up to three corners that carried the nearest point, and the direction to that: any length.
struct SimplexRows {
  std::array<double, 4> x, y, z;
  std::array<int, 4> p, q;
  int count = 0;
  Vector3 direction;
  double squared_distance = 0.0;  // of the nearest point, m2

  void set(std::size_t k, const Vector3& w, int i, int j) {
    x[k] = w.x();
    y[k] = w.y();
    z[k] = w.z();
    p[k] = i;
    q[k] = j;
  }
  Vector3 w(std::size_t k) const { return {x[k], y[k], z[k]}; }
  bool has(int i, int j) const {
    bool known = false;
    for (std::size_t k = 0; k < 3; ++k) {
      known |= (static_cast<int>(k) < count) & (p[k] == i) & (q[k] == j);
    }
    return known;
  }
};

enum class Carried : std::uint8_t { Found, Inside, Unclear };

/// Takes up a corner that is nearer than all that the others span, and lets those go that no longer
/// carry the nearest point. With the new corner a, each other corner makes an edge, each two of
/// them a triangle. A triangle carries the point when the origin is beside it on its outer side and
/// over neither of its edges' outer sides, an edge when it is beyond it in both triangles, a when
/// it is before no edge. Not `Found`: nothing has changed.
template <class Flags>
Carried take_corner(const Vector3& corner, int i, int j, SimplexRows& rows) {
  struct Pick {
    std::uint8_t first, second, count;
  };
  static constexpr std::array<Pick, 7> kPicks{
      {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 0, 2}, {1, 1, 2}, {2, 2, 2}, {0, 0, 1}}};
  static constexpr std::array<std::uint8_t, 4> kEdges{0, 1, 3, 7}, kTriangles{0, 0, 1, 7};
  const Four zero{};
  const FourVectors a{zero + corner.x(), zero + corner.y(), zero + corner.z()};
  const FourVectors e{Four{rows.x[0], rows.x[1], rows.x[2], rows.x[0]} - a.x,
                      Four{rows.y[0], rows.y[1], rows.y[2], rows.y[0]} - a.y,
                      Four{rows.z[0], rows.z[1], rows.z[2], rows.z[0]} - a.z};
  const FourVectors f = rotated(e), normal = cross(e, f), moment = cross(a, e);
  const Four along = -dot(a, e), height = dot(normal, a), volume = dot(normal, rotated(f));
  const unsigned before = Flags::of_three(along > zero);
  const unsigned inside_e = Flags::of_three(dot(normal, moment) > zero);
  const unsigned inside_f = Flags::of_three(dot(normal, rotated(moment)) < zero);
  const unsigned inner =
      Flags::of_three(((height > zero) & (volume < zero)) | ((height < zero) & (volume > zero)));
  const auto others = static_cast<std::size_t>(rows.count);
  const unsigned edges_there = kEdges[others], triangles_there = kTriangles[others];
  const unsigned outer = others == 3 ? ~inner : ~0u;
  const unsigned beside_f = triangles_there & inside_f;
  const unsigned triangles = triangles_there & inside_e & inside_f & outer;
  const unsigned edges =
      edges_there & before & ~(triangles_there & inside_e) & ~(beside_f << 1 | beside_f >> 2);
  const unsigned vertex = (edges_there & before) == 0 ? 1 : 0;
  const unsigned carriers = triangles | edges << 3 | vertex << 6;
  if (carriers == 0) {
    return others == 3 && (outer & 7u) == 0 ? Carried::Inside : Carried::Unclear;
  }
  const auto choice = static_cast<std::size_t>(std::countr_zero(carriers));
  const FourVectors across = negated_where(height < zero, normal);
  const Four square = dot(e, e);
  const FourVectors upright{a.x * square + e.x * along, a.y * square + e.y * along,
                            a.z * square + e.z * along};
  rows.direction = Vector3(chosen(across.x, upright.x, corner.x(), choice),
                           chosen(across.y, upright.y, corner.y(), choice),
                           chosen(across.z, upright.z, corner.z(), choice));
  rows.squared_distance =
      chosen(height * height / dot(normal, normal), dot(upright, upright) / (square * square),
             corner.squaredNorm(), choice);
  const Pick pick = kPicks[choice];
  const auto renew = [&](auto& row, auto newest) {
    const auto first = row[pick.first], second = row[pick.second];
    row = {newest, first, second, newest};
  };
  renew(rows.x, corner.x());
  renew(rows.y, corner.y());
  renew(rows.z, corner.z());
  renew(rows.p, i);
  renew(rows.q, j);
  rows.count = pick.count;
  return Carried::Found;
}

}  // namespace quoin::geometry
