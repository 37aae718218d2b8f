#include "search/exact_search.hpp"

#include <cmath>
#include <limits>

#include "shape/convex_hull.hpp"

namespace quoin::geometry {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
/// Rounding of a double-double sum of a few products, with room to spare.
constexpr double kWideEpsilon = 1e-29;

Vector3 unit(const WideVector& v) {
  const DoubleDouble length = square_root(dot(v, v));
  return {double(v.x / length), double(v.y / length), double(v.z / length)};
}

/// Brings a direction to length about 1 by an exact power of two, so that nothing under- or
/// overflows.
WideVector scaled(const WideVector& v) {
  const double largest = std::max({std::abs(v.x.high), std::abs(v.y.high), std::abs(v.z.high)});
  if (!(largest > 0.0)) return v;
  const double factor = std::ldexp(1.0, -std::ilogb(largest));
  return v * DoubleDouble(factor);
}

/// The vertex farthest along a wide direction: a double scan, then the doubtful ones once more.
int wide_support(const Solid& polyhedron, const WideVector& direction) {
  const Vector3 d = direction.rounded();
  const Support first = support(polyhedron, d);
  const double bound = 8 * kEpsilon * d.norm() * polyhedron.diameter();
  VertexSet close;
  find_vertices_beyond(polyhedron, d, first.value - bound, close);
  int best = first.vertex;
  for (const int v : close) {
    if (v == best) continue;
    const WideVector step = polyhedron.wide_line(best, v);
    const DoubleDouble more = dot(direction, step);
    if (more.high > 0.0) best = v;
  }
  return best;
}

int wide_support_among(const Solid& polyhedron, const WideVector& direction, const VertexSet& set) {
  int best = set[0];
  for (const int v : set) {
    const WideVector step = polyhedron.wide_line(best, v);
    if (dot(direction, step).high > 0.0) best = v;
  }
  return best;
}

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
    for (int k = 0; k < size_; ++k) {
      if (corner(k).p == p && corner(k).q == q) return true;
    }
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
    for (int k = 0; k < size_; ++k) {
      if (best.mask >> k & 1u) corners_[static_cast<std::size_t>(kept++)] = corner(k);
    }
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
    for (int k = 0; k < size_; ++k) {
      if (mask >> k & 1u) w[static_cast<std::size_t>(n++)] = &corner(k).w;
    }
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
    for (std::size_t k = 0; k < 3; ++k) {
      if (!(dot(normal, cross(*w[(k + 1) % 3], *w[(k + 2) % 3])).high > 0.0)) return false;
    }
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

void add_once(std::array<int, 3>& list, int& count, int v) {
  for (int k = 0; k < count; ++k) {
    if (list[static_cast<std::size_t>(k)] == v) return;
  }
  if (count < 3) list[static_cast<std::size_t>(count++)] = v;
}

void name_features(const Simplex& simplex, ActiveFeatures& result) {
  for (int k = 0; k < simplex.size(); ++k) {
    add_once(result.p, result.p_count, simplex.corner(k).p);
    add_once(result.q, result.q_count, simplex.corner(k).q);
  }
  std::sort(result.p.begin(), result.p.begin() + result.p_count);
  std::sort(result.q.begin(), result.q.begin() + result.q_count);
}

/// `support_p(d)`, `support_q(d)`: vertex of P farthest along d, of Q farthest against it.
template <typename SupportP, typename SupportQ>
ActiveFeatures search(const Solid& p, const Solid& q, int first_p, int first_q, int max_iterations,
                      const SupportP& support_p, const SupportQ& support_q) {
  const double size = std::min(p.diameter(), q.diameter());
  // Nearer than this a line between vertices or edges has no direction left, even in double-double;
  // the answer may then come from the planes that part the solids just as well.
  const double nothing = kEpsilon / 8 * std::max(p.diameter(), q.diameter());
  ActiveFeatures result;
  Simplex simplex;
  simplex.push({first_p, first_q, exact_corner(p, q, first_p, first_q)});
  WideVector direction;
  std::array<int, 2> last{first_p, first_q};
  while (result.iterations < max_iterations) {
    ++result.iterations;
    DoubleDouble distance;
    result.overlapping = !simplex.reduce(direction, distance) || !(distance.high > nothing);
    if (result.overlapping) return result;
    if (result.iterations > 1 && !simplex.has(last[0], last[1])) {
      // No step forward: the margin is inside the rounding even here. When the solids touch within
      // the rounding of the coordinates the planes between them decide.
      result.overlapping = distance.high <= 64 * kEpsilon * std::max(p.diameter(), q.diameter());
      return result;
    }
    direction = scaled(direction);
    const DoubleDouble length = square_root(dot(direction, direction));
    const DoubleDouble here = distance * length;
    const double rounding = kEpsilon / 256 * length.high * size;
    const int i = support_p(direction), j = support_q(direction);
    const WideVector w = exact_corner(p, q, i, j);
    const DoubleDouble gain = here - dot(direction, w);
    if (simplex.has(i, j) || gain.high <= rounding + 1e-18 * here.high) {
      result.converged = true;
      result.normal = unit(direction);
      result.gap = double(distance);
      name_features(simplex, result);
      return result;
    }
    simplex.push({i, j, w});
    last = {i, j};
  }
  return result;
}

// ---- least overlap ----

struct HullEdge {
  std::array<int, 2> ends;
  Vector3 normal_left, normal_right;  // unit normals of the triangles beside it
};

struct ExactHull {
  std::vector<std::array<int, 3>> triangles;
  std::vector<WideVector> wide_normals;
  std::vector<Vector3> normals;
  std::vector<HullEdge> edges;
};

ExactHull exact_hull(const Solid& polyhedron) {
  ExactHull hull;
  hull.triangles = hull_triangles(polyhedron.shape().vertices()).triangles;
  struct Side {
    std::array<int, 2> ends;
    std::size_t triangle;
  };
  std::vector<Side> sides;
  for (std::size_t t = 0; t < hull.triangles.size(); ++t) {
    const std::array<int, 3>& v = hull.triangles[t];
    hull.wide_normals.push_back(
        scaled(cross(polyhedron.wide_line(v[0], v[1]), polyhedron.wide_line(v[0], v[2]))));
    hull.normals.push_back(unit(hull.wide_normals.back()));
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = v[k], b = v[(k + 1) % 3];
      sides.push_back({{std::min(a, b), std::max(a, b)}, t});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.ends != b.ends ? a.ends < b.ends : a.triangle < b.triangle;
  });
  for (std::size_t k = 0; k + 1 < sides.size(); k += 2) {
    hull.edges.push_back(
        {sides[k].ends, hull.normals[sides[k].triangle], hull.normals[sides[k + 1].triangle]});
  }
  return hull;
}

/// A plane that may part the solids: its direction and the features that make it.
struct Candidate {
  WideVector direction;
  Vector3 normal;
  double gap = 0.0;  // in double
  std::array<int, 3> p{}, q{};
  int p_count = 0, q_count = 0;
};

class Enumeration {
 public:
  Enumeration(const Solid& p, const Solid& q) : p_(p), q_(q), shift_(q.origin() - p.origin()) {
    rounding_ = 16 * kEpsilon * (p.diameter() + q.diameter() + shift_.norm());
  }

  ActiveFeatures run() {
    const ExactHull hull_p = exact_hull(p_), hull_q = exact_hull(q_);
    for (std::size_t t = 0; t < hull_p.triangles.size(); ++t) {
      Candidate c{hull_p.wide_normals[t], hull_p.normals[t], 0.0, hull_p.triangles[t], {}, 3, 0};
      consider(c);
    }
    for (std::size_t t = 0; t < hull_q.triangles.size(); ++t) {
      Candidate c{-hull_q.wide_normals[t], -hull_q.normals[t], 0.0, {}, hull_q.triangles[t], 0, 3};
      consider(c);
    }
    for (const HullEdge& e : hull_p.edges) {
      for (const HullEdge& f : hull_q.edges) consider_edges(e, f);
    }
    return best();
  }

 private:
  static bool arcs_apart(const HullEdge& e, const HullEdge& f) {
    constexpr double kSlack = 1e-9;  // normals are unit within rounding; a superset does no harm
    const Vector3 c = -f.normal_left, d = -f.normal_right;
    const Vector3 ab = e.normal_left.cross(e.normal_right), cd = c.cross(d);
    const double c_side = c.dot(ab), d_side = d.dot(ab);
    const double a_side = e.normal_left.dot(cd), b_side = e.normal_right.dot(cd);
    return (c_side > kSlack && d_side > kSlack) || (c_side < -kSlack && d_side < -kSlack) ||
           (a_side > kSlack && b_side > kSlack) || (a_side < -kSlack && b_side < -kSlack);
  }

  void consider_edges(const HullEdge& e, const HullEdge& f) {
    if (arcs_apart(e, f)) return;
    const WideVector direction =
        scaled(cross(p_.wide_line(e.ends[0], e.ends[1]), q_.wide_line(f.ends[0], f.ends[1])));
    if (!(dot(direction, direction).high > 0.0)) return;
    Candidate c{
        direction, unit(direction), 0.0, {e.ends[0], e.ends[1], 0}, {f.ends[0], f.ends[1], 0}, 2,
        2};
    consider(c);
    c.direction = -c.direction;
    c.normal = -c.normal;
    consider(c);
  }

  void consider(Candidate& c) {
    c.gap = c.normal.dot(shift_) - support(q_, -c.normal).value - support(p_, c.normal).value;
    if (c.gap < greatest_ - 2 * rounding_) return;
    greatest_ = std::max(greatest_, c.gap);
    candidates_.push_back(c);
  }

  DoubleDouble wide_gap(const WideVector& direction, int& i, int& j) const {
    i = wide_support(p_, direction);
    j = wide_support(q_, -direction);
    const WideVector w = exact_corner(p_, q_, i, j);
    return dot(direction, w) / square_root(dot(direction, direction));
  }

  ActiveFeatures best() {
    ActiveFeatures result;
    DoubleDouble greatest = -std::numeric_limits<double>::infinity();
    const Candidate* winner = nullptr;
    std::array<int, 2> touch{};
    std::vector<std::pair<DoubleDouble, const Candidate*>> finalists;
    for (const Candidate& c : candidates_) {
      if (c.gap < greatest_ - 2 * rounding_) continue;
      int i = 0, j = 0;
      const DoubleDouble gap = wide_gap(c.direction, i, j);
      finalists.emplace_back(gap, &c);
      if (!(gap > greatest)) continue;
      greatest = gap;
      winner = &c;
      touch = {i, j};
    }
    if (winner == nullptr) return result;
    result.overlapping = result.converged = true;
    result.gap = double(greatest);
    result.normal = winner->normal;
    result.p = winner->p;
    result.q = winner->q;
    result.p_count = winner->p_count;
    result.q_count = winner->q_count;
    if (result.p_count == 0) add_once(result.p, result.p_count, touch[0]);
    if (result.q_count == 0) add_once(result.q, result.q_count, touch[1]);
    std::sort(result.p.begin(), result.p.begin() + result.p_count);
    std::sort(result.q.begin(), result.q.begin() + result.q_count);
    result.iterations = 1;
    judge_ties(finalists, result);
    return result;
  }

  /// Other directions of the same overlap: said so; and where the solids just touch, the mean of
  /// them keeps the solids apart as well and shows the vertex or edge in which they meet.
  void judge_ties(const std::vector<std::pair<DoubleDouble, const Candidate*>>& finalists,
                  ActiveFeatures& result) const {
    const double tie = 2 * kEpsilon * std::max(p_.diameter(), q_.diameter());
    std::vector<Vector3> planes{result.normal};
    for (const auto& [gap, c] : finalists) {
      if (double(gap) < result.gap - tie) continue;
      const Vector3& plane = c->normal;
      const auto same = [&](const Vector3& n) { return (n - plane).squaredNorm() < 1e-12; };
      if (std::none_of(planes.begin(), planes.end(), same)) planes.push_back(plane);
    }
    result.several = planes.size() > 1;
    if (!result.several || std::abs(result.gap) > tie) return;
    Vector3 sum = Vector3::Zero();
    for (const Vector3& n : planes) sum += n;
    if (!(sum.norm() > 1e-3)) return;
    const Vector3 mean = sum.normalized();
    int i = 0, j = 0;
    const double gap = double(wide_gap(wide(mean), i, j));
    if (gap < result.gap - tie) return;
    result.normal = mean;
    result.gap = gap;
    result.middle = true;
  }

  const Solid& p_;
  const Solid& q_;
  Vector3 shift_;
  double rounding_ = 0.0;
  double greatest_ = -std::numeric_limits<double>::infinity();
  std::vector<Candidate> candidates_;
};

}  // namespace

ActiveFeatures exact_nearest(const Solid& p, const Solid& q, int max_iterations) {
  const Vector3 shift = q.origin() - p.origin();
  return search(
      p, q, support(p, shift).vertex, support(q, -shift).vertex, max_iterations,
      [&](const WideVector& d) { return wide_support(p, d); },
      [&](const WideVector& d) { return wide_support(q, -d); });
}

ActiveFeatures exact_nearest_among(const Solid& p, const Solid& q, const VertexSet& set_p,
                                   const VertexSet& set_q) {
  return search(
      p, q, set_p[0], set_q[0], 1000,
      [&](const WideVector& d) { return wide_support_among(p, d, set_p); },
      [&](const WideVector& d) { return wide_support_among(q, -d, set_q); });
}

ActiveFeatures exhaustive_overlap(const Solid& p, const Solid& q) {
  return Enumeration(p, q).run();
}

}  // namespace quoin::geometry
