#include "search/exact_search.hpp"

#include <cmath>
#include <limits>

#include "numeric/error_bounds.hpp"

namespace quoin::geometry {
namespace {

/// One point q_j - p_i of the Minkowski difference, exact.
struct Corner {
  int p = 0, q = 0;
  WideVector w;
};

/// Up to four corners and the subset whose hull carries the point nearest to the origin.
class Simplex {
 public:
  int size() const { return size_; }
  const Corner& corner(int k) const { return corners_[static_cast<std::size_t>(k)]; }
  void push(const Corner& corner) { corners_[static_cast<std::size_t>(size_++)] = corner; }
  bool has(int p, int q) const {
    for (int k = 0; k < size_; ++k)
      if (corner(k).p == p && corner(k).q == q) return true;
    return false;
  }

  /// Shrinks to the carrying subset; gives a vector along the nearest point and its distance (m),
  /// or returns false when the origin is inside.
  bool reduce(WideVector& direction, DoubleDouble& distance) {
    if (size_ == 4 && inside()) return false;
    Choice best;
    for (unsigned mask = 1; mask < (1u << size_); ++mask) consider(mask, best);
    direction = best.direction;
    distance = square_root(best.squared_distance);
    int kept = 0;
    for (int k = 0; k < size_; ++k)
      if (best.mask >> k & 1u) corners_[static_cast<std::size_t>(kept++)] = corner(k);
    size_ = kept;
    return best.mask != 0;
  }

 private:
  struct Choice {
    unsigned mask = 0;
    WideVector direction;
    DoubleDouble squared_distance = std::numeric_limits<double>::infinity();
    double violation = std::numeric_limits<double>::infinity();  // how far a corner lies nearer, m
  };

  void consider(unsigned mask, Choice& best) const {
    std::array<const WideVector*, 4> w{};
    int n = 0;
    for (int k = 0; k < size_; ++k)
      if (mask >> k & 1u) w[static_cast<std::size_t>(n++)] = &corner(k).w;
    Choice choice;
    choice.mask = mask;
    if (n == 4 || !nearest(w, n, choice)) return;
    choice.violation = violation(choice);
    if (choice.violation < best.violation) best = choice;
  }

  /// The optimal subset is told by its plane, not by its distance: two candidates whose planes
  /// differ by one rounding of the input have distances that differ by its square.
  double violation(const Choice& choice) const {
    const DoubleDouble length = square_root(dot(choice.direction, choice.direction));
    const DoubleDouble distance = square_root(choice.squared_distance);
    if (!(distance.high > kWideEpsilon * corner(0).w.rounded().norm()))
      return -1.0;  // the origin itself
    const DoubleDouble here = distance * length;
    double worst = 0.0;
    for (int k = 0; k < size_; ++k) {
      if (choice.mask >> k & 1u) continue;
      worst = std::max(worst, double(here - dot(choice.direction, corner(k).w)) / length.high);
    }
    return worst;
  }

  /// The point of the affine hull nearest to the origin, if it lies inside the simplex.
  static bool nearest(const std::array<const WideVector*, 4>& w, int n, Choice& choice) {
    WideVector& direction = choice.direction;
    if (n == 1) {
      direction = *w[0];
      choice.squared_distance = dot(direction, direction);
      return true;
    }
    const WideVector e = *w[1] - *w[0];
    if (n == 2) {
      const DoubleDouble ee = dot(e, e), we = -dot(*w[0], e);
      if (!(we.high > 0.0 && we < ee)) return false;
      direction = *w[0] * ee + e * we;  // not along·along/length: that would cancel twice
      choice.squared_distance = dot(direction, direction) / (ee * ee);
      return true;
    }
    const WideVector other = *w[2] - *w[0];
    WideVector normal = cross(e, other);
    const double flat = kWideEpsilon * e.rounded().norm() * other.rounded().norm();
    if (!(normal.rounded().norm() > flat))
      return false;  // its sides carry the nearest point as well
    normal = scaled(normal);
    for (std::size_t k = 0; k < 3; ++k)
      if (!(dot(normal, cross(*w[(k + 1) % 3], *w[(k + 2) % 3])).high > 0.0)) return false;
    const DoubleDouble along = dot(normal, *w[0]);
    direction = along.high < 0.0 ? -normal : normal;
    choice.squared_distance = along * along / dot(normal, normal);
    return true;
  }

  bool inside() const {
    const WideVector &a = corner(0).w, &b = corner(1).w, &c = corner(2).w, &d = corner(3).w;
    const double s0 = dot(b, cross(c, d)).high, s1 = -dot(a, cross(c, d)).high;
    const double s2 = dot(a, cross(b, d)).high, s3 = -dot(a, cross(b, c)).high;
    double size = 0.0;
    for (int k = 0; k < 4; ++k) size = std::max(size, corner(k).w.rounded().norm());
    const double zero = kWideEpsilon * size * size * size;
    return (s0 > zero && s1 > zero && s2 > zero && s3 > zero) ||
           (s0 < -zero && s1 < -zero && s2 < -zero && s3 < -zero);
  }

  std::array<Corner, 4> corners_;
  int size_ = 0;
};

void name_corners(const Simplex& simplex, ActiveFeatures& result) {
  result.corners = simplex.size();
  for (int k = 0; k < simplex.size(); ++k) {
    result.p[static_cast<std::size_t>(k)] = simplex.corner(k).p;
    result.q[static_cast<std::size_t>(k)] = simplex.corner(k).q;
  }
}

}  // namespace

int wide_support(const Solid& polyhedron, const WideVector& direction) {
  const Vector3 d = direction.rounded();
  const Support first = support(polyhedron, d);
  const double limit = first.value - kWideSupport * kEpsilon * d.norm() * polyhedron.diameter();
  const Vec3 local = polyhedron.turned_back(d);
  int best = first.vertex;
  for (int v = 0; v < polyhedron.vertex_count(); ++v) {
    if (v == best || dot(row_offset(polyhedron, v), local) < limit) continue;
    const WideVector step = polyhedron.wide_line(best, v);
    if (dot(direction, step).high > 0.0) best = v;
  }
  return best;
}

namespace {

ActiveFeatures facing_vertices(const Solid& p, const Solid& q) {
  const Vector3 shift = q.origin() - p.origin();
  return {.p = {support(p, shift).vertex}, .q = {support(q, -shift).vertex}, .corners = 1};
}

}  // namespace

ActiveFeatures exact_nearest(const Solid& p, const Solid& q, const ActiveFeatures& given,
                             int max_iterations) {
  const ActiveFeatures start = given.corners > 0 ? given : facing_vertices(p, q);
  const double larger = std::max(p.diameter(), q.diameter());
  const double smaller = std::min(p.diameter(), q.diameter());
  ActiveFeatures result;
  Simplex simplex;
  for (std::size_t k = 0; k < static_cast<std::size_t>(start.corners); ++k) {
    const int i = start.p[k], j = start.q[k];
    if (!simplex.has(i, j)) simplex.push({i, j, exact_corner(p, q, i, j)});
  }
  WideVector direction;
  DoubleDouble distance;
  const auto end = [&](bool converged) {
    result.converged = converged;
    if (converged) {
      result.normal = unit(direction);
      result.gap = double(distance);
    }
    name_corners(simplex, result);
    return result;
  };
  std::array<int, 2> last{};
  bool gains = true;
  double gained = 0.0;  // by the last corner, m
  // What the direction is off by, of a line that is much longer than the gap, or of a triangle with
  // a side of the smaller solid: relative to what cancels there.
  const auto is_rounding = [&](double gain) {
    const double least = std::min(smaller, distance.high);
    return gain <= larger * std::min(kEpsilon, kWideEpsilon * (larger / least));
  };
  while (result.iterations < max_iterations) {
    ++result.iterations;
    // Nearer than this the planes that part the solids are as good, and several of them may be.
    const bool found = simplex.reduce(direction, distance);
    result.overlapping = !found || !(distance.high > kRounding * kEpsilon * larger);
    if (result.overlapping) return end(false);
    // No step forward: the margin is inside the rounding even here. When the solids touch within
    // the rounding of the coordinates the planes between them decide.
    if (result.iterations > 1 && !simplex.has(last[0], last[1])) {
      result.overlapping = gains && distance.high <= kStalled * kEpsilon * larger;
      return end(!gains || (!result.overlapping && is_rounding(gained)));
    }
    direction = scaled(direction);
    const DoubleDouble length = square_root(dot(direction, direction));
    const DoubleDouble here = distance * length;
    const int i = wide_support(p, direction), j = wide_support(q, -direction);
    const WideVector w = exact_corner(p, q, i, j);
    const DoubleDouble gain = here - dot(direction, w);
    const double reach = length.high * (w.rounded().norm() + larger);
    if (simplex.has(i, j) || gain.high <= kWideEpsilon * reach) return end(true);
    gained = gain.high / length.high;
    gains = gain.high > kIdleGain * kEpsilon * (length.high * smaller + here.high);
    simplex.push({i, j, w});
    last = {i, j};
  }
  return result;
}

}  // namespace quoin::geometry
