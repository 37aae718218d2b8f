#pragma once
/// A number as the unevaluated sum of two doubles: about 106 bits. Internal to the narrow phase: it
/// decides where doubles cannot. Sums and products of the error-free kind need round-to-nearest and
/// no contraction. A fused product gives the same bits and is used only where it is an instruction.
/// Sources: [Dekker 1971], [Knuth 1969] (two_sum), [Hida, Li, Bailey 2001] (the arithmetic).

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "numeric/floating_point.hpp"

namespace quoin::geometry {

struct DoubleDouble {
  double high = 0.0;
  double low = 0.0;
  DoubleDouble() = default;
  DoubleDouble(double value) : high(value) {}  // NOLINT: meant to convert
  DoubleDouble(double h, double l) : high(h), low(l) {}
  explicit operator double() const { return high + low; }
};

inline DoubleDouble quick_two_sum(double a, double b) {  // |a| >= |b|
  const double s = a + b;
  return {s, b - (s - a)};
}
inline DoubleDouble two_sum(double a, double b) {
  const double s = a + b;
  const double c = s - a;
  return {s, (a - (s - c)) + (b - c)};
}
inline DoubleDouble two_difference(double a, double b) { return two_sum(a, -b); }

inline void split(double a, double& high, double& low) {
  constexpr double kSplitter = 134217729.0;  // 2^27 + 1
  const double c = kSplitter * a;
  high = c - (c - a);
  low = a - high;
}
inline DoubleDouble two_product(double a, double b) {
  const double p = a * b;
  double ah, al, bh, bl;
  split(a, ah, al);
  split(b, bh, bl);
  return {p, ((ah * bh - p) + ah * bl + al * bh) + al * bl};
}

template <bool kFused>
DoubleDouble two_product(double a, double b) {
  if constexpr (!kFused) return two_product(a, b);
  const double p = a * b;
  return {p, std::fma(a, b, -p)};
}

inline DoubleDouble operator-(const DoubleDouble& a) { return {-a.high, -a.low}; }
inline DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
  DoubleDouble s = two_sum(a.high, b.high);
  const DoubleDouble t = two_sum(a.low, b.low);
  s = quick_two_sum(s.high, s.low + t.high);
  return quick_two_sum(s.high, s.low + t.low);
}
inline DoubleDouble operator-(const DoubleDouble& a, const DoubleDouble& b) { return a + (-b); }
inline DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble p = two_product(a.high, b.high);
  return quick_two_sum(p.high, p.low + (a.high * b.low + a.low * b.high));
}
inline DoubleDouble operator/(const DoubleDouble& a, const DoubleDouble& b) {
  const double q1 = a.high / b.high;
  DoubleDouble r = a - b * q1;
  const double q2 = r.high / b.high;
  r = r - b * q2;
  const double q3 = r.high / b.high;
  return quick_two_sum(q1, q2) + DoubleDouble(q3);
}
inline DoubleDouble square_root(const DoubleDouble& a) {
  if (!(a.high > 0.0)) return 0.0;
  const double x = std::sqrt(a.high);
  const DoubleDouble r = a - two_product(x, x);
  return quick_two_sum(x, r.high / (2.0 * x));
}
inline bool operator<(const DoubleDouble& a, const DoubleDouble& b) {
  return a.high < b.high || (a.high == b.high && a.low < b.low);
}
inline bool operator>(const DoubleDouble& a, const DoubleDouble& b) { return b < a; }
inline bool operator<=(const DoubleDouble& a, const DoubleDouble& b) { return !(b < a); }
inline bool operator>=(const DoubleDouble& a, const DoubleDouble& b) { return !(a < b); }

struct WideVector {
  DoubleDouble x, y, z;
  Eigen::Vector3d rounded() const { return {double(x), double(y), double(z)}; }
};
inline WideVector wide(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
/// Exactly p - q.
inline WideVector wide_difference(const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
  return {two_difference(p.x(), q.x()), two_difference(p.y(), q.y()), two_difference(p.z(), q.z())};
}
inline WideVector operator+(const WideVector& a, const WideVector& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline WideVector operator-(const WideVector& a, const WideVector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline WideVector operator-(const WideVector& a) { return {-a.x, -a.y, -a.z}; }
inline WideVector operator*(const WideVector& a, const DoubleDouble& s) {
  return {a.x * s, a.y * s, a.z * s};
}
inline DoubleDouble dot(const WideVector& a, const WideVector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline WideVector cross(const WideVector& a, const WideVector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

inline Eigen::Vector3d unit(const WideVector& v) {
  const DoubleDouble length = square_root(dot(v, v));
  return {double(v.x / length), double(v.y / length), double(v.z / length)};
}
/// Brings a direction to length about 1 by an exact power of two, so that nothing under- or
/// overflows.
inline WideVector scaled(const WideVector& v) {
  const double largest = std::max({std::abs(v.x.high), std::abs(v.y.high), std::abs(v.z.high)});
  if (!(largest > 0.0)) return v;
  const double factor = std::ldexp(1.0, -std::ilogb(largest));
  return v * DoubleDouble(factor);
}

}  // namespace quoin::geometry
