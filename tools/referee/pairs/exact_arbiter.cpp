#include "referee/pairs/exact_arbiter.hpp"

#include <gmpxx.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <type_traits>
#include <vector>

namespace quoin::referee {
namespace {

using geometry::Placement;
using geometry::Points;
using geometry::Vector3;
using Real = long double;
using Whole = mpz_class;

template <class T>
using Triple = std::array<T, 3>;

template <class T>
T dot(const Triple<T>& u, const Triple<T>& v) {
  return T(u[0] * v[0] + u[1] * v[1] + u[2] * v[2]);
}

template <class T>
Triple<T> operator-(const Triple<T>& u, const Triple<T>& v) {
  return {T(u[0] - v[0]), T(u[1] - v[1]), T(u[2] - v[2])};
}

template <class T>
Triple<T> cross(const Triple<T>& u, const Triple<T>& v) {
  return {T(u[1] * v[2] - u[2] * v[1]), T(u[2] * v[0] - u[0] * v[2]), T(u[0] * v[1] - u[1] * v[0])};
}

// The same in whole numbers, without temporary ones.

template <>
Whole dot(const Triple<Whole>& u, const Triple<Whole>& v) {
  Whole sum(u[0] * v[0]);
  mpz_addmul(sum.get_mpz_t(), u[1].get_mpz_t(), v[1].get_mpz_t());
  mpz_addmul(sum.get_mpz_t(), u[2].get_mpz_t(), v[2].get_mpz_t());
  return sum;
}

template <>
Triple<Whole> cross(const Triple<Whole>& u, const Triple<Whole>& v) {
  Triple<Whole> product;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
    mpz_mul(product[k].get_mpz_t(), u[i].get_mpz_t(), v[j].get_mpz_t());
    mpz_submul(product[k].get_mpz_t(), u[j].get_mpz_t(), v[i].get_mpz_t());
  }
  return product;
}

Real length(const Triple<Real>& u) { return std::sqrt(dot(u, u)); }

/// The leading 53 bits of a number times 2^exponent, and what they leave of it.
struct Leading {
  Real value = 0;
  Whole rest;
};

Leading leading(const Whole& number, long exponent) {
  long e = 0;
  const double high = mpz_get_d_2exp(&e, number.get_mpz_t());
  Whole whole(std::ldexp(high, 53));
  if (e >= 53)
    whole <<= static_cast<mp_bitcnt_t>(e - 53);
  else
    whole >>= static_cast<mp_bitcnt_t>(53 - e);
  return {std::ldexp(Real(high), static_cast<int>(e + exponent)), number - whole};
}

/// The leading 128 bits of a number times 2^exponent, rounded.
Real rounded(const Whole& number, long exponent) {
  static_assert(GMP_NUMB_BITS == 64);
  const std::size_t size = mpz_size(number.get_mpz_t());
  if (size == 0) return 0;
  const auto limb = [&](std::size_t below) -> std::uint64_t {
    return below < size ? mpz_getlimbn(number.get_mpz_t(), static_cast<mp_size_t>(size - 1 - below))
                        : 0;
  };
  const int shift = std::countl_zero(limb(0));
  const auto bits = [&](std::size_t k) {
    return shift == 0 ? limb(k) : limb(k) << shift | limb(k + 1) >> (64 - shift);
  };
  const Real leading = Real(bits(0)) * 0x1p64L + Real(bits(1));
  const long last = 64 * (static_cast<long>(size) - 2) - shift + exponent;
  return std::ldexp(Real(sgn(number)) * leading, static_cast<int>(last));
}

/// Both point sets twice: as whole multiples of 2^exponent and rounded to long double, both
/// relative to the first point of A.
struct Pair {
  long exponent = 0;
  std::vector<Triple<Whole>> whole[2];
  std::vector<Triple<Real>> real[2];
  Real size = 0;  // largest coordinate in `real`, m
};

/// The exponent of the last bit of a double.
long last_exponent(double value) { return static_cast<long>(std::ilogb(value)) - 52; }

/// No smaller than the exponent of the last bit of any of the numbers; `lowest` where all are zero.
template <class Values>
long lowest_exponent(const Values& values, long lowest) {
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const double value = values.data()[i];
    if (!std::isfinite(value)) throw std::invalid_argument("exact_gap: a coordinate is not finite");
    if (value != 0.0) lowest = std::min(lowest, last_exponent(value));
  }
  return lowest;
}

Whole whole_number(double value, long exponent) {
  if (value == 0.0) return 0;
  const long e = last_exponent(value);
  Whole number(std::scalbn(value, static_cast<int>(-e)));
  return Whole(number << static_cast<mp_bitcnt_t>(e - exponent));
}

constexpr long kNoBits = 1000;  // above the exponent of the last bit of any sensible double

bool stands_in_own_frame(const Placement& placement) {
  return placement.linear == geometry::Matrix3::Identity() &&
         placement.translation == Vector3::Zero();
}

/// Exponent of the last bit of any product A X, and of t.
long lowest_exponent(const PlacedPoints& solid, long lowest) {
  const long points = lowest_exponent(solid.points, kNoBits);
  if (stands_in_own_frame(solid.placement)) return std::min(lowest, points);
  const long linear = lowest_exponent(solid.placement.linear, kNoBits);
  return lowest_exponent(solid.placement.translation, std::min(lowest, points + linear));
}

/// The points t + A X, exactly, as multiples of 2^exponent.
std::vector<Triple<Whole>> whole_points(const PlacedPoints& solid, long exponent) {
  const bool own_frame = stands_in_own_frame(solid.placement);
  const long inner = own_frame ? exponent : lowest_exponent(solid.points, kNoBits);
  std::vector<Triple<Whole>> list(static_cast<std::size_t>(solid.points.cols()));
  for (std::size_t i = 0; i < list.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      list[i][k] = whole_number(
          solid.points(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(i)), inner);
    }
  }
  if (own_frame) return list;
  Triple<Whole> rows[3], t;
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Index row = static_cast<Eigen::Index>(k);
    t[k] = whole_number(solid.placement.translation[row], exponent);
    for (std::size_t m = 0; m < 3; ++m) {
      rows[k][m] =
          whole_number(solid.placement.linear(row, static_cast<Eigen::Index>(m)), exponent - inner);
    }
  }
  for (Triple<Whole>& x : list)
    x = {t[0] + dot(rows[0], x), t[1] + dot(rows[1], x), t[2] + dot(rows[2], x)};
  return list;
}

/// Both relative to `origin`, and rounded.
void add_real(Pair& pair, const Triple<Whole>& origin) {
  for (int side = 0; side < 2; ++side) {
    pair.real[side].reserve(pair.whole[side].size());
    for (Triple<Whole>& w : pair.whole[side]) {
      Triple<Real> r;
      for (std::size_t k = 0; k < 3; ++k) {
        w[k] -= origin[k];
        r[k] = rounded(w[k], pair.exponent);
        pair.size = std::max(pair.size, std::abs(r[k]));
      }
      pair.real[side].push_back(r);
    }
  }
}

Pair make_pair(const PlacedPoints& a, const PlacedPoints& b) {
  Pair pair;
  pair.exponent = lowest_exponent(b, lowest_exponent(a, kNoBits));
  pair.whole[0] = whole_points(a, pair.exponent);
  pair.whole[1] = whole_points(b, pair.exponent);
  const Triple<Whole> origin = pair.whole[0].front();
  add_real(pair, origin);
  return pair;
}

template <class T>
const std::vector<Triple<T>>& points_of(const Pair& pair, int side) {
  if constexpr (std::is_same_v<T, Whole>)
    return pair.whole[side];
  else
    return pair.real[side];
}

/// A point of the difference B - A, by its two vertices.
struct Corner {
  int a = 0;
  int b = 0;
  bool operator==(const Corner&) const = default;
};

template <class T>
Triple<T> place(const Pair& pair, const Corner& corner) {
  return points_of<T>(pair, 1)[static_cast<std::size_t>(corner.b)] -
         points_of<T>(pair, 0)[static_cast<std::size_t>(corner.a)];
}

/// At most four.
template <class T>
class Few {
 public:
  Few() = default;
  explicit Few(const T& first) { push_back(first); }
  void push_back(const T& item) { items_[size_++] = item; }
  std::size_t size() const { return size_; }
  const T& operator[](std::size_t i) const { return items_[i]; }
  const T* begin() const { return items_.data(); }
  const T* end() const { return items_.data() + size_; }

 private:
  std::array<T, 4> items_{};
  std::size_t size_ = 0;
};

/// A point x = numerator / denominator of the hull of some corners.
template <class T>
struct Foot {
  Triple<T> numerator{};
  T denominator{1};
  Few<Corner> corners;
  bool valid = false;
};

/// Weights of the point of the affine hull nearest to the origin (Cramer's rule, no division).
/// False when the points are affinely dependent.
template <class T>
bool affine_weights(const Few<Triple<T>>& p, std::array<T, 4>& weights, T& sum) {
  if (p.size() == 1) {
    weights[0] = 1;
    sum = 1;
    return true;
  }
  const Triple<T> e1 = p[1] - p[0];
  if (p.size() == 2) {
    sum = dot(e1, e1);
    weights[1] = -dot(p[0], e1);
    weights[0] = sum - weights[1];
    return sum != 0;
  }
  const Triple<T> e2 = p[2] - p[0];
  if (p.size() == 3) {
    const T g11 = dot(e1, e1), g12 = dot(e1, e2), g22 = dot(e2, e2);
    const T r1 = -dot(p[0], e1), r2 = -dot(p[0], e2);
    sum = g11 * g22 - g12 * g12;
    weights[1] = r1 * g22 - r2 * g12;
    weights[2] = r2 * g11 - r1 * g12;
    weights[0] = sum - weights[1] - weights[2];
    return sum != 0;
  }
  const Triple<T> e3 = p[3] - p[0];
  const Triple<T> zero{};
  const Triple<T> r = zero - p[0];
  sum = dot(e1, cross(e2, e3));
  weights[1] = dot(r, cross(e2, e3));
  weights[2] = dot(e1, cross(r, e3));
  weights[3] = dot(e1, cross(e2, r));
  weights[0] = sum - weights[1] - weights[2] - weights[3];
  if (sum < 0) {
    sum = -sum;
    for (T& weight : weights) weight = -weight;
  }
  return sum != 0;
}

template <class T>
Foot<T> foot_of(const Pair& pair, const Few<Corner>& corners) {
  Foot<T> foot;
  foot.corners = corners;
  Few<Triple<T>> p;
  for (const Corner& corner : corners) p.push_back(place<T>(pair, corner));
  std::array<T, 4> weights{};
  if (!affine_weights(p, weights, foot.denominator)) return foot;
  foot.valid = true;
  foot.numerator = Triple<T>{};
  for (std::size_t i = 0; i < p.size(); ++i) {
    foot.valid = foot.valid && weights[i] > 0;
    for (std::size_t k = 0; k < 3; ++k) foot.numerator[k] += weights[i] * p[i][k];
  }
  if (p.size() == 4) foot.numerator = Triple<T>{};  // the affine hull is all space
  return foot;
}

/// |u|^2 < |v|^2
template <class T>
bool nearer(const Foot<T>& u, const Foot<T>& v) {
  return dot(u.numerator, u.numerator) * v.denominator * v.denominator <
         dot(v.numerator, v.numerator) * u.denominator * u.denominator;
}

/// The point of the hull of at most four corners that is nearest to the origin: the nearest of the
/// feet of all subsets that lie inside their subset.
template <class T>
Foot<T> nearest_of(const Pair& pair, const Few<Corner>& corners) {
  Foot<T> best;
  for (unsigned subset = 1; subset < (1u << corners.size()); ++subset) {
    Few<Corner> chosen;
    for (std::size_t i = 0; i < corners.size(); ++i)
      if ((subset >> i & 1u) != 0) chosen.push_back(corners[i]);
    Foot<T> foot = foot_of<T>(pair, chosen);
    if (foot.valid && (!best.valid || nearer(foot, best))) best = std::move(foot);
  }
  return best;
}

Triple<Real> direction_of(const Triple<Whole>& v) {
  long top = 0;
  for (const Whole& c : v) top = std::max(top, static_cast<long>(mpz_sizeinbase(c.get_mpz_t(), 2)));
  return {rounded(v[0], -top), rounded(v[1], -top), rounded(v[2], -top)};
}
Triple<Real> direction_of(const Triple<Real>& v) { return v; }

/// Index of the point farthest along sign·direction: those that long double cannot tell from the
/// farthest are compared exactly.
template <class T>
int farthest(const Pair& pair, int side, const Triple<T>& direction, int sign) {
  const Triple<Real> d = direction_of(direction);
  const std::vector<Triple<Real>>& real = pair.real[side];
  std::vector<Real> heights(real.size());
  std::size_t best = 0;
  for (std::size_t i = 0; i < real.size(); ++i) {
    heights[i] = Real(sign) * dot(d, real[i]);
    best = heights[i] > heights[best] ? i : best;
  }
  if constexpr (std::is_same_v<T, Whole>) {
    const Real margin = 0x1p-58L * length(d) * pair.size;
    const Real limit = heights[best] - margin;
    Whole top = sign * dot(direction, pair.whole[side][best]);
    for (std::size_t i = 0; i < real.size(); ++i) {
      if (heights[i] >= limit && i != best) {
        const Whole height = sign * dot(direction, pair.whole[side][i]);
        if (height > top) {
          top = height;
          best = i;
        }
      }
    }
  }
  return static_cast<int>(best);
}

/// The nearest point of B - A to the origin, from a start. In whole numbers each turn comes
/// strictly nearer and the feet are finitely many, so it ends, at the exact answer.
template <class T>
Foot<T> nearest_point(const Pair& pair, const Few<Corner>& start, int limit, int& turns) {
  Foot<T> foot = nearest_of<T>(pair, start);
  for (turns = 0; turns < limit; ++turns) {
    if (foot.corners.size() == 4 || dot(foot.numerator, foot.numerator) == 0) return foot;
    const Corner corner{farthest(pair, 0, foot.numerator, 1),
                        farthest(pair, 1, foot.numerator, -1)};
    const T reached = dot(foot.numerator, place<T>(pair, corner)) * foot.denominator;
    if (reached >= dot(foot.numerator, foot.numerator) ||
        std::find(foot.corners.begin(), foot.corners.end(), corner) != foot.corners.end())
      return foot;
    Few<Corner> corners = foot.corners;
    corners.push_back(corner);
    Foot<T> next = nearest_of<T>(pair, corners);
    if (!next.valid || !nearer(next, foot)) {
      if constexpr (std::is_same_v<T, Whole>)
        throw std::logic_error("exact_gap: a turn in exact arithmetic came no nearer");
      return foot;  // rounding: long double can do no better
    }
    foot = std::move(next);
  }
  return foot;
}

/// Takes the leading 53 bits off `value` and returns them times 2^exponent.
Real take_leading(mpf_class& value, long exponent) {
  long e = 0;
  const double leading = mpf_get_d_2exp(&e, value.get_mpf_t());
  mpf_class taken(leading, value.get_prec());
  if (e >= 0)
    taken <<= static_cast<mp_bitcnt_t>(e);
  else
    taken >>= static_cast<mp_bitcnt_t>(-e);
  value -= taken;
  return std::ldexp(Real(leading), static_cast<int>(e + exponent));
}

Real root_of_quotient(const Whole& squared, const Whole& denominator, long exponent) {
  mpf_class value(squared, 256);
  value = sqrt(value);
  value /= mpf_class(denominator, 256);
  const Real high = take_leading(value, exponent);
  return high + take_leading(value, exponent);
}

Vector3 unit(const Triple<Real>& v) {
  const Real norm = length(v);
  return {static_cast<double>(v[0] / norm), static_cast<double>(v[1] / norm),
          static_cast<double>(v[2] / norm)};
}

// ---- overlap: hulls and their planes --------------------------------------------------------

struct Triangle {
  std::array<int, 3> vertices;
  bool alive = true;
};

/// Sign of the volume of (a, b, c, d): positive when d is outside the triangle abc seen
/// counter-clockwise. Exact.
int side_of(const Pair& pair, int body, const std::array<int, 3>& t, int d) {
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  const std::vector<Triple<Real>>& r = pair.real[body];
  const Triple<Real> e1 = r[at(t[1])] - r[at(t[0])], e2 = r[at(t[2])] - r[at(t[0])];
  const Triple<Real> e3 = r[at(d)] - r[at(t[0])];
  const Real volume = dot(cross(e1, e2), e3);
  const auto largest = [](const Triple<Real>& v) {
    return std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
  };
  const Real l1 = largest(e1), l2 = largest(e2), l3 = largest(e3);
  // products of rounded differences of rounded coordinates
  const Real error = 0x1p-58L * l1 * l2 * l3 + 0x1p-60L * pair.size * (l1 * l2 + l2 * l3 + l3 * l1);
  if (std::abs(volume) > error) return volume > 0 ? 1 : -1;
  const std::vector<Triple<Whole>>& w = pair.whole[body];
  return sgn(
      dot(cross(w[at(t[1])] - w[at(t[0])], w[at(t[2])] - w[at(t[0])]), w[at(d)] - w[at(t[0])]));
}

bool collinear(const Pair& pair, int body, int i, int j, int k) {
  const std::vector<Triple<Whole>>& w = pair.whole[body];
  const auto at = [](int n) { return static_cast<std::size_t>(n); };
  const Triple<Whole> n = cross(w[at(j)] - w[at(i)], w[at(k)] - w[at(i)]);
  return n[0] == 0 && n[1] == 0 && n[2] == 0;
}

std::vector<Triangle> first_tetrahedron(const Pair& pair, int body) {
  const int count = static_cast<int>(pair.real[body].size());
  int j = 1, k = 2;
  while (j < count && pair.whole[body][static_cast<std::size_t>(j)] == pair.whole[body][0]) ++j;
  while (k < count && (k <= j || collinear(pair, body, 0, j, k))) ++k;
  for (int l = 1; l < count && k < count; ++l) {
    const int side = side_of(pair, body, {0, j, k}, l);
    if (side != 0) {
      const int p = side > 0 ? k : j, q = side > 0 ? j : k;
      return {{{0, p, q}}, {{0, q, l}}, {{q, p, l}}, {{p, 0, l}}};
    }
  }
  throw std::invalid_argument("exact_gap: the points are flat");
}

/// Triangles of the convex hull, counter-clockwise from outside. A point is added only when it is
/// strictly outside some triangle; coplanar neighbours stay triangles of one plane.
std::vector<Triangle> hull(const Pair& pair, int body) {
  std::vector<Triangle> triangles = first_tetrahedron(pair, body);
  const int count = static_cast<int>(pair.real[body].size());
  for (int point = 1; point < count; ++point) {
    std::vector<std::array<int, 2>> open;  // directed edges of the triangles taken away
    for (Triangle& t : triangles) {
      if (side_of(pair, body, t.vertices, point) > 0) {
        t.alive = false;
        for (std::size_t k = 0; k < 3; ++k)
          open.push_back({t.vertices[k], t.vertices[(k + 1) % 3]});
      }
    }
    std::erase_if(triangles, [](const Triangle& t) { return !t.alive; });
    for (const std::array<int, 2>& edge : open) {
      const std::array<int, 2> back{edge[1], edge[0]};
      if (std::find(open.begin(), open.end(), back) == open.end())
        triangles.push_back({{edge[0], edge[1], point}});
    }
  }
  return triangles;
}

/// From one point of a solid to another: their exact difference, rounded, so that short ones keep
/// their digits.
Triple<Real> line_between(const Pair& pair, int body, int p, int q) {
  const std::vector<Triple<Whole>>& w = pair.whole[body];
  const Triple<Whole> line = w[static_cast<std::size_t>(q)] - w[static_cast<std::size_t>(p)];
  return {rounded(line[0], pair.exponent), rounded(line[1], pair.exponent),
          rounded(line[2], pair.exponent)};
}

/// An edge of a hull.
struct Edge {
  int p = 0, q = 0;
  Triple<Real> line{};  // from p to q, m
  Real length = 0;
  std::array<Triple<Real>, 2> wings{};  // (third vertex of either triangle - p) × line, m2
};

Edge make_edge(const Pair& pair, int body, int p, int q, std::array<int, 2> thirds) {
  Edge edge{.p = p, .q = q, .line = line_between(pair, body, p, q)};
  edge.length = length(edge.line);
  for (const std::size_t k : {0u, 1u})
    edge.wings[k] = cross(line_between(pair, body, p, thirds[k]), edge.line);
  return edge;
}

std::vector<Edge> edges_of(const Pair& pair, int body, const std::vector<Triangle>& triangles) {
  struct Half {
    int low, high, third;
  };
  std::vector<Half> halves;
  for (const Triangle& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int p = t.vertices[k], q = t.vertices[(k + 1) % 3];
      halves.push_back({std::min(p, q), std::max(p, q), t.vertices[(k + 2) % 3]});
    }
  }
  std::sort(halves.begin(), halves.end(), [](const Half& u, const Half& v) {
    return std::tie(u.low, u.high, u.third) < std::tie(v.low, v.high, v.third);
  });
  std::vector<Edge> edges;
  for (std::size_t i = 0; i + 1 < halves.size(); i += 2) {
    const Half& h = halves[i];
    const int other = halves[i + 1].third;
    if (side_of(pair, body, {h.low, h.high, h.third}, other) != 0)  // not inside a flat face
      edges.push_back(make_edge(pair, body, h.low, h.high, {h.third, other}));
  }
  return edges;
}

/// A direction that may be the way out: the cross product of two lines between points.
struct Exit {
  Triple<Real> normal{};
  Real product = 0;  // of the lengths of the lines, m2
  Real depth = 0;    // along it, m
  Real error = 0;    // of `depth`, m
  int body1 = 0, p1 = 0, q1 = 0;
  int body2 = 0, p2 = 0, q2 = 0;
  int sign = 1;
};

Triple<Whole> whole_normal(const Pair& pair, const Exit& exit) {
  const auto edge = [&](int body, int p, int q) {
    const auto& w = pair.whole[body];
    return w[static_cast<std::size_t>(q)] - w[static_cast<std::size_t>(p)];
  };
  Triple<Whole> n = cross(edge(exit.body1, exit.p1, exit.q1), edge(exit.body2, exit.p2, exit.q2));
  for (Whole& c : n) c *= exit.sign;
  return n;
}

/// Is a cross product of two rounded lines no more than their rounding?
bool is_lost(const Exit& exit) { return length(exit.normal) <= 0x1p-58L * exit.product; }

/// How far heights along a normal, as parts of its length, may be off, m.
Real depth_error(const Pair& pair, const Exit& exit) {
  return 16 * pair.size * 0x1p-60L * (exit.product / length(exit.normal) + 1);
}

/// How far B must go along n to be clear of A, with a bound of its rounding error.
void measure(const Pair& pair, Exit& exit) {
  if (is_lost(exit)) {
    exit.depth = 0;
    exit.error = 8 * pair.size;
    return;
  }
  Real top = -INFINITY, bottom = INFINITY;
  for (const Triple<Real>& p : pair.real[0]) top = std::max(top, dot(exit.normal, p));
  for (const Triple<Real>& p : pair.real[1]) bottom = std::min(bottom, dot(exit.normal, p));
  exit.depth = (top - bottom) / length(exit.normal);
  exit.error = depth_error(pair, exit);
}

/// The ways out that may be the shortest.
struct Exits {
  std::vector<Exit> list;
  Real limit = INFINITY;  // at most so long is the shortest, m

  void add(const Pair& pair, Exit& exit) {
    measure(pair, exit);
    limit = std::min(limit, exit.depth + exit.error);
    list.push_back(exit);
  }
};

void add_face_exits(const Pair& pair, int body, const std::vector<Triangle>& triangles,
                    Exits& exits) {
  for (const Triangle& t : triangles) {
    Exit exit{.body1 = body,
              .p1 = t.vertices[0],
              .q1 = t.vertices[1],
              .body2 = body,
              .p2 = t.vertices[0],
              .q2 = t.vertices[2],
              .sign = body == 0 ? 1 : -1};
    const Triple<Real> u = line_between(pair, body, exit.p1, exit.q1);
    const Triple<Real> v = line_between(pair, body, exit.p2, exit.q2);
    exit.normal = exit.sign > 0 ? cross(u, v) : cross(v, u);
    exit.product = length(u) * length(v);
    exits.add(pair, exit);
  }
}

/// Whether the normal of two edges, one way, may belong to the normals of both: on either solid
/// both neighbours lie below it, but for rounding (`slack`). With n = e × f, n·x = f·(x × e).
bool may_support(const Edge& e, const Edge& f, Real sign, Real slack) {
  const auto below = [&](const Triple<Real>& line, const Triple<Real>& wing) {
    return sign * dot(line, wing) <= slack;
  };
  return below(f.line, e.wings[0]) && below(f.line, e.wings[1]) && below(e.line, f.wings[0]) &&
         below(e.line, f.wings[1]);
}

/// No way out is shorter than what parts two points of the solids along it.
bool is_too_long(const Pair& pair, const Exit& exit, Real limit) {
  const Triple<Real> across = pair.real[0][static_cast<std::size_t>(exit.p1)] -
                              pair.real[1][static_cast<std::size_t>(exit.p2)];
  return dot(exit.normal, across) / length(exit.normal) - depth_error(pair, exit) > limit;
}

/// The exits along one normal of two edges, either way.
void add_edge_exits(const Pair& pair, const Edge& e, const Edge& f, Exits& exits) {
  Exit exit{.body1 = 0, .p1 = e.p, .q1 = e.q, .body2 = 1, .p2 = f.p, .q2 = f.q};
  exit.product = e.length * f.length;
  const Real slack = 0x1p-54L * pair.size * exit.product;
  for (const int sign : {1, -1}) {
    if (!may_support(e, f, Real(sign), slack)) continue;
    exit.sign = sign;
    exit.normal = sign > 0 ? cross(e.line, f.line) : cross(f.line, e.line);
    if (is_lost(exit) || !is_too_long(pair, exit, exits.limit)) exits.add(pair, exit);
  }
}

/// A gap as it is proved: sign · sqrt(numerator) / denominator units.
struct ProvedGap {
  Whole numerator, denominator = 1;
  int sign = 1, steps = 0;
  Vector3 normal = Vector3::Zero();
};

ProvedGap proved_depth(const Pair& pair) {
  const std::vector<Triangle> hull_a = hull(pair, 0), hull_b = hull(pair, 1);
  Exits exits;
  add_face_exits(pair, 0, hull_a, exits);
  add_face_exits(pair, 1, hull_b, exits);
  const std::vector<Edge> edges_a = edges_of(pair, 0, hull_a), edges_b = edges_of(pair, 1, hull_b);
  for (const Edge& e : edges_a)
    for (const Edge& f : edges_b) add_edge_exits(pair, e, f, exits);
  ProvedGap answer;
  answer.sign = -1;
  Whole best_depth = -1, best_square = 1;  // depth = best_depth / sqrt(best_square)
  for (const Exit& exit : exits.list) {
    if (exit.depth - exit.error > exits.limit) continue;
    const Triple<Whole> n = whole_normal(pair, exit);
    const Whole square = dot(n, n);
    if (square == 0) continue;
    const Whole top = dot(n, pair.whole[0][static_cast<std::size_t>(farthest(pair, 0, n, 1))]);
    const Whole bottom = dot(n, pair.whole[1][static_cast<std::size_t>(farthest(pair, 1, n, -1))]);
    const Whole depth = top - bottom;
    ++answer.steps;
    if (best_depth < 0 || depth * depth * best_square < best_depth * best_depth * square) {
      best_depth = depth;
      best_square = square;
      answer.normal = unit(direction_of(n));
    }
  }
  answer.numerator = best_depth * best_depth * best_square;
  answer.denominator = best_square;
  return answer;
}

/// Nearest point of B - A to the origin: guessed in long double, proved or mended in whole numbers.
Foot<Whole> proved_nearest_point(const Pair& pair, int& turns) {
  const Foot<Real> guess = nearest_point<Real>(pair, Few(Corner{}), 200, turns);
  return nearest_point<Whole>(pair, guess.corners, 100000, turns);
}

/// More than the heights of two points along a direction of length 1 may be off, m: each is known
/// within the rounding of its place and of three products.
Real height_error(const Pair& pair) { return 0x1p-57L * pair.size; }

/// Is a point farther than all others (but its equals) along the line from their mean, beyond
/// doubt?
bool stands_out(const Pair& pair, int side, std::size_t point) {
  const std::vector<Triple<Real>>& real = pair.real[side];
  Triple<Real> mean{};
  for (const Triple<Real>& x : real)
    for (std::size_t k = 0; k < 3; ++k) mean[k] += x[k] / Real(real.size());
  const Triple<Real> line = real[point] - mean;
  const Real limit = dot(line, real[point]) - height_error(pair) * length(line);
  for (std::size_t i = 0; i < real.size(); ++i)
    if (!(dot(line, real[i]) < limit) && pair.whole[side][i] != pair.whole[side][point])
      return false;
  return true;
}

/// Do two hulls lie on different sides along a direction, beyond doubt?
bool surely_apart(const Pair& pair, const Triple<Real>& direction) {
  const Corner corner{farthest(pair, 0, direction, 1), farthest(pair, 1, direction, -1)};
  return dot(direction, place<Real>(pair, corner)) > height_error(pair) * length(direction);
}

/// Do two hulls share a point?
bool meet(const Pair& pair) {
  int turns = 0;
  const Foot<Real> guess = nearest_point<Real>(pair, Few(Corner{}), 200, turns);
  if (surely_apart(pair, guess.numerator)) return false;
  const Foot<Whole> foot = nearest_point<Whole>(pair, guess.corners, 100000, turns);
  return foot.corners.size() == 4 || dot(foot.numerator, foot.numerator) == 0;
}

/// A point against the others (but its equals) of a solid.
Pair set_apart(const Pair& pair, int side, std::size_t point) {
  Pair apart;
  apart.exponent = pair.exponent;
  apart.size = pair.size;
  apart.whole[0] = {pair.whole[side][point]};
  apart.real[0] = {pair.real[side][point]};
  for (std::size_t i = 0; i < pair.whole[side].size(); ++i) {
    if (pair.whole[side][i] != pair.whole[side][point]) {
      apart.whole[1].push_back(pair.whole[side][i]);
      apart.real[1].push_back(pair.real[side][i]);
    }
  }
  return apart;
}

double exact_distance(const Pair& pair) {
  int turns = 0;
  const Foot<Whole> foot = proved_nearest_point(pair, turns);
  if (foot.corners.size() == 4) return 0.0;
  return static_cast<double>(
      root_of_quotient(dot(foot.numerator, foot.numerator), foot.denominator, pair.exponent));
}

}  // namespace

struct ExactPair::Numbers {
  PlacedPoints solids[2];
  Pair pair;
  Triple<Real> origin_high{}, origin_low{};  // the first point of A; their sum has 128 bits
  enum class Known : char { No, Inner, Vertex };
  std::vector<Known> vertices[2];  // what has been asked of each point
};

ExactPair::ExactPair(const PlacedPoints& a, const PlacedPoints& b)
    : numbers_(std::make_unique<Numbers>()) {
  Numbers& n = *numbers_;
  n.solids[0] = a;
  n.solids[1] = b;
  n.pair.exponent = lowest_exponent(b, lowest_exponent(a, kNoBits));
  n.pair.whole[0] = whole_points(a, n.pair.exponent);
  n.pair.whole[1] = whole_points(b, n.pair.exponent);
  const Triple<Whole> origin = n.pair.whole[0].front();
  for (std::size_t k = 0; k < 3; ++k) {
    const Leading first = leading(origin[k], n.pair.exponent);
    n.origin_high[k] = first.value;
    n.origin_low[k] = rounded(first.rest, n.pair.exponent);
  }
  add_real(n.pair, origin);
}

ExactPair::~ExactPair() = default;
ExactPair::ExactPair(ExactPair&&) noexcept = default;

struct ExactPair::Proof : ProvedGap {};

ExactPair::Proof ExactPair::proof() const {
  const Pair& pair = numbers_->pair;
  int turns = 0;
  const Foot<Whole> foot = proved_nearest_point(pair, turns);
  const Whole squared = dot(foot.numerator, foot.numerator);
  if (foot.corners.size() == 4 || squared == 0) return {proved_depth(pair)};
  return {{squared, foot.denominator, 1, turns, unit(direction_of(foot.numerator))}};
}

ExactGap ExactPair::gap() const {
  const Proof proved = proof();
  return {
      proved.sign * root_of_quotient(proved.numerator, proved.denominator, numbers_->pair.exponent),
      proved.normal, proved.steps};
}

std::string ExactPair::squared_gap() const {
  const Proof proved = proof();
  Whole numerator = proved.numerator, denominator = proved.denominator * proved.denominator;
  const long doubled = 2 * numbers_->pair.exponent;
  if (doubled < 0)
    denominator <<= static_cast<mp_bitcnt_t>(-doubled);
  else
    numerator <<= static_cast<mp_bitcnt_t>(doubled);
  mpq_class quotient(numerator, denominator);
  quotient.canonicalize();
  return quotient.get_str();
}

const std::vector<RealPoint>& ExactPair::places(int side) const {
  return numbers_->pair.real[side];
}

bool ExactPair::is_vertex(int side, std::size_t point) const {
  const Pair& all = numbers_->pair;
  std::vector<Numbers::Known>& known = numbers_->vertices[side];
  known.resize(all.whole[side].size(), Numbers::Known::No);
  if (known[point] != Numbers::Known::No) return known[point] == Numbers::Known::Vertex;
  const bool outside = stands_out(all, side, point) || !meet(set_apart(all, side, point));
  known[point] = outside ? Numbers::Known::Vertex : Numbers::Known::Inner;
  return outside;
}

RealPoint ExactPair::place(const Vector3& point) const {
  RealPoint place;
  for (std::size_t k = 0; k < 3; ++k) {
    const Real high = Real(point[static_cast<Eigen::Index>(k)]) - numbers_->origin_high[k];
    place[k] = high - numbers_->origin_low[k];
  }
  return place;
}

double ExactPair::distance(int side, const Vector3& point, double enough) const {
  if (!point.allFinite()) return std::numeric_limits<double>::quiet_NaN();
  const Real bound = distance_in_long_double(side, place(point));
  const Real rounding = 0x1p-60L * numbers_->pair.size;  // of the places it was computed from
  if (bound + rounding <= Real(enough)) return static_cast<double>(bound);
  return exact_distance(make_pair(numbers_->solids[side], {point, {}}));
}

long double ExactPair::distance_in_long_double(int side, const RealPoint& place) const {
  Pair guess;
  guess.real[0] = numbers_->pair.real[side];
  guess.real[1] = {place};
  guess.size = numbers_->pair.size;
  int turns = 0;
  const Foot<Real> foot = nearest_point<Real>(guess, Few(Corner{}), 200, turns);
  return foot.corners.size() == 4 ? 0 : length(foot.numerator) / foot.denominator;
}

ExactGap exact_gap(const Points& a, const Points& b) { return ExactPair({a, {}}, {b, {}}).gap(); }

long double exact_width(const PlacedPoints& solid) {
  const Pair pair = make_pair(solid, solid);
  const ProvedGap proved = proved_depth(pair);
  return root_of_quotient(proved.numerator, proved.denominator, pair.exponent);
}

long double support(const Points& points, const Vector3& n, const Vector3& origin) {
  Real best = -INFINITY;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    Real height = 0;
    for (Eigen::Index k = 0; k < 3; ++k)
      height += Real(n[k]) * (Real(points(k, i)) - Real(origin[k]));
    best = std::max(best, height);
  }
  return best;
}

}  // namespace quoin::referee
