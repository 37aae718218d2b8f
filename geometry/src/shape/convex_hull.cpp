#include "shape/convex_hull.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "numeric/double_double.hpp"
#include "numeric/error_bounds.hpp"

namespace quoin::geometry {
namespace {

/// A sum of doubles that do not overlap, smallest first: exact arithmetic. [Shewchuk 1997],
/// section 2.
template <int kCapacity>
struct Expansion {
  std::array<double, kCapacity> terms;
  int size = 0;

  void add(double b) {  // grow-expansion with zero elimination
    int kept = 0;
    for (int i = 0; i < size; ++i) {
      const DoubleDouble s = two_sum(b, terms[static_cast<std::size_t>(i)]);
      b = s.high;
      if (s.low != 0.0) terms[static_cast<std::size_t>(kept++)] = s.low;
    }
    if (b != 0.0) terms[static_cast<std::size_t>(kept++)] = b;
    size = kept;
  }
  int sign() const {
    if (size == 0) return 0;
    return terms[static_cast<std::size_t>(size - 1)] > 0.0 ? 1 : -1;
  }
};

/// Adds a·b·c exactly; a, b, c are exact two-double differences.
template <int kCapacity>
void add_product(const DoubleDouble& a, const DoubleDouble& b, const DoubleDouble& c, double sign,
                 Expansion<kCapacity>& sum) {
  for (const double x : {a.high, a.low}) {
    if (x == 0.0) continue;
    for (const double y : {b.high, b.low}) {
      if (y == 0.0) continue;
      const DoubleDouble xy = two_product(x, y);
      for (const double z : {c.high, c.low}) {
        for (const double part : {xy.high, xy.low}) {
          if (part == 0.0 || z == 0.0) continue;
          const DoubleDouble xyz = two_product(part, sign * z);
          if (xyz.low != 0.0) sum.add(xyz.low);
          sum.add(xyz.high);
        }
      }
    }
  }
}

int exact_orientation(const Vector3& p, const Vector3& q, const Vector3& r, const Vector3& s) {
  const WideVector a = wide_difference(q, p);
  const WideVector b = wide_difference(r, p);
  const WideVector c = wide_difference(s, p);
  const double fine = dot(a, cross(b, c)).high;
  const double size = a.rounded().norm() * b.rounded().norm() * c.rounded().norm();
  if (std::abs(fine) > kWideVolumeRounding * size) return fine > 0.0 ? 1 : -1;
  Expansion<200> sum;  // 6 products of at most 32 terms
  add_product(a.x, b.y, c.z, 1.0, sum);
  add_product(a.y, b.z, c.x, 1.0, sum);
  add_product(a.z, b.x, c.y, 1.0, sum);
  add_product(a.z, b.y, c.x, -1.0, sum);
  add_product(a.y, b.x, c.z, -1.0, sum);
  add_product(a.x, b.z, c.y, -1.0, sum);
  return sum.sign();
}

/// Does a product of two surely differ from another, given differences rounded once?
bool surely_differ(double ax, double by, double ay, double bx) {
  constexpr double kBound = 4.0 * std::numeric_limits<double>::epsilon();  // [Shewchuk 1997]: 1.5
  const double first = ax * by, second = ay * bx;
  return std::abs(first - second) > kBound * (std::abs(first) + std::abs(second));
}

bool flat_corner(const DoubleDouble& ax, const DoubleDouble& ay, const DoubleDouble& bx,
                 const DoubleDouble& by) {
  Expansion<40> sum;
  add_product(ax, by, 1.0, 1.0, sum);
  add_product(ay, bx, 1.0, -1.0, sum);
  return sum.sign() == 0;
}

struct Facet {
  std::array<int, 3> vertices;
  std::array<int, 3> neighbours{-1, -1,
                                -1};  // [k] lies across the edge from vertices[k] to the next
  // Points strictly above it, each kept by one facet: a list, in the order in which they came.
  int first_above = -1, last_above = -1;
  int visited = -1;  // last point it was tested for
  bool visible = false;
  bool alive = true;
};

struct HorizonEdge {
  int from, to;  // as the visible facet ran along it
  int outer;     // the facet that stays
};

class Quickhull {
 public:
  explicit Quickhull(Points points)
      : points_(std::move(points)), next_above_(static_cast<std::size_t>(points_.cols()), -1) {
    facets_.reserve(4 * next_above_.size());
  }

  HullTriangles run() {
    HullTriangles result;
    std::array<int, 4> corners{};
    result.dimension = find_simplex(corners);
    if (result.dimension < 3) return result;
    start(corners);
    for (std::size_t f = 0; f < facets_.size(); ++f)
      while (facets_[f].alive && facets_[f].first_above >= 0) add_point(static_cast<int>(f));
    result.triangles.reserve(facets_.size());
    for (const Facet& facet : facets_)
      if (facet.alive) result.triangles.push_back(facet.vertices);
    return result;
  }

 private:
  Vector3 point(int i) const { return points_.col(i); }
  Facet& facet(int f) { return facets_[static_cast<std::size_t>(f)]; }
  int count() const { return static_cast<int>(points_.cols()); }

  bool sees(int i, const Facet& f) const {
    return orientation(point(f.vertices[0]), point(f.vertices[1]), point(f.vertices[2]), point(i)) >
           0;
  }

  /// Four corners not in one plane, far apart where the data allows; returns the dimension found.
  int find_simplex(std::array<int, 4>& c) const {
    c[0] = 0;
    c[1] = farthest([&](int i) { return (point(i) - point(c[0])).squaredNorm(); },
                    [&](int i) { return point(i) != point(c[0]); });
    if (c[1] < 0) return 0;
    const Vector3 line = point(c[1]) - point(c[0]);
    c[2] = farthest([&](int i) { return line.cross(point(i) - point(c[0])).squaredNorm(); },
                    [&](int i) { return !collinear(point(c[0]), point(c[1]), point(i)); });
    if (c[2] < 0) return 1;
    const Vector3 normal = line.cross(point(c[2]) - point(c[0]));
    c[3] = farthest(
        [&](int i) { return std::abs(normal.dot(point(i) - point(c[0]))); },
        [&](int i) { return orientation(point(c[0]), point(c[1]), point(c[2]), point(i)) != 0; });
    return c[3] < 0 ? 2 : 3;
  }

  /// The point of greatest measure that passes the exact test, or -1. The measure is only a wish.
  template <typename Measure, typename Test>
  int farthest(const Measure& measure, const Test& test) const {
    int best = -1;
    double greatest = -1.0;
    for (int i = 0; i < count(); ++i) {
      const double m = measure(i);
      if ((m > greatest || best < 0) && test(i)) {
        best = i;
        greatest = m;
      }
    }
    return best;
  }

  void start(std::array<int, 4> c) {
    if (orientation(point(c[0]), point(c[1]), point(c[2]), point(c[3])) > 0) std::swap(c[0], c[1]);
    // Now c[3] lies below the triangle (c0, c1, c2).
    facets_.resize(4);
    facets_[0].vertices = {c[0], c[1], c[2]};
    facets_[1].vertices = {c[1], c[0], c[3]};
    facets_[2].vertices = {c[2], c[1], c[3]};
    facets_[3].vertices = {c[0], c[2], c[3]};
    facets_[0].neighbours = {1, 2, 3};
    facets_[1].neighbours = {0, 3, 2};
    facets_[2].neighbours = {0, 1, 3};
    facets_[3].neighbours = {0, 2, 1};
    for (int i = 0; i < count(); ++i)
      if (std::ranges::find(c, i) == c.end()) hand_out(i, 0);
  }

  int& next_above(int i) { return next_above_[static_cast<std::size_t>(i)]; }

  void hand_out(int i, std::size_t first_facet) {
    for (std::size_t f = first_facet; f < facets_.size(); ++f) {
      Facet& candidate = facets_[f];
      if (!candidate.alive || !sees(i, candidate)) continue;
      (candidate.first_above < 0 ? candidate.first_above : next_above(candidate.last_above)) = i;
      candidate.last_above = i;
      next_above(i) = -1;
      return;
    }
  }

  /// The point farthest above a facet.
  int highest_above(const Facet& f) {
    const Vector3 p = point(f.vertices[0]);
    const Vector3 normal = (point(f.vertices[1]) - p).cross(point(f.vertices[2]) - p);
    int highest = -1;
    double most = -std::numeric_limits<double>::infinity();
    for (int i = f.first_above; i >= 0; i = next_above(i)) {
      const double height = normal.dot(point(i) - p);
      if (height <= most) continue;
      highest = i;
      most = height;
    }
    return highest;
  }

  void add_point(int start_facet) {
    const int apex = highest_above(facet(start_facet));
    find_horizon(start_facet, apex);
    const std::size_t first_new = facets_.size();
    for (std::size_t k = 0; k < horizon_.size(); ++k) {
      const HorizonEdge& edge = horizon_[k];
      Facet fresh;
      fresh.vertices = {edge.from, edge.to, apex};
      const int self = static_cast<int>(first_new + k);
      const int last = static_cast<int>(first_new + horizon_.size()) - 1;
      fresh.neighbours = {edge.outer, self == last ? static_cast<int>(first_new) : self + 1,
                          k == 0 ? last : self - 1};
      join(edge, self);
      facets_.push_back(fresh);
    }
    for (const int f : visible_) {
      facet(f).alive = false;
      for (int i = facet(f).first_above, next = -1; i >= 0; i = next) {
        next = next_above(i);
        if (i != apex) hand_out(i, first_new);
      }
    }
  }

  void join(const HorizonEdge& edge, int self) {
    Facet& outer = facet(edge.outer);
    for (std::size_t k = 0; k < 3; ++k)
      if (outer.vertices[k] == edge.to && outer.vertices[(k + 1) % 3] == edge.from)
        outer.neighbours[k] = self;
  }

  bool visible_from(int apex, int f) {
    Facet& candidate = facet(f);
    if (candidate.visited != apex) {
      candidate.visited = apex;
      candidate.visible = sees(apex, candidate);
      if (candidate.visible) visible_.push_back(f);
    }
    return candidate.visible;
  }

  /// Walks round the visible facets depth first, so that the horizon comes out as one closed loop.
  void find_horizon(int start_facet, int apex) {
    horizon_.clear();
    visible_.clear();
    stack_.clear();
    visible_from(apex, start_facet);
    for (int k = 2; k >= 0; --k) stack_.push_back({start_facet, k});
    while (!stack_.empty()) {
      const auto [f, k] = stack_.back();
      stack_.pop_back();
      const int next = facet(f).neighbours[static_cast<std::size_t>(k)];
      const int from = facet(f).vertices[static_cast<std::size_t>(k)];
      const int to = facet(f).vertices[static_cast<std::size_t>((k + 1) % 3)];
      const bool seen = facet(next).visited == apex;
      if (!visible_from(apex, next)) {
        horizon_.push_back({from, to, next});
      } else if (!seen) {
        int entry = 0;
        while (facet(next).vertices[static_cast<std::size_t>(entry)] != to) ++entry;
        stack_.push_back({next, (entry + 2) % 3});
        stack_.push_back({next, (entry + 1) % 3});
      }
    }
  }

  Points points_;
  std::vector<int> next_above_;  // by point: the next one above the same facet, -1: none
  std::vector<Facet> facets_;
  std::vector<HorizonEdge> horizon_;
  std::vector<int> visible_;
  std::vector<std::array<int, 2>> stack_;
};

}  // namespace

int orientation(const Vector3& p, const Vector3& q, const Vector3& r, const Vector3& s) {
  const Vector3 a = q - p, b = r - p, c = s - p;
  const double bycz = b.y() * c.z(), bzcy = b.z() * c.y();
  const double bzcx = b.z() * c.x(), bxcz = b.x() * c.z();
  const double bxcy = b.x() * c.y(), bycx = b.y() * c.x();
  const double det = a.x() * (bycz - bzcy) + a.y() * (bzcx - bxcz) + a.z() * (bxcy - bycx);
  const double size = std::abs(a.x()) * (std::abs(bycz) + std::abs(bzcy)) +
                      std::abs(a.y()) * (std::abs(bzcx) + std::abs(bxcz)) +
                      std::abs(a.z()) * (std::abs(bxcy) + std::abs(bycx));
  constexpr double kBound = 8.0 * std::numeric_limits<double>::epsilon();  // [Shewchuk 1997]: 3.5
  if (det > kBound * size) return 1;
  if (det < -kBound * size) return -1;
  if (size == 0.0) return 0;
  return exact_orientation(p, q, r, s);
}

bool collinear(const Vector3& p, const Vector3& q, const Vector3& r) {
  const Vector3 u = q - p, v = r - p;
  if (surely_differ(u.x(), v.y(), u.y(), v.x()) || surely_differ(u.y(), v.z(), u.z(), v.y()) ||
      surely_differ(u.z(), v.x(), u.x(), v.z()))
    return false;
  const WideVector a = wide_difference(q, p), b = wide_difference(r, p);
  return flat_corner(a.x, a.y, b.x, b.y) && flat_corner(a.y, a.z, b.y, b.z) &&
         flat_corner(a.z, a.x, b.z, b.x);
}

Points scaled_points(const Eigen::Ref<const Points>& points, int& exponent) {
  const double largest = points.size() > 0 ? points.cwiseAbs().maxCoeff() : 0.0;
  exponent = largest > 0.0 ? std::min(-std::ilogb(largest), 1000) : 0;
  const double factor = std::ldexp(1.0, exponent);
  return points.unaryExpr([&](double x) {
    const double scaled = x * factor;
    return std::abs(scaled) < 0x1p-200 ? 0.0 : scaled;
  });
}

HullTriangles hull_triangles(const Eigen::Ref<const Points>& points) {
  return Quickhull(points).run();
}

}  // namespace quoin::geometry
