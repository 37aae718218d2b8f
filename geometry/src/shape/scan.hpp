#pragma once
/// The scans behind support.hpp in plain code, to be built into the kernels. See
/// kernels/kernels.hpp. Internal.

#include <algorithm>

#include "numeric/vec3.hpp"
#include "shape/support.hpp"

namespace quoin::geometry {
namespace {

/// Rows of a shape's offsets. The scans take directions in the shape's frame: `local` turns them.
struct Rows {
  const double *x, *y, *z;
  int padded;
  int count;
  const Solid* solid;
  explicit Rows(const Solid&& of) = delete;
  explicit Rows(const Solid& of)
      : x(of.shape().offsets()),
        y(x + of.padded_count()),
        z(y + of.padded_count()),
        padded(of.padded_count()),
        count(of.vertex_count()),
        solid(&of) {}
  Vec3 local(const Vec3& direction) const { return solid->turned_back(direction); }
  Vec3 offset(int v) const { return {x[v], y[v], z[v]}; }
  Vec3 placed(int v) const { return solid->turn(offset(v)); }  ///< the same turned as the body is
  double along(int v, const Vec3& d) const { return dot(offset(v), d); }
};

/// Rows of a body that is not turned, for loops where asking each time would cost.
struct StraightRows : Rows {
  using Rows::Rows;
  static Vec3 local(const Vec3& direction) { return direction; }
  Vec3 placed(int v) const { return offset(v); }
};

inline Support narrow_support(const Rows& rows, const Vec3& d) {
  Support best{0, rows.along(0, d)};
  for (int v = 1; v < rows.padded; ++v) {
    const double value = rows.along(v, d);
    if (value > best.value) best = {v, value};
  }
  best.value += 0.0;  // one zero only: -0 would tell the variants apart
  return best;
}

inline void narrow_beyond(const Rows& rows, const Vec3& d, double value, VertexSet& vertices) {
  for (int v = 0; v < rows.count; ++v)
    if (rows.along(v, d) >= value) vertices.push_back(v);
}

inline int narrow_count(const Rows& rows, const Vec3& d, double value) {
  int count = 0;
  for (int v = 0; v < rows.count; ++v) count += rows.along(v, d) >= value ? 1 : 0;
  return count;
}

/// So few that scans of 256 bits are worth more: beside instructions of 512 bits the machine has
/// fewer units for all the others.
inline bool few_vertices(const Solid& p, const Solid& q) {
  return std::max(p.padded_count(), q.padded_count()) <= 32;
}

/// The scans of one kind of instructions under one name each. Directions are those of the shape's
/// frame, of a pair those of the world.
struct PlainScan {
  static constexpr bool kFused = false;
  static Support support(const Rows& rows, const Vec3& d) { return narrow_support(rows, d); }
  static void beyond(const Rows& rows, const Vec3& d, double value, VertexSet& vertices) {
    narrow_beyond(rows, d, value, vertices);
  }
  template <class AnyRows>
  static PairSupport support_pair(const AnyRows& p, const AnyRows& q, const Vec3& d) {
    return {narrow_support(p, p.local(d)), narrow_support(q, q.local(-d))};
  }
  static int count_beyond(const Rows& rows, const Vec3& d, double value) {
    return narrow_count(rows, d, value);
  }
  static bool carried_alone(const Rows& rows, const Vec3& d, const Carriers& carriers,
                            Support& top) {
    top = narrow_support(rows, d);
    const auto only = [&](double value) {
      int within = 0;
      for (const int v : carriers.set) within += rows.along(v, d) >= value;
      return within == std::ssize(carriers.set) && narrow_count(rows, d, value) == within;
    };
    return only(top.value - carriers.flat) && only(top.value - carriers.clear);
  }
};

}  // namespace
}  // namespace quoin::geometry
