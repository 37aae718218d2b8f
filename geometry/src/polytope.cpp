#include "polytope.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "double_double.hpp"
#include "four_lanes.hpp"
#include "support_lanes.hpp"

namespace quoin::geometry {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A polytope inside the set of differences, around the origin. While all its facets turn to the
/// origin their inner sides, each ray from the origin meets one of them; so the least distance of a
/// facet is a depth that the solids have at least. See geometry/README.md, "Least overlap".
/// Facets are triangles, counter-clockwise seen from outside, their planes rows of numbers.
template <class Scan, class Lanes>
class Polytope {
 public:
  Polytope(const Polyhedron& p, const Polyhedron& q, double rounding)
      : p_(p), q_(q), rounding_(rounding) {}

  FastResult grow(const FastResult& start) {
    FastResult result = start;
    result.outcome = FastOutcome::Unclear;
    result.iterations = 0;
    if (!begin(start)) return result;
    while (result.iterations < kMostCorners - 8) {
      ++result.iterations;
      const int nearest = nearest_facet();
      if (nearest < 0) return result;
      const Vector3 outward = normal(nearest);
      const Corner corner = find_corner(-outward);
      const double gain = outward.dot(corner.w - place(corners_of(nearest)[0]));
      if (gain <= rounding_) {
        finish(nearest, result);
        return result;
      }
      if (!open(nearest, corner.w) || !add_cone(add_corner(corner))) return result;
    }
    return result;
  }

 private:
  static constexpr int kMostCorners = 96;
  static constexpr int kMostFacets = 1024, kMostSides = 128;  // multiples of four
  using Number = std::uint16_t;                               // of a corner or a facet
  using Three = std::array<Number, 3>;

  struct Corner {
    Vector3 w;
    int p = 0, q = 0;
  };
  struct Step {
    Number facet, side;
  };

  static Number number(unsigned i) { return static_cast<Number>(i); }
  static Number number(int i) { return static_cast<Number>(i); }
  static bool has(const auto& bits, int f) { return (bits[index(f / 4)] >> f % 4 & 1) != 0; }
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  Three& corners_of(int f) { return facet_corners_[index(f)]; }
  Three& neighbours(int f) { return neighbours_[index(f)]; }
  Vector3 place(int c) const { return {x_[c], y_[c], z_[c]}; }
  Vector3 normal(int f) const { return {normal_x_[f], normal_y_[f], normal_z_[f]}; }

  Corner find_corner(const Vector3& direction) const {
    const PairSupport both = Scan::support_pair(Rows(p_), Rows(q_), direction);
    const int i = both.p.vertex, j = both.q.vertex;
    return {q_.vertex(j) - p_.vertex(i), i, j};
  }

  int add_corner(const Corner& corner) {
    const int c = corner_count_++;
    x_[c] = corner.w.x();
    y_[c] = corner.w.y();
    z_[c] = corner.w.z();
    length_[c] = corner.w.norm();
    vertex_p_[c] = corner.p;
    vertex_q_[c] = corner.q;
    return c;
  }

  /// A tetrahedron around the origin, from the corners of the search and, where it ended with
  /// fewer, from supports across them.
  bool begin(const FastResult& start) {
    for (int k = 0; k < start.corners; ++k) {
      const int i = start.p[index(k)], j = start.q[index(k)];
      add_corner({q_.vertex(j) - p_.vertex(i), i, j});
    }
    while (corner_count_ < 4) {
      if (!add_across()) return false;
    }
    const Vector3 a = place(1) - place(0), b = place(2) - place(0), c = place(3) - place(0);
    const bool turned =
        a.cross(b).dot(c) > 0.0;  // seen from corner 3, 0, 1 and 2 are to turn right
    const Number first = turned ? 1 : 0, second = turned ? 0 : 1;
    sides_ = 0;
    for (const Number corner : {first, second, Number{2}}) from_[index(sides_++)] = corner;
    // The base as a cone over one side, with a facet of its own; then the cone over all three.
    if (!lay_planes(1, 2)) return false;
    corners_of(0) = {first, second, 2};
    facet_count_ = 4;
    from_ = {second, first, 2};
    facet_ = {0, 0, 0};
    place_ = {0, 2, 1};
    return add_cone(3);
  }

  bool add_across() {
    Vector3 direction;
    if (corner_count_ == 3) {
      direction = (place(1) - place(0)).cross(place(2) - place(0));
    } else {
      const Vector3 line = corner_count_ == 2 ? Vector3(place(1) - place(0))
                                              : Vector3(q_.vertex_mean() - p_.vertex_mean());
      int axis = 0;
      line.cwiseAbs().minCoeff(&axis);
      direction = line.cross(Vector3::Unit(axis));
    }
    Corner best{Vector3::Zero(), 0, 0};
    double farthest = 0.0;
    for (const double side : {1.0, -1.0}) {
      const Corner corner = find_corner(side * direction);
      const double reach = std::abs(direction.dot(corner.w - place(0)));
      if (reach > farthest) {
        farthest = reach;
        best = corner;
      }
    }
    if (!(farthest > rounding_ * direction.norm())) return false;
    add_corner(best);
    return true;
  }

  /// Leaves a facet out of all that is asked of the planes.
  void retire(int f) { distance_[f] = sure_[f] = kInfinity; }

  /// A cone over the border of the hole, in a block of its own: the sides run around it. False
  /// where rounding has torn the surface.
  bool add_cone(int apex) {
    if (sides_ < 3 || facet_count_ + sides_ > kMostFacets) return false;
    for (int k = 0; k < sides_; ++k) {
      const int f = facet_count_ + k;
      const int next = k + 1 < sides_ ? f + 1 : facet_count_;
      const int before = k > 0 ? f - 1 : f + sides_ - 1;
      corners_of(f) = {from_[index(k)], from_[index(next - facet_count_)], number(apex)};
      neighbours(f) = {facet_[index(k)], number(next), number(before)};
      neighbours(facet_[index(k)])[place_[index(k)]] = number(f);
    }
    const bool around = lay_planes(sides_, apex);
    facet_count_ += (sides_ + 3) / 4 * 4;
    return around;
  }

  /// The planes of new facets, between the first `count` sides of the border and a corner. False:
  /// one turns its outer side to the origin.
  bool lay_planes(int count, int apex) {
    from_[index(sides_)] = from_[0];
    std::fill_n(from_.begin() + sides_ + 1, 4, from_[0]);
    bool around = true;
    for (int k = 0; k < count; k += 4) around &= lay_four(k, std::min(4, count - k), apex);
    return around;
  }

  bool lay_four(int first, int count, int apex) {
    const auto all = [](double x) { return Lanes::all(x); };
    const Number *const from = &from_[index(first)], *const to = from + 1;
    const Lanes ax = all(x_[apex]), ay = all(y_[apex]), az = all(z_[apex]);
    const Lanes ux = Lanes::picked(x_, from) - ax, vx = Lanes::picked(x_, to) - ax;
    const Lanes uy = Lanes::picked(y_, from) - ay, vy = Lanes::picked(y_, to) - ay;
    const Lanes uz = Lanes::picked(z_, from) - az, vz = Lanes::picked(z_, to) - az;
    const Lanes reach =
        Lanes::picked(length_, from).larger(Lanes::picked(length_, to)).larger(all(length_[apex]));
    const Lanes x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    const Lanes squared = x * x + y * y + z * z;
    const Lanes whole = (ux * ux + uy * uy + uz * uz) * (vx * vx + vy * vy + vz * vz);
    const Lanes inverse = all(1.0) / squared.root();
    const Lanes distance = (x * ax + y * ay + z * az) * inverse;
    // By how much the products that made the normal have cancelled: at most 1 + a quarter of this.
    const Lanes cancelled = whole * (inverse * inverse);
    const Lanes sure = distance - all(kEpsilon) * reach * (all(2.5) + all(0.25) * cancelled);
    const unsigned there = (all(kNoArea * kNoArea) * whole).below(squared) & ((1u << count) - 1u);
    const unsigned slim = squared.below(all(kSlim * kSlim) * whole);
    const int f = facet_count_ + first;
    (x * inverse).store(normal_x_ + f);
    (y * inverse).store(normal_y_ + f);
    (z * inverse).store(normal_z_ + f);
    distance.where(there, all(kInfinity)).store(distance_ + f);
    sure.where(there, all(kInfinity)).store(sure_ + f);
    slim_[f / 4] = number(slim);
    return (there & ~slim & distance.below(all(-rounding_))) == 0;
  }

  /// The plane of a slim facet from exact differences.
  void lay_exactly(int f) {
    slim_[f / 4] = number(slim_[f / 4] & ~(1 << f % 4));
    std::array<WideVector, 3> w;
    for (std::size_t k = 0; k < 3; ++k) {
      const int c = corners_of(f)[k];
      w[k] = wide_difference(q_.vertex(vertex_q_[c]), p_.vertex(vertex_p_[c]));
    }
    const Vector3 across = cross(w[1] - w[0], w[2] - w[0]).rounded();
    const double area = across.norm();
    retire(f);
    if (!(area > 0.0)) return;
    const auto& [a, b, c] = corners_of(f);
    const Vector3 unit = across / area;
    normal_x_[f] = unit.x();
    normal_y_[f] = unit.y();
    normal_z_[f] = unit.z();
    distance_[f] = unit.dot(place(a));
    sure_[f] = distance_[f] - 2.5 * kEpsilon * std::max({length_[a], length_[b], length_[c]});
  }

  /// The facet nearest to the origin, or -1 where one turns its outer side to it.
  int nearest_facet() {
    int nearest = least_facet();
    while (nearest >= 0 && has(slim_, nearest)) {  // only now is it worth its exact normal
      lay_exactly(nearest);
      if (distance_[nearest] < -rounding_) return -1;
      nearest = least_facet();
    }
    return nearest;
  }

  int least_facet() const {
    Lanes least = Lanes::of(sure_);
    for (int f = 4; f < facet_count_; f += 4) least = least.smaller(Lanes::of(sure_ + f));
    const double sure = least.least();
    if (!(sure < kInfinity)) return -1;
    int f = 0;
    unsigned there;
    while ((there = ~Lanes::all(sure).below(Lanes::of(sure_ + f)) & 0xfu) == 0) f += 4;
    return f + std::countr_zero(there);
  }

  /// The normals of four facets along a vector.
  Lanes along(int f, const Vector3& v) const {
    return Lanes::of(normal_x_ + f) * Lanes::all(v.x()) +
           Lanes::of(normal_y_ + f) * Lanes::all(v.y()) +
           Lanes::of(normal_z_ + f) * Lanes::all(v.z());
  }

  /// Takes away the facets that see a new corner and hang together with the first. The sides around
  /// the hole come in order; false: they do not close.
  bool open(int first, const Vector3& w) {
    std::array<Number, kMostFacets / 4> seeing;
    for (int f = 0; f < facet_count_; f += 4) {
      seeing[index(f / 4)] = number(Lanes::of(distance_ + f).below(along(f, w)));
    }
    std::array<Step, kMostSides> stack;
    int height = 0;
    sides_ = 0;
    const auto take = [&](int f) {
      taken_[index(f / 4)] = number(taken_[index(f / 4)] | 1 << f % 4);
      retire(f);
    };
    take(first);
    for (int k = 2; k >= 0; --k) stack[index(height++)] = {number(first), number(k)};
    Number last = corners_of(first)[0];
    while (height > 0) {
      const Step step = stack[index(--height)];
      const Number next = neighbours(step.facet)[step.side];
      if (has(taken_, next)) continue;
      const Number from = corners_of(step.facet)[step.side];
      const Number to = corners_of(step.facet)[step.side < 2 ? step.side + 1u : 0u];
      const Three& cycle = corners_of(next);
      const int entry = cycle[0] == to ? 0 : cycle[1] == to ? 1 : 2;
      if (has(seeing, next)) {
        if (height + 2 > kMostSides) return false;
        take(next);
        stack[index(height++)] = {next, number(entry > 0 ? entry - 1 : 2)};
        stack[index(height++)] = {next, number(entry < 2 ? entry + 1 : 0)};
      } else {
        if (from != last || sides_ == kMostSides) return false;
        from_[index(sides_)] = from;
        facet_[index(sides_)] = next;
        place_[index(sides_++)] = number(entry);
        last = to;
      }
    }
    return last == from_[0];
  }

  void finish(int nearest, FastResult& result) {
    const Vector3 n = normal(nearest);
    const double limit = distance_[nearest] + 8 * rounding_;
    for (int f = 0; f < facet_count_; f += 4) {  // another as good: for the exhaustive way to judge
      const unsigned near = ~Lanes::all(limit).below(Lanes::of(distance_ + f));
      if ((near & along(f, n).below(Lanes::all(1.0 - 1e-9))) != 0) return;
    }
    result.outcome = FastOutcome::Overlapping;
    result.normal = -n;
    result.bound = -sure_[nearest];
    result.corners = 3;
    for (std::size_t k = 0; k < 3; ++k) {
      result.p[k] = vertex_p_[corners_of(nearest)[k]];
      result.q[k] = vertex_q_[corners_of(nearest)[k]];
    }
  }

  static constexpr double kSlim = 0.25;  // sine; the normal is that of doubles that have cancelled
  static constexpr double kNoArea = 1e-14;  // sine

  const Polyhedron& p_;
  const Polyhedron& q_;
  double rounding_;
  int corner_count_ = 0, facet_count_ = 0;
  double x_[kMostCorners], y_[kMostCorners], z_[kMostCorners], length_[kMostCorners];  // m
  int vertex_p_[kMostCorners], vertex_q_[kMostCorners];
  alignas(64) double normal_x_[kMostFacets], normal_y_[kMostFacets], normal_z_[kMostFacets];
  alignas(64) double distance_[kMostFacets];                   // of the planes from the origin, m
  alignas(64) double sure_[kMostFacets];                       // the same less their rounding
  std::array<Number, kMostFacets / 4> slim_, taken_{};         // one bit a facet
  std::array<Three, kMostFacets> facet_corners_, neighbours_;  // [k] lies across side k
  // The sides around a hole: their first corner, the facet beyond and which of its sides it is.
  int sides_ = 0;
  std::array<Number, kMostSides + 16> from_, facet_, place_;
};

#ifdef QUOIN_WIDE_LANES
QUOIN_AVX512 [[gnu::flatten]] FastResult overlap_512(const Polyhedron& p, const Polyhedron& q,
                                                     const FastResult& start, double rounding) {
  return Polytope<Scan512, Lanes256>(p, q, rounding).grow(start);
}
QUOIN_AVX2 [[gnu::flatten]] FastResult overlap_256(const Polyhedron& p, const Polyhedron& q,
                                                   const FastResult& start, double rounding) {
  return Polytope<Scan256, Lanes256>(p, q, rounding).grow(start);
}
#endif

}  // namespace

FastResult fast_overlap(const Polyhedron& p, const Polyhedron& q, const FastResult& start,
                        double rounding) {
#ifdef QUOIN_WIDE_LANES
  if (has_avx512()) return overlap_512(p, q, start, rounding);
  if (has_avx2()) return overlap_256(p, q, start, rounding);
#endif
  return Polytope<PlainScan, PlainLanes>(p, q, rounding).grow(start);
}

}  // namespace quoin::geometry
