#pragma once
/// The step of the search from one simplex to the next, without branches on values: they could not
/// be foreseen. See kernels/kernels.hpp. Internal.

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <quoin/geometry/types.hpp>

#include "simd/four.hpp"

namespace quoin::geometry {
namespace {

/// What belongs to one of three triangles (choice 0 to 2), of three edges (4 to 6) or to the newest
/// corner (8).
inline double chosen(const Four& triangles, const Four& edges, const Four& newest,
                     std::size_t choice) {
  const Four all[3] = {triangles, edges, newest};  // NOLINT: std::array drops the alignment
  double value;
  std::memcpy(&value, reinterpret_cast<const char*>(&all) + choice * sizeof(double),
              sizeof(double));
  return value;
}

/// v, turned round where `sign` is negative.
inline FourVectors along_sign(const Four& sign, const FourVectors& v) {
  const FourFlags turn =
      reinterpret_cast<FourFlags>(sign) & reinterpret_cast<FourFlags>(four(-0.0));
  const auto turned = [&](const Four& x) {
    return reinterpret_cast<Four>(reinterpret_cast<FourFlags>(x) ^ turn);
  };
  return {turned(v.x), turned(v.y), turned(v.z)};
}

/// The direction to the nearest point, its length multiplied by `scale`; 0: any length, it is that
/// of a triangle's normal. Plain numbers, which stay in registers.
struct Direction {
  double x, y, z;
  double scale = 1.0;
};

/// A corner q_j - p_i in all lanes, and less what parts the origins of the rows, in which it is
/// known sooner; its name: j and i, as bits.
struct NewCorner {
  FourVectors w, offset;
  Four name;
};

/// Up to three corners that carry the nearest point, in the first three lanes. Where they are
/// fewer, corners stand twice.
struct SimplexReduction {
  FourVectors offset;  // the last lane: the newest corner
  Four names;
  unsigned edges = 1, triangles = 0;  // lanes that are corners of their own; these and the next one
};

/// As bits: not to be calculated with.
inline Four corner_name(int i, int j) {
  return four(std::bit_cast<double>(static_cast<long long>(j) << 32 | i));
}

inline bool has_corner(const SimplexReduction& rows, const Four& name) {
  return bits(reinterpret_cast<FourFlags>(rows.names) == reinterpret_cast<FourFlags>(name)) != 0;
}

enum class Carried : std::uint8_t { Found, Inside, Unclear };

inline void renew(const FourFlags& kept, const NewCorner& a, SimplexReduction& rows) {
  rows.offset = {either(kept, rows.offset.x, a.offset.x), either(kept, rows.offset.y, a.offset.y),
                 either(kept, rows.offset.z, a.offset.z)};
  rows.names = either(kept, rows.names, a.name);
}

/// Takes up a second corner: the step below for one edge, from which less has to be waited for.
inline void take_second_corner(const NewCorner& a, SimplexReduction& rows, Direction& towards) {
  const FourVectors e = rows.offset - a.offset;
  const Four along = -dot(a.w, e), square = dot(e, e);
  const FourFlags before = along > Four{};
  const FourVectors upright = a.w * square + e * along;
  towards = {either(before, upright.x, a.w.x)[0], either(before, upright.y, a.w.y)[0],
             either(before, upright.z, a.w.z)[0], either(before, square, four(1.0))[0]};
  renew(before & FourFlags{-1, 0, 0, 0}, a, rows);
  const unsigned lanes = bits(before);
  rows.edges = 1 | (lanes & 2);
  rows.triangles = lanes & 1;
}

/// Takes up a corner that is nearer than all that the others span, and lets those go that no longer
/// carry the nearest point. With the new corner a, each other corner makes an edge, each two of
/// them a triangle. A triangle carries the point when the origin is beside it on its outer side and
/// over neither of its edges' outer sides, an edge when it is beyond it in both triangles, a when
/// it is before no edge. `towards`: the nearest point. Not `Found`: nothing has changed.
inline Carried take_corner(const NewCorner& a, SimplexReduction& rows, Direction& towards) {
  struct Pick {
    FourFlags kept;
    unsigned edges, triangles;
  };
  static constexpr std::array<Pick, 9> kPicks{{{FourFlags{-1, -1, 0, 0}, 7, 7},
                                               {FourFlags{0, -1, -1, 0}, 7, 7},
                                               {FourFlags{-1, 0, -1, 0}, 7, 7},
                                               {},
                                               {FourFlags{-1, 0, 0, 0}, 3, 1},
                                               {FourFlags{0, -1, 0, 0}, 6, 2},
                                               {FourFlags{0, 0, -1, 0}, 5, 4},
                                               {},
                                               {FourFlags{0, 0, 0, 0}, 1, 0}}};
  const Four zero{};
  const FourVectors next = rotated(rows.offset);
  const FourVectors e = rows.offset - a.offset, f = next - a.offset, g = rotated(next) - a.offset;
  const FourVectors normal = cross(e, f);
  const Four along = -dot(a.w, e), height = dot(normal, a.w), volume = dot(normal, g);
  const unsigned before = bits(along > zero);
  const unsigned inside_e = bits(dot(normal, cross(a.w, e)) > zero);
  const unsigned inside_f = bits(dot(normal, cross(a.w, f)) < zero);
  const unsigned inner = bits(height * volume < zero);
  const auto whole = static_cast<unsigned>(rows.triangles == 7);
  const unsigned outer = ~(inner & (0u - whole));
  const unsigned beside_e = rows.triangles & inside_e, beside_f = rows.triangles & inside_f;
  const unsigned triangles = beside_e & beside_f & outer;
  const unsigned edges = rows.edges & before & ~beside_e & ~(beside_f << 1 | beside_f >> 2);
  const auto vertex = static_cast<unsigned>((rows.edges & before) == 0);
  const unsigned carriers = triangles | edges << 4 | vertex << 8;
  if (carriers == 0)
    return rows.triangles == 7 && (outer & 7u) == 0 ? Carried::Inside : Carried::Unclear;
  const auto choice = static_cast<std::size_t>(std::countr_zero(carriers));
  const FourVectors across = along_sign(height, normal);
  const Four square = dot(e, e);
  const FourVectors upright = a.w * square + e * along;
  const Pick& pick = kPicks[choice];
  renew(pick.kept, a, rows);
  rows.edges = pick.edges;
  rows.triangles = pick.triangles;
  towards = {chosen(across.x, upright.x, a.w.x, choice), chosen(across.y, upright.y, a.w.y, choice),
             chosen(across.z, upright.z, a.w.z, choice), chosen(zero, square, four(1.0), choice)};
  return Carried::Found;
}

}  // namespace
}  // namespace quoin::geometry
