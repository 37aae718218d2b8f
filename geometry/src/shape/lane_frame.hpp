#pragma once
/// Placements of four bodies, one in each lane: operation by operation as Body and Solid. See
/// kernels/kernels.hpp. Internal.

#include <array>

#include "simd/lane_vector.hpp"

namespace quoin::geometry {

/// Where four bodies have a vector: pointers to three doubles each.
using LanePlace = std::array<const double*, 4>;

/// What the way from one centre to the other is made of.
struct LaneCentres {
  LanePlace translation, turned, rest;  ///< of the placement; Body::turned_origin(), its rest
};

namespace {

/// A placement: directions and offsets of the shape's frame in the world, and back.
template <class Lanes>
struct LaneFrame {
  using Vector = LaneVector<Lanes>;
  using Flags = typename Lanes::Flags;
  Vector columns[3], cofactors[3];
  Flags turned;
  bool any_turned;

  /// `turned_bodies`: which are, one bit each; columns of both matrices.
  LaneFrame(unsigned turned_bodies, const std::array<LanePlace, 3>& linear,
            const std::array<LanePlace, 3>& cofactor)
      : turned(Lanes::flags(turned_bodies)), any_turned(turned_bodies != 0) {
    if (!any_turned) return;
    for (std::size_t k = 0; k < 3; ++k) {
      columns[k] = Vector::of(linear[k]);
      cofactors[k] = Vector::of(cofactor[k]);
    }
  }
  static Vector product(const Vector (&c)[3], const Vector& v) {
    return {c[0].x * v.x + c[1].x * v.y + c[2].x * v.z, c[0].y * v.x + c[1].y * v.y + c[2].y * v.z,
            c[0].z * v.x + c[1].z * v.y + c[2].z * v.z};
  }
  Vector turn(const Vector& offset) const {
    return any_turned ? product(columns, offset).where(turned, offset) : offset;
  }
  Vector turned_back(const Vector& d) const {
    if (!any_turned) return d;
    return Vector{columns[0].dot(d), columns[1].dot(d), columns[2].dot(d)}.where(turned, d);
  }
  /// Of a rotation, as Solid::face_normal.
  Vector normal(const Vector& own) const {
    if (!any_turned) return own;
    const Vector normal = product(cofactors, own);
    const Lanes scale = Lanes::all(1.5) - Lanes::all(0.5) * normal.dot(normal);
    return (normal * scale).where(turned, own);
  }
};

/// As apart().
template <class Lanes>
LaneVector<Lanes> lanes_apart(const LaneCentres& from, const LaneCentres& to) {
  using Vector = LaneVector<Lanes>;
  using Sum = LaneSum<Lanes>;
  struct Way {
    Sum x, y, z;
    Way(const LanePlace& start, const LanePlace& end) {
      const Vector a = Vector::of(start), b = Vector::of(end);
      x = Sum::difference(b.x, a.x);
      y = Sum::difference(b.y, a.y);
      z = Sum::difference(b.z, a.z);
    }
  };
  const Way way(from.translation, to.translation), origins(from.turned, to.turned),
      rests(from.rest, to.rest);
  return {(way.x + (origins.x + rests.x)).rounded(), (way.y + (origins.y + rests.y)).rounded(),
          (way.z + (origins.z + rests.z)).rounded()};
}

}  // namespace
}  // namespace quoin::geometry
