#pragma once
/// Vectors of three and unevaluated sums of two, one in each lane: operation by operation as
/// numeric/vec3.hpp and numeric/double_double.hpp, so that each lane has the bits of plain code.
/// Internal.

#include <array>

namespace quoin::geometry {
namespace {

template <class Lanes>
Lanes negated(const Lanes& a) {
  return Lanes::all(-0.0) - a;
}

template <class Lanes>
struct LaneVector {
  Lanes x, y, z;

  static LaneVector of(const std::array<const double*, 4>& places) {
    LaneVector v;
    const double* const place[4] = {places[0], places[1], places[2], places[3]};
    Lanes::turned(place, v.x, v.y, v.z);
    return v;
  }
  LaneVector operator+(const LaneVector& b) const { return {x + b.x, y + b.y, z + b.z}; }
  LaneVector operator-(const LaneVector& b) const { return {x - b.x, y - b.y, z - b.z}; }
  LaneVector operator-() const { return {negated(x), negated(y), negated(z)}; }
  LaneVector operator*(const Lanes& factor) const { return {factor * x, factor * y, factor * z}; }
  LaneVector operator/(const Lanes& divisor) const {
    return {x / divisor, y / divisor, z / divisor};
  }
  Lanes dot(const LaneVector& b) const { return x * b.x + y * b.y + z * b.z; }
  LaneVector cross(const LaneVector& b) const {
    return {y * b.z - z * b.y, z * b.x - x * b.z, x * b.y - y * b.x};
  }
  /// These where a flag is set, else the others.
  LaneVector where(const typename Lanes::Flags& flags, const LaneVector& other) const {
    return {x.where(flags, other.x), y.where(flags, other.y), z.where(flags, other.z)};
  }
  template <class Row>
  void store(Row (&rows)[3]) const {
    x.store(rows[0].of);
    y.store(rows[1].of);
    z.store(rows[2].of);
  }
};

template <class Lanes>
struct LaneSum {
  Lanes high, low;

  static LaneSum quick_two_sum(const Lanes& a, const Lanes& b) {
    const Lanes s = a + b;
    return {s, b - (s - a)};
  }
  static LaneSum two_sum(const Lanes& a, const Lanes& b) {
    const Lanes s = a + b, c = s - a;
    return {s, (a - (s - c)) + (b - c)};
  }
  static LaneSum difference(const Lanes& a, const Lanes& b) { return two_sum(a, negated(b)); }
  LaneSum operator+(const LaneSum& b) const {
    const LaneSum s = two_sum(high, b.high), t = two_sum(low, b.low);
    const LaneSum r = quick_two_sum(s.high, s.low + t.high);
    return quick_two_sum(r.high, r.low + t.low);
  }
  LaneSum operator*(const Lanes& b) const {
    const LaneSum p = product(high, b);
    return quick_two_sum(p.high, p.low + (high * Lanes::all(0.0) + low * b));
  }
  /// By halves: the same bits as a fused product.
  static LaneSum product(const Lanes& a, const Lanes& b) {
    const auto upper = [](const Lanes& x) {
      const Lanes c = Lanes::all(134217729.0) * x;  // 2^27 + 1
      return c - (c - x);
    };
    const Lanes p = a * b, a1 = upper(a), a2 = a - a1, b1 = upper(b), b2 = b - b1;
    return {p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2};
  }
  Lanes rounded() const { return high + low; }
};

}  // namespace
}  // namespace quoin::geometry
